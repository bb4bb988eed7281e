// What keys and buttons do beside moving.

import type { App } from "./app";
import { Help } from "./help";
import type { Shortcut } from "./keyboard";
import { written } from "./state";

export class Commands {
  readonly shortcuts: Shortcut[];
  private readonly helping: Help;

  constructor(private readonly app: App) {
    this.shortcuts = this.list();
    app.navigation.keyboard.shortcuts = this.shortcuts;
    this.helping = new Help(this.shortcuts);
    app.root.append(this.helping.element);
  }

  help(): void {
    this.helping.toggle();
  }

  /** Shows nothing but the picture, or all again. */
  hideAll(): void {
    const isBare = this.app.page.classList.toggle("bare");
    if (isBare) this.app.banner.say("Press U or tap the picture's corner to have all back.", 2500);
  }

  async fullScreen(): Promise<void> {
    try {
      if (document.fullscreenElement) await document.exitFullscreen();
      else await document.documentElement.requestFullscreen();
    } catch {
      this.app.banner.say("This browser does not let the page fill the screen.");
    }
  }

  /** Downloads the picture as a PNG, with the colour scale if it has one. */
  savePicture(): void {
    this.picture().toBlob((blob) => {
      if (!blob) return this.app.banner.say("The picture is too large for this browser to save: make the window smaller.");
      const link = document.createElement("a");
      link.href = URL.createObjectURL(blob);
      link.download = `${document.title.replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, "") || "picture"}.png`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
    }, "image/png");
  }

  /** Puts the address of this view, with the settings, on the clipboard and in the address of the page. */
  async copyLink(): Promise<void> {
    const hash = written(this.app.state);
    history.replaceState(null, "", hash);
    try {
      await navigator.clipboard.writeText(location.href);
      this.app.banner.say("The address of this view is on the clipboard.");
    } catch {
      this.app.banner.say("The address of the page is that of this view now.");
    }
  }

  /** The picture as it is on the screen. */
  picture(): HTMLCanvasElement {
    const { stage, canvas, legend } = this.app;
    stage.draw();
    const copy = document.createElement("canvas");
    copy.width = canvas.width;
    copy.height = canvas.height;
    const context = copy.getContext("2d")!;
    context.drawImage(canvas, 0, 0);
    const scale = canvas.width / Math.max(canvas.clientWidth, 1);
    const inset = document.createElement("canvas");
    inset.width = legend.element.width;
    inset.height = legend.element.height;
    const drawing = inset.getContext("2d")!;
    drawing.scale(devicePixelRatio, devicePixelRatio);
    if (legend.drawInto(drawing))
      context.drawImage(inset, 12 * scale, 12 * scale, (inset.width / devicePixelRatio) * scale, (inset.height / devicePixelRatio) * scale);
    return copy;
  }

  private list(): Shortcut[] {
    const { app } = this;
    const { navigation } = app;
    const flip = (name: "falseColours" | "isolines" | "mesh" | "smooth") => () => app.set({ [name]: !app.stage.settings[name] });
    const key = (keys: string, label: string, run: () => void): Shortcut => ({ keys: keys.split(" "), label, run });
    return [
      key("o", "Orbit", () => navigation.setMode("orbit")),
      key("g", "Fly, or walk", () => navigation.setMode(navigation.mode === "fly" ? "walk" : "fly")),
      key("home 0", "First view", () => navigation.goTo(0)),
      key("n", "Next camera", () => navigation.goTo((navigation.camera + 1) % (app.lit?.head.cameras.length ?? 1))),
      key("x", "False colours", flip("falseColours")),
      key("i", "Isolines", flip("isolines")),
      key("m", "Edges of patches", flip("mesh")),
      key("b", "Values smooth, or by patch", flip("smooth")),
      key("p", "Save the picture", () => this.savePicture()),
      key("l", "Copy a link to this view", () => void this.copyLink()),
      key("f", "Full screen", () => void this.fullScreen()),
      key("u", "Hide all but the picture", () => this.hideAll()),
      key("t", "Pictures a second", () => app.toggleStatistics()),
      key("? h", "These keys", () => this.help()),
    ];
  }
}
