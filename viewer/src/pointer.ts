// Mouse and fingers on the picture, for whoever walks: one looks around, two walk, and the wheel takes a step.

/** Radians for a pixel while the mouse is captured. */
const CAPTURED = 0.0022;

/** Pixels that a pointer may move in a click, and milliseconds that it lasts at most. */
const STILL = 4;
const SHORT = 500;

/** A captured mouse now and then jumps by itself. */
const JUMP = 300;

export interface Gestures {
  /** Radians to the left and upwards. */
  look(yaw: number, pitch: number): void;
  /** A share of the height of the picture, forwards and to the right. */
  walk(ahead: number, right: number): void;
  /** Notches of the wheel, away from the user. */
  wheel(notches: number): void;
  /** Pixels from the upper left corner of the picture. */
  click(x: number, y: number, isMouse: boolean): void;
}

export class Pointer {
  /** Whether the picture is moved here, and not by somebody else; clicks are told in any case. */
  isActive = false;
  private readonly down = new Map<number, PointerEvent>();
  private first: PointerEvent | null = null;
  private isStill = false;

  /** @param angle radians that one pixel of the picture shows. */
  constructor(
    private readonly canvas: HTMLElement,
    private readonly gestures: Gestures,
    private readonly angle: () => number,
  ) {
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.release(event, true));
    canvas.addEventListener("pointercancel", (event) => this.release(event, false));
    canvas.addEventListener("wheel", (event) => this.roll(event), { passive: false });
  }

  /** Whether the mouse is captured: it looks around without a button, and points at the middle. */
  get isCaptured(): boolean {
    return document.pointerLockElement === this.canvas;
  }

  async capture(): Promise<void> {
    try {
      await this.canvas.requestPointerLock();
    } catch {
      // Some browsers and frames do not let pages have it; dragging looks around as well.
    }
  }

  free(): void {
    if (this.isCaptured) document.exitPointerLock();
  }

  private press(event: PointerEvent): void {
    if (this.isCaptured) return this.gestures.click(this.canvas.clientWidth / 2, this.canvas.clientHeight / 2, true);
    this.canvas.focus({ preventScroll: true });
    this.isStill = this.down.size === 0 && event.button === 0;
    this.first = event;
    this.down.set(event.pointerId, event);
    if (this.isActive) this.canvas.setPointerCapture(event.pointerId);
  }

  private move(event: PointerEvent): void {
    if (this.isCaptured) {
      if (Math.abs(event.movementX) + Math.abs(event.movementY) < JUMP)
        this.gestures.look(-event.movementX * CAPTURED, -event.movementY * CAPTURED);
      return;
    }
    const last = this.down.get(event.pointerId);
    if (!last) return;
    if (this.first && Math.hypot(event.clientX - this.first.clientX, event.clientY - this.first.clientY) > STILL)
      this.isStill = false;
    if (this.isActive) this.drag(event.clientX - last.clientX, event.clientY - last.clientY, event);
    this.down.set(event.pointerId, event);
  }

  /** What was seized stays under the finger. */
  private drag(x: number, y: number, event: PointerEvent): void {
    if (this.down.size === 1) return this.gestures.look(x * this.angle(), y * this.angle());
    const other = [...this.down.values()].find(({ pointerId }) => pointerId !== event.pointerId)!;
    const last = this.down.get(event.pointerId)!;
    const apart = (one: PointerEvent) => Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY);
    const height = this.canvas.clientHeight;
    this.gestures.walk((apart(event) - apart(last) + y / 2) / height, -x / 2 / height);
  }

  private release(event: PointerEvent, isUp: boolean): void {
    const { first } = this;
    this.down.delete(event.pointerId);
    const isClick = isUp && this.isStill && first?.pointerId === event.pointerId && event.timeStamp - first.timeStamp <= SHORT;
    if (isClick) this.gestures.click(event.offsetX, event.offsetY, event.pointerType === "mouse");
  }

  private roll(event: WheelEvent): void {
    if (!this.isActive) return;
    event.preventDefault();
    const pixels = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 * event.deltaY : event.deltaY;
    this.gestures.wheel(Math.min(Math.max(-pixels / 100, -3), 3));
  }
}
