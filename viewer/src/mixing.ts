// How lamps are set, and what that multiplies the light of each by.

import { linear } from "./colour";

export interface LampSetting {
  isOn: boolean;
  /** A factor; 1 is as in the scene. */
  dimmer: number;
  /** "#rrggbb" of a filter before it: white lets all through. */
  colour: string;
}

export const AS_IN_SCENE: LampSetting = { isOn: true, dimmer: 1, colour: "#ffffff" };

/** The brightest that a dimmer goes to. */
export const BRIGHTEST = 4;

/** What multiplies the light of a lamp, by band; colours say something of three bands only. */
export function weights(lamp: LampSetting, bands: number): number[] {
  const factor = lamp.isOn ? lamp.dimmer : 0;
  return bands === 3 ? linear(lamp.colour).map((c) => factor * c) : Array<number>(bands).fill(factor);
}

/** The factor at a place of a dimmer's slider, 0 to 1: fine near zero, as it was in the middle. */
export function dimmed(place: number): number {
  return BRIGHTEST * place ** 2;
}

/** The inverse of `dimmed`. */
export function dimmerPlace(factor: number): number {
  return Math.sqrt(Math.min(Math.max(factor, 0), BRIGHTEST) / BRIGHTEST);
}

/** Settings where that lamp alone is on; where it was so already, all are on again. */
export function solo(lamps: readonly LampSetting[], which: number): LampSetting[] {
  const isSolo = lamps.every(({ isOn }, k) => isOn === (k === which));
  return lamps.map((lamp, k) => ({ ...lamp, isOn: isSolo || k === which }));
}

export function isChanged({ isOn, dimmer, colour }: LampSetting): boolean {
  return !isOn || dimmer !== AS_IN_SCENE.dimmer || colour !== AS_IN_SCENE.colour;
}
