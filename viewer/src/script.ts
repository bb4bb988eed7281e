// What scripts and tests may do with the page: window.radiosity.

import type { App } from "./app";
import type { LampSetting } from "./mixing";
import type { Reading } from "./reading";

declare global {
  interface Window {
    radiosity: Script;
  }
}

export class Script {
  constructor(readonly app: App) {}

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

  private numbered(which: number | string, all: { name: string }[], kind: string): number {
    const number = typeof which === "number" ? which : all.findIndex(({ name }) => name === which);
    if (!all[number]) throw new Error(`there is no ${kind} "${which}" among ${all.map(({ name }) => name).join(", ")}`);
    return number;
  }
}
