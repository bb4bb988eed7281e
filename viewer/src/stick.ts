// A stick for the thumb, where there are fingers and no keys.

import { h } from "./dom";

export class Stick {
  readonly element: HTMLElement;
  /** -1 to 1. */
  ahead = 0;
  right = 0;
  /** Called when it is taken. */
  onTake: () => void = () => {};
  private readonly knob = h("span", {});
  private pointer: number | null = null;

  constructor() {
    this.element = h("div", { className: "stick", "aria-hidden": "true" }, this.knob);
    const { element } = this;
    element.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      this.pointer = event.pointerId;
      element.setPointerCapture(event.pointerId);
      this.point(event);
      this.onTake();
    });
    element.addEventListener("pointermove", (event) => event.pointerId === this.pointer && this.point(event));
    for (const end of ["pointerup", "pointercancel"] as const) element.addEventListener(end, () => this.set(0, 0));
  }

  private point({ clientX, clientY }: PointerEvent): void {
    const { left, top, width, height } = this.element.getBoundingClientRect();
    const x = (2 * (clientX - left)) / width - 1;
    const y = 1 - (2 * (clientY - top)) / height;
    const length = Math.max(Math.hypot(x, y), 1);
    this.set(y / length, x / length);
  }

  private set(ahead: number, right: number): void {
    if (!ahead && !right) this.pointer = null;
    this.ahead = ahead;
    this.right = right;
    this.knob.style.transform = `translate(${70 * right}%, ${-70 * ahead}%)`;
  }
}
