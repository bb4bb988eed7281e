// Written by python -m radiosity.viewer.typescript from python/radiosity/viewer/messages.py.

export const VERSION = 1;

/** A surface, by its index. */
export interface SurfaceHead {
  name: string;
  material: string;
  reflectance: number[];
  emission: number[];
  area: number;
}

/** What is switched and dimmed together. */
export interface LampHead {
  name: string;
  surfaces: number[];
  lights: number[];
}

/** A viewpoint; position in metres, relative to the origin of the packet; angle in radians. */
export interface CameraHead {
  name: string;
  position: [number, number, number];
  forward: [number, number, number];
  up: [number, number, number];
  vertical_fov: number;
}

/** The head of a packet with patches and the light on them. */
export interface SceneHead {
  version: number;
  title: string;
  bands: string[];
  unit: string;
  origin: [number, number, number];
  up: [number, number, number];
  surfaces: SurfaceHead[];
  lamps: LampHead[];
  cameras: CameraHead[];
  is_layered: boolean;
  is_lit: boolean;
  is_field: boolean;
  report: Record<string, unknown>;
  type: "scene";
}

/** The head of a packet with other light on the same patches. */
export interface LightHead {
  reflectance: number[][];
  seconds: number;
  is_final: boolean;
  report: Record<string, unknown>;
  type: "light";
}

/** Asks for the light with other paint and lamps; the latest one counts. */
export interface Relight {
  reflectance: Record<string, number[]>;
  lamps: Record<string, number[]>;
  type: "relight";
}

/** Ends the solve at hand; what was found so far stays. */
export interface Stop {
  type: "stop";
}

/** What the session does. */
export interface Status {
  stage: string;
  done: number;
  can_relight: boolean;
  text: string;
  type: "status";
}

/** One point of the plot of the error. */
export interface Convergence {
  stage: string;
  seconds: number;
  error: number;
  patches: number;
  iteration: number;
  wanted: number;
  type: "convergence";
}

/** What could not be done, for people. */
export interface Failed {
  message: string;
  type: "failed";
}

export type Head = SceneHead | LightHead;

export type FromPage = Relight | Stop;

export type ToPage = Status | Convergence | Failed;
