// What keys, mouse and fingers do.

import { h } from "./dom";
import type { Shortcut } from "./keyboard";
import { button } from "./ui";

const MOVING: [string, string][] = [
  ["W A S D, ↑ ↓", "Walk; starts walking from orbit, too"],
  ["← →", "Turn"],
  ["Shift", "Three times as fast"],
  ["E or Space, Q or C", "Up and down, when flying"],
];

const MOUSE: [string, string][] = [
  ["Click", "What light arrives there, and from where (orbit)"],
  ["Drag, wheel", "Orbit: turn, come nearer; with the right button, shift"],
  ["Click, then move", "Walk and fly: look around; click again to probe, Esc ends it"],
  ["Drag, wheel", "Walk and fly: look around, take a step"],
];

const TOUCH: [string, string][] = [
  ["One finger", "Turn, or look around"],
  ["Two fingers", "Come nearer, shift; walk"],
  ["Stick", "Walk"],
  ["Tap", "What light arrives there, and from where"],
];

export class Help {
  readonly element = h("dialog", { className: "help", ariaLabel: "Keys" });

  constructor(shortcuts: Shortcut[]) {
    const close = button({ label: "×", title: "Close" }, () => this.element.close());
    close.className = "plain";
    const keys = shortcuts.map(({ keys, label }): [string, string] => [keys.map(printed).join(" or "), label]);
    this.element.append(
      h("header", {}, h("h2", {}, "Keys and gestures"), close),
      h("div", { className: "columns" }, part("Moving", MOVING), part("Keys", keys), part("Mouse", MOUSE), part("Touch", TOUCH)),
    );
    this.element.addEventListener("click", (event) => event.target === this.element && this.element.close());
  }

  toggle(): void {
    if (this.element.open) this.element.close();
    else this.element.showModal();
  }
}

function part(title: string, rows: [string, string][]): HTMLElement {
  const lines = rows.map(([keys, text]) => h("tr", {}, h("th", { scope: "row" }, ...caps(keys)), h("td", {}, text)));
  return h("section", {}, h("h3", {}, title), h("table", {}, h("tbody", {}, ...lines)));
}

function caps(keys: string): (Node | string)[] {
  return keys.split(/( or |, )/).map((part, k) => (k % 2 ? part : h("kbd", {}, part)));
}

function printed(key: string): string {
  return key.length === 1 ? key.toUpperCase() : key[0].toUpperCase() + key.slice(1);
}
