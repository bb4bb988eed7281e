// The panels that tell about light, and clicks on the picture that they answer.

import type { App } from "../app";
import { Control } from "../control";
import { Notices } from "../notices";
import { Overlay } from "../overlay";
import type { Rays } from "../rays";
import type { Reading } from "../reading";
import type { Sidebar } from "../ui";
import { Lamps } from "./lamps";
import { Paint } from "./paint";
import { Probe } from "./probe";
import { Progress } from "./progress";

/** Pixels that a pointer may move in a click. */
const STILL = 4;

/** Milliseconds that a click lasts at most. */
const SHORT = 500;

export class LightPanels {
  readonly control: Control;
  readonly probe: Probe;
  readonly lamps: Lamps;
  readonly paint: Paint;
  readonly progress: Progress;

  constructor(
    private readonly app: App,
    sidebar: Sidebar,
    private readonly rays: Rays,
  ) {
    const overlay = new Overlay(app.stage);
    this.control = new Control(app);
    this.progress = new Progress(app, this.control);
    this.lamps = new Lamps(app, this.control);
    this.paint = new Paint(app, this.control, overlay);
    this.probe = new Probe(app, overlay, (origin, direction) => rays.closest(origin, direction));
    new Notices(app);
    this.fill(sidebar);
    this.listen();
  }

  /** Opens the probe at a place of the picture, pixels from its upper left corner; closes it where nothing is. */
  click(x: number, y: number): void {
    const place = this.app.lit && this.rays.pick(x, y);
    if (!place) return this.probe.close();
    this.paint.choose(this.app.lit!.surface[place.patch], false);
    this.probe.open(place);
  }

  /** The same, with what the probe reads then. */
  read(x: number, y: number): Reading | null {
    this.click(x, y);
    return this.probe.reading;
  }

  /** A panel is there while it has something to say. */
  private fill(sidebar: Sidebar): void {
    sidebar.add("Solution", this.progress.element);
    const probe = sidebar.add("Probe", this.probe.element);
    const lamps = sidebar.add("Lamps", this.lamps.element);
    const paint = sidebar.add("Paint", this.paint.element, false);
    probe.isThere = lamps.isThere = paint.isThere = false;
    this.probe.onToggle = (isOpen) => {
      probe.isThere = isOpen;
      if (isOpen) sidebar.show(probe);
    };
    this.app.events.on("scene", ({ head }) => {
      sidebar.title = head.title;
      lamps.isThere = head.lamps.length > 0;
      paint.isThere = this.app.link !== null;
    });
  }

  /** A click is a pointer that goes down and up again without having moved. */
  private listen(): void {
    const { canvas } = this.app;
    let down: PointerEvent | null = null;
    canvas.addEventListener("pointerdown", (event) => (down = event.isPrimary && event.button === 0 ? event : null));
    canvas.addEventListener("pointerup", (event) => {
      if (!down || event.pointerId !== down.pointerId || document.pointerLockElement) return;
      const moved = Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY);
      if (moved <= STILL && event.timeStamp - down.timeStamp <= SHORT) this.click(event.offsetX, event.offsetY);
      down = null;
    });
    addEventListener("keydown", (event) => event.key === "Escape" && this.probe.close());
  }
}
