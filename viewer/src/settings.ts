// How the light is shown; what panels change and the stage reads.

import type { Quantity } from "./light";
import type { ColourMap, Curve } from "./tone";
import type { Unit } from "./units";

export interface Settings {
  quantity: Quantity;
  /** A band by index, or all of them. */
  band: number | "all";
  smooth: boolean;
  falseColours: boolean;
  /** Stops, on radiance (W/m2/sr) for radiosity and on the values themselves otherwise. */
  exposure: number;
  isExposureAutomatic: boolean;
  curve: Curve;
  map: ColourMap;
  /** First and last value of the colour scale, in the unit shown; null is automatic. */
  range: [number, number] | null;
  isLogarithmic: boolean;
  isolines: boolean;
  mesh: boolean;
  /** What irradiance is shown in; another than the scene's is converted (see units.ts). */
  unit: Unit;
}

export const DEFAULTS: Settings = {
  quantity: "radiosity",
  band: "all",
  smooth: true,
  falseColours: false,
  exposure: 0,
  isExposureAutomatic: true,
  curve: "filmic",
  map: "viridis",
  range: null,
  isLogarithmic: false,
  isolines: false,
  mesh: false,
  unit: "W/m2",
};
