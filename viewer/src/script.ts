// What scripts and tests may do with the page: window.radiosity. In the console of the browser, or from a test that
// drives it:
//
//   await radiosity.ready;                                    the first picture is there
//   radiosity.setSettings({ falseColours: true, map: "turbo" });   settings.ts has all names
//   radiosity.look([1, 1.6, 4], [0, 1, 0]);                   from where to where, metres, where the file has it
//   radiosity.mode = "walk";                                  or "fly", "orbit"
//   radiosity.step(2, ["KeyW"], true);                        two seconds of W and Shift at 60 pictures a second
//   radiosity.position;                                       where the eyes are
//   radiosity.pick(200, 100);                                 the patch at a pixel of the picture
//   radiosity.probe(200, 100);                                and the light there
//   radiosity.statistics;                                     pictures a second, milliseconds of script for one

import { Vector3 } from "three";
import type { App } from "./app";
import type { LampSetting } from "./mixing";
import type { Mode } from "./navigation";
import type { Place, Reading } from "./reading";
import type { Settings } from "./settings";
import type { Speed } from "./statistics";

declare global {
  interface Window {
    radiosity: Script;
  }
}

/** Seconds of one picture of `step`. */
const PICTURE = 1 / 60;

type Triple = [number, number, number];

export class Script {
  /** Fulfilled when the first scene has been drawn. */
  readonly ready: Promise<void>;

  constructor(readonly app: App) {
    this.ready = new Promise((done) => app.stage.afterFrame.push(() => app.lit && done()));
  }

  /** How the light is shown. */
  get settings(): Settings {
    return { ...this.app.stage.settings };
  }

  setSettings(change: Partial<Settings>): void {
    this.app.set(change);
  }

  /** What multiplies the values of the picture before the tone curve. */
  get exposure(): number {
    return this.app.stage.exposure;
  }

  /** First and last value of the colour scale, in the unit shown. */
  get range(): [number, number] {
    return this.app.stage.range;
  }

  /** Where the eyes are, metres, where the file has it. */
  get position(): Triple {
    return this.inFile(this.app.stage.camera.position);
  }

  /** The unit vector of where they look. */
  get direction(): Triple {
    return this.app.stage.camera.getWorldDirection(new Vector3()).toArray();
  }

  get mode(): Mode {
    return this.app.navigation.mode;
  }

  /** On foot one stands near what was looked at, if one could not stand where one was. */
  set mode(mode: Mode) {
    this.app.navigation.setMode(mode);
    this.app.navigation.arrive();
  }

  /** Looks from a place to another; metres, where the file has them. */
  look(position: Triple, target: Triple): void {
    this.app.navigation.lookAt(this.inPage(position), this.inPage(target));
  }

  /**
   * Moves on as if keys were down for a while, by pictures of 1/60 s, whatever the time.
   *
   * @param keys codes of keys, such as "KeyW" or "ArrowLeft".
   * @param isFast whether Shift is down too.
   * @returns where the eyes are then.
   */
  step(seconds: number, keys: string[] = [], isFast = false): Triple {
    const { navigation, rays } = this.app;
    rays.now();
    if (keys.length && navigation.mode === "orbit") this.mode = "walk";
    navigation.keyboard.hold(keys, isFast);
    for (let left = seconds; left > 1e-9; left -= PICTURE) navigation.advance(Math.min(PICTURE, left));
    navigation.keyboard.hold([]);
    return this.position;
  }

  /**
   * What is seen at a place of the picture, whose position is in metres, where the file has it.
   *
   * @param x, y pixels from the upper left corner of the picture.
   * @returns null where no patch is.
   */
  pick(x: number, y: number): Place | null {
    const place = this.app.rays.pick(x, y);
    return place && { ...place, point: this.inFile(new Vector3(...place.point)) };
  }

  /** Draws now, exposed for just this view. */
  draw(): void {
    this.app.stage.draw();
  }

  /** How fast pictures are drawn. */
  get statistics(): Speed {
    return this.app.stage.statistics.speed;
  }

  /**
   * Opens the probe at a place of the picture and tells what it shows, in the unit of the scene.
   *
   * @param x, y pixels from the upper left corner of the picture.
   * @returns null where no patch is.
   */
  probe(x: number, y: number): Reading | null {
    return this.app.light.read(x, y);
  }

  /** How lamps are set, in the order of the panel. */
  get lamps(): LampSetting[] {
    return this.app.light.control.lamps;
  }

  /** Sets a lamp by its number or name. Throws an Error that says why not, or that there is no such lamp. */
  setLamp(which: number | string, change: Partial<LampSetting>): void {
    const { control } = this.app.light;
    if (control.lampsFixed) throw new Error(control.lampsFixed);
    control.setLamp(this.numbered(which, this.app.lit?.head.lamps ?? [], "lamp"), change);
  }

  /** Paints a surface by its number or name, with a reflectance a band; null gives it back the paint of the scene. */
  paint(which: number | string, reflectance: number[] | null): void {
    const { control } = this.app.light;
    if (control.paintFixed) throw new Error(control.paintFixed);
    control.paint(this.numbered(which, this.app.lit?.head.surfaces ?? [], "surface"), reflectance);
  }

  private inFile(point: Vector3): Triple {
    return point.clone().add(new Vector3(...this.origin)).toArray();
  }

  private inPage(point: Triple): Vector3 {
    return new Vector3(...point).sub(new Vector3(...this.origin));
  }

  private get origin(): Triple {
    return this.app.lit?.head.origin ?? [0, 0, 0];
  }

  private numbered(which: number | string, all: { name: string }[], kind: string): number {
    const number = typeof which === "number" ? which : all.findIndex(({ name }) => name === which);
    if (!all[number]) throw new Error(`there is no ${kind} "${which}" among ${all.map(({ name }) => name).join(", ")}`);
    return number;
  }
}
