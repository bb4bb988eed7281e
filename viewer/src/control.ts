// What may be changed about the light, and how: lamps mixed here or relit by the session, paint relit by the session.

import type { App } from "./app";
import { Events } from "./events";
import type { Status } from "./messages";
import { AS_IN_SCENE, isChanged, solo, weights, type LampSetting } from "./mixing";
import { Relighting } from "./relight";

interface Changes {
  /** Lamps or paint are set otherwise. */
  settings: undefined;
  /** What may be changed is another. */
  means: undefined;
}

/** Paint reflects less than all light, as the solver wants it. */
export const MOST_REFLECTANCE = 0.99;

/** The option is held together by word joiners. */
const HINT = "To switch lamps, open the scene with “radiosity view”, or export it with -\u2060-\u2060layers.";

export class Control {
  readonly events = new Events<Changes>();
  readonly relighting: Relighting;
  lamps: LampSetting[] = [];
  status: Status | null = null;
  private isClosed = false;
  /** Whether patches came that do not have the paint and lamps that are set. */
  private isNew = false;

  constructor(private readonly app: App) {
    this.relighting = new Relighting((message) => app.link?.send(message) ?? false);
    app.events.on("scene", () => this.begin());
    app.events.on("head", (head) => {
      if (head.type === "scene") this.relighting.answered(null);
      // What is nearly right answers too: the next question need not wait for the rest.
      else this.relighting.answered(head.seconds);
    });
    app.events.on("message", (message) => {
      if (message.type === "failed") this.relighting.answered(null);
      if (message.type === "status") this.heard(message);
    });
    app.events.on("closed", () => {
      this.isClosed = true;
      this.relighting.forget();
      this.events.emit("means", undefined);
    });
  }

  /** Whether the light of each lamp is here, so that it is mixed in no time. */
  get isLayered(): boolean {
    return this.app.lit?.head.is_layered ?? false;
  }

  get canRelight(): boolean {
    return !this.isClosed && (this.status?.can_relight ?? false);
  }

  /** Why lamps cannot be switched; empty if they can. */
  get lampsFixed(): string {
    if (this.isLayered || !this.paintFixed) return "";
    return this.app.link ? this.paintFixed : `${this.paintFixed} ${HINT}`;
  }

  /** Why nothing can be painted; empty if it can. */
  get paintFixed(): string {
    if (this.canRelight) return "";
    if (this.isClosed) return "The program that served this page has ended.";
    if (!this.app.link) return "This page shows light that was found before.";
    return this.status ? `Not now: ${this.status.text}` : "Waiting for the session.";
  }

  setLamp(which: number, change: Partial<LampSetting>): void {
    this.setLamps(this.lamps.map((lamp, k) => (k === which ? { ...lamp, ...change } : lamp)));
  }

  solo(which: number): void {
    this.setLamps(solo(this.lamps, which));
  }

  setLamps(lamps: LampSetting[]): void {
    const changed = lamps.flatMap((lamp, k) => (lamp === this.lamps[k] ? [] : [k]));
    this.lamps = lamps;
    if (this.isLayered) this.mix(changed);
    else this.relightLamps();
    this.events.emit("settings", undefined);
  }

  /** Paints a surface on both its sides; null gives it the paint that it has in the scene. */
  paint(surface: number, reflectance: number[] | null): void {
    const { paint } = this.relighting;
    const front = this.frontOf(surface);
    if (reflectance) paint.set(front, reflectance.map((r) => Math.min(Math.max(r, 0), MOST_REFLECTANCE)));
    else paint.delete(front);
    this.relighting.ask();
    this.events.emit("settings", undefined);
  }

  /** The paint that a surface was given; undefined where it has that of the scene. */
  paintOf(surface: number): number[] | undefined {
    return this.relighting.paint.get(this.frontOf(surface));
  }

  paintAsInScene(): void {
    this.relighting.paint.clear();
    this.relighting.ask();
    this.events.emit("settings", undefined);
  }

  stop(): void {
    this.app.link?.send({ type: "stop" });
  }

  /** Mixes the light of these lamps as they are set; the picture is drawn once. */
  private mix(which: number[]): void {
    which.slice(1).forEach((k) => this.app.lit!.mix(k, this.weights(k)));
    which.slice(0, 1).forEach((k) => this.app.mix(k, this.weights(k)));
  }

  private weights(which: number): number[] {
    return weights(this.lamps[which], this.app.lit!.bands);
  }

  private relightLamps(): void {
    const { lamps } = this.relighting;
    lamps.clear();
    this.lamps.forEach((lamp, k) => isChanged(lamp) && lamps.set(k, this.weights(k)));
    this.relighting.ask();
  }

  /** The surface whose back this is, or itself: backs follow all fronts (python/radiosity/files.py). */
  private frontOf(surface: number): number {
    const { surfaces } = this.app.lit!.head;
    const front = surface - surfaces.length / 2;
    return surfaces[surface].name === `${surfaces[front]?.name} (back)` ? front : surface;
  }

  /** Other patches: lamps keep what they are set to as far as they are the same. */
  private begin(): void {
    const { head } = this.app.lit!;
    if (this.lamps.length !== head.lamps.length) this.lamps = head.lamps.map(() => AS_IN_SCENE);
    if (head.is_layered) {
      this.relighting.lamps.clear(); // mixed here, they must not be dimmed there as well
      this.mix(this.lamps.flatMap((lamp, k) => (isChanged(lamp) ? [k] : [])));
    }
    this.isNew = true;
    this.events.emit("means", undefined);
  }

  private heard(status: Status): void {
    this.status = status;
    const { paint, lamps } = this.relighting;
    if (this.isNew && this.canRelight) {
      this.isNew = false;
      if (paint.size || lamps.size) this.relighting.ask();
    }
    this.events.emit("means", undefined);
  }
}
