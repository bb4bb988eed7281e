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

export class LightPanels {
  readonly control: Control;
  readonly probe: Probe;
  readonly lamps: Lamps;
  readonly paint: Paint;
  readonly progress: Progress;

  constructor(
    private readonly app: App,
    private readonly rays: Rays,
  ) {
    const overlay = new Overlay(app.stage);
    this.control = new Control(app);
    this.progress = new Progress(app, this.control);
    this.lamps = new Lamps(app, this.control);
    this.paint = new Paint(app, this.control, overlay);
    this.probe = new Probe(app, overlay, (origin, direction) => rays.closest(origin, direction));
    new Notices(app);
    addEventListener("keydown", (event) => event.key === "Escape" && this.probe.close());
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

  /** Adds what is read. A panel is there while it has something to say. */
  addReadings(sidebar: Sidebar): void {
    sidebar.add("Solution", this.progress.element);
    const probe = sidebar.add("Probe", this.probe.element);
    probe.isThere = false;
    this.probe.onToggle = (isOpen) => {
      probe.isThere = isOpen;
      if (isOpen) sidebar.show(probe);
    };
  }

  /** Adds what changes the light. */
  addControls(sidebar: Sidebar): void {
    const lamps = sidebar.add("Lamps", this.lamps.element);
    const paint = sidebar.add("Paint", this.paint.element, false);
    lamps.isThere = paint.isThere = false;
    this.app.events.on("scene", ({ head }) => {
      lamps.isThere = head.lamps.length > 0;
      paint.isThere = this.app.link !== null;
    });
  }
}
