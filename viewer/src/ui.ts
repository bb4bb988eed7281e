// The kit that panels are made of: a sidebar of panels that open and close, and labelled controls. All of it is native
// elements, so that keyboards, screen readers and phones know what to do.

import { h } from "./dom";
import { icon, type Icon } from "./icons";

/** A part of the sidebar under a heading that opens and closes it. */
export class Panel {
  readonly element: HTMLElement;
  private readonly button: HTMLButtonElement;
  private readonly body: HTMLElement;

  constructor(title: string, body: HTMLElement, isOpen = true) {
    this.button = h("button", { type: "button" }, title);
    this.body = h("div", { className: "panel-body" }, body);
    this.element = h("section", { className: "panel", "aria-label": title }, h("h2", {}, this.button), this.body);
    this.button.onclick = () => (this.isOpen = !this.isOpen);
    this.isOpen = isOpen;
  }

  get isOpen(): boolean {
    return !this.body.hidden;
  }

  set isOpen(isOpen: boolean) {
    this.body.hidden = !isOpen;
    this.button.setAttribute("aria-expanded", String(isOpen));
  }

  /** Whether there is anything to show at all. */
  set isThere(isThere: boolean) {
    this.element.hidden = !isThere;
  }
}

/** Pixels of a panel that must be in sight. */
const LEAST = 160;

/** Pixels that the heading of the sidebar covers. */
const HEADING = 40;

/** All panels; beside the picture, or a sheet below it where that is narrow. */
export class Sidebar {
  readonly element = h("aside", { className: "sidebar", id: "sidebar", "aria-label": "Panels" });
  private readonly heading = h("h1", {});
  private readonly opener = iconButton("panels", { label: "Show the panels" }, () => (this.isOpen = true));

  constructor(root: HTMLElement) {
    const closer = button({ label: "×", title: "Hide the panels" }, () => (this.isOpen = false));
    closer.className = "plain";
    this.opener.classList.add("sidebar-opener");
    this.element.append(h("header", {}, this.heading, closer));
    root.append(this.element, this.opener);
    this.isOpen = true;
  }

  set title(title: string) {
    this.heading.textContent = title;
  }

  /** Puts a panel below the others. */
  add(title: string, body: HTMLElement, isOpen = true): Panel {
    const panel = new Panel(title, body, isOpen);
    this.element.append(panel.element);
    return panel;
  }

  /** Scrolls to a panel unless it can be seen. */
  show(panel: Panel): void {
    const [own, all] = [panel.element.getBoundingClientRect(), this.element.getBoundingClientRect()];
    if (own.top + LEAST > all.bottom || own.top < all.top) this.element.scrollTop += own.top - all.top - HEADING;
  }

  get isOpen(): boolean {
    return !this.element.hidden;
  }

  set isOpen(isOpen: boolean) {
    this.element.hidden = !isOpen;
    this.opener.hidden = isOpen;
  }
}

interface Range {
  min: number;
  max: number;
  step?: number | "any";
}

type Named = { label: string; title?: string };

export function slider({ label, title, min, max, step = "any" }: Named & Range, input: (value: number) => void): HTMLInputElement {
  const element = h("input", { type: "range", min: String(min), max: String(max), step: String(step), "aria-label": label, title });
  element.oninput = () => input(element.valueAsNumber);
  return element;
}

/** A field for a number, which is kept within its range. */
export function numberField(
  { label, title, min, max, step = "any" }: Named & Range, change: (value: number) => void,
): HTMLInputElement {
  const element = h("input", { type: "number", min: String(min), max: String(max), step: String(step), "aria-label": label, title });
  element.onchange = () => {
    const value = Math.min(Math.max(element.valueAsNumber || 0, min), max);
    element.valueAsNumber = value;
    change(value);
  };
  return element;
}

export function colourField({ label, title }: Named, input: (colour: string) => void): HTMLInputElement {
  const element = h("input", { type: "color", "aria-label": label, title });
  element.oninput = () => input(element.value);
  return element;
}

export function button({ label, title }: Named, click: () => void): HTMLButtonElement {
  const element = h("button", { type: "button", title }, label);
  element.onclick = click;
  return element;
}

/** A switch with its name beside it. */
export function toggle({ label, title }: Named, change: (isOn: boolean) => void): { element: HTMLElement; input: HTMLInputElement } {
  const input = h("input", { type: "checkbox", role: "switch" });
  input.onchange = () => change(input.checked);
  return { input, element: h("label", { className: "toggle", title }, input, h("span", {}, label)) };
}

/** A choice of one of several values, by the names that they are shown under. */
export function select<Value extends string>(
  { label, title }: Named, options: readonly (readonly [Value, string])[], change: (value: Value) => void,
): HTMLSelectElement {
  const element = h(
    "select", { "aria-label": label, title }, ...options.map(([value, name]) => h("option", { value }, name)),
  );
  element.onchange = () => change(element.value as Value);
  return element;
}

/** A name on the left, controls on the right. */
export function field(label: string, ...controls: HTMLElement[]): HTMLElement {
  return h("div", { className: "field" }, h("span", { className: "field-name" }, label), ...controls);
}

/** A button with a picture, whose name appears when it is pointed at. */
export function iconButton(name: Icon, { label, title = label }: Named, click: () => void): HTMLButtonElement {
  const element = h("button", { type: "button", className: "icon-button", ariaLabel: label, title }, icon(name));
  element.onclick = click;
  return element;
}

/** How many groups of radio buttons there are: each needs a name of its own. */
let groups = 0;

/** A choice of one of few values, all of which are seen. */
export function segmented<Value extends string>(
  { label, title }: Named, options: readonly (readonly [Value, string | Node, string?])[], change: (value: Value) => void,
): { element: HTMLElement; set: (value: Value) => void } {
  const name = `choice-${groups++}`;
  const inputs = options.map(([value, , title]) => {
    const input = h("input", { type: "radio", name, value, ariaLabel: title });
    input.onchange = () => change(value);
    return input;
  });
  const labels = options.map(([, shown, title], k) => h("label", { title }, inputs[k], h("span", {}, shown)));
  const element = h("div", { className: "segmented", role: "radiogroup", ariaLabel: label, title }, ...labels);
  return { element, set: (value) => inputs.forEach((input) => (input.checked = input.value === value)) };
}
