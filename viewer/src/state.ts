// The viewpoint and the settings in the address of the page, so that a link shows the same.

import { DEFAULTS, type Settings } from "./settings";

export interface State {
  /** Metres, where the file has it. */
  position: number[];
  forward: number[];
  /** Vertical, radians. */
  angle: number;
  mode: string;
  /** Those that are not as at first. */
  settings: Partial<Settings>;
}

const PREFIX = "#view=";

export function changed(settings: Settings, first: Settings = DEFAULTS): Partial<Settings> {
  const names = Object.keys(settings) as (keyof Settings)[];
  const others = names.filter((name) => JSON.stringify(settings[name]) !== JSON.stringify(first[name]));
  return Object.fromEntries(others.map((name) => [name, settings[name]]));
}

/** What follows the address. */
export function written(state: State): string {
  const short = (values: number[]) => values.map((x) => Number(x.toFixed(5)));
  const text = JSON.stringify({
    ...state, position: short(state.position), forward: short(state.forward), angle: Number(state.angle.toFixed(5)),
  });
  return PREFIX + encodeURIComponent(text);
}

/** null if there is no such thing in it, or it is damaged. */
export function read(hash: string): State | null {
  if (!hash.startsWith(PREFIX)) return null;
  try {
    const state = JSON.parse(decodeURIComponent(hash.slice(PREFIX.length))) as State;
    return isTriple(state.position) && isTriple(state.forward) && Number.isFinite(state.angle)
      ? { ...state, settings: known(state.settings) }
      : null;
  } catch {
    return null;
  }
}

/** Settings that there are, of the type that they have. */
function known(settings: Partial<Settings> = {}): Partial<Settings> {
  const entries = Object.entries(settings).filter(([name, value]) => {
    if (name === "range") return Array.isArray(value) && value.length === 2 && value.every(Number.isFinite);
    if (name === "band") return value === "all" || Number.isInteger(value);
    return name in DEFAULTS && typeof value === typeof DEFAULTS[name as keyof Settings];
  });
  return Object.fromEntries(entries);
}

function isTriple(values: unknown): boolean {
  return Array.isArray(values) && values.length === 3 && values.every(Number.isFinite);
}
