// Buttons over the picture: ways to move, and what is done with the picture.

import type { Commands } from "../commands";
import { h } from "../dom";
import { icon } from "../icons";
import type { Mode, Navigation } from "../navigation";
import { iconButton, segmented } from "../ui";

export class Toolbar {
  readonly element = h("div", { className: "toolbar", role: "toolbar", "aria-label": "View" });

  constructor(navigation: Navigation, commands: Commands) {
    const modes = segmented<Mode>(
      { label: "Way to move" },
      [
        ["orbit", named("orbit", "Orbit"), "Orbit: around what you look at (O)"],
        ["walk", named("walk", "Walk"), "Walk: on foot (W A S D)"],
        ["fly", named("fly", "Fly"), "Fly: without gravity (G)"],
      ],
      (mode) => navigation.setMode(mode),
    );
    modes.set(navigation.mode);
    navigation.events.on("mode", (mode) => modes.set(mode));
    this.element.append(
      modes.element,
      h(
        "div", { className: "actions" },
        iconButton("home", { label: "First view (Home)" }, () => navigation.goTo(0)),
        iconButton("picture", { label: "Save the picture (P)" }, () => commands.savePicture()),
        iconButton("link", { label: "Copy a link to this view (L)" }, () => void commands.copyLink()),
        iconButton("full", { label: "Full screen (F)" }, () => void commands.fullScreen()),
        iconButton("hide", { label: "Hide all but the picture (U)" }, () => commands.hideAll()),
        iconButton("help", { label: "Keys (? or H)" }, () => commands.help()),
      ),
    );
  }
}

function named(name: "orbit" | "walk" | "fly", text: string): HTMLElement {
  return h("span", { className: "named" }, icon(name), h("span", {}, text));
}
