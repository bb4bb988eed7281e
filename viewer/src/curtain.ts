// What is said instead of the picture, and beside it when something about it is to be known.

import { h } from "./dom";
import { button } from "./ui";

export class Curtain {
  readonly element = h("div", { className: "curtain", role: "status" });
  private readonly heading = h("h2", {});
  private readonly text = h("p", {});
  private readonly dots = h("div", { className: "busy", "aria-hidden": "true" }, h("i", {}), h("i", {}), h("i", {}));

  constructor() {
    this.element.append(h("div", {}, this.dots, this.heading, this.text));
    this.element.hidden = true;
  }

  /** @param text what stands between backquotes is to be typed. @param isBusy whether something is on its way. */
  say(heading: string, text: string, isBusy = false): void {
    this.heading.textContent = heading;
    this.text.replaceChildren(...text.split("`").map((part, k) => (k % 2 ? h("code", {}, part) : part)));
    this.dots.hidden = !isBusy;
    this.element.hidden = false;
  }

  rise(): void {
    this.element.hidden = true;
  }
}

/** One line over the picture. */
export class Banner {
  readonly element = h("div", { className: "banner", role: "status" });
  private timer: ReturnType<typeof setTimeout> | undefined;
  /** What is said until it is no longer so. */
  private lasting = "";

  constructor() {
    this.element.hidden = true;
  }

  /** Says something for a while. */
  say(text: string, milliseconds = 4000): void {
    this.write(text);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.write(this.lasting), milliseconds);
  }

  /** Says something until it is dismissed or this is called with nothing. */
  keep(text: string): void {
    this.lasting = text;
    clearTimeout(this.timer);
    this.write(text);
  }

  private write(text: string): void {
    const close = button({ label: "×", title: "Dismiss" }, () => this.keep(""));
    close.className = "plain";
    this.element.replaceChildren(h("span", {}, text), close);
    this.element.hidden = !text;
  }
}
