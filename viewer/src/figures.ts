// Numbers as people write them.

/** A share as people write it: 12 %, 1.9 %, 0.05 %. */
export function percent(share: number): string {
  const value = 100 * share;
  if (!Number.isFinite(value)) return "unknown";
  return `${value >= 9.95 || value === 0 ? value.toFixed(0) : Number(value.toPrecision(2))} %`;
}

/** Seconds as people write them: 0.04 s, 3.2 s, 42 s, 2 min 5 s. */
export function duration(seconds: number): string {
  if (seconds >= 59.5) return `${Math.floor(Math.round(seconds) / 60)} min ${Math.round(seconds) % 60} s`;
  return `${seconds >= 9.95 ? Math.round(seconds) : Number(seconds.toPrecision(2))} s`;
}

/** The same on an axis: 0.5 s, 30 s, 1:30. */
export function clock(seconds: number): string {
  if (seconds < 60) return duration(seconds);
  return `${Math.floor(seconds / 60)}:${String(Math.round(seconds % 60)).padStart(2, "0")}`;
}

/** Three significant digits: 0.0123, 1.20, 123, 12,300, 1.23e-5; zero is 0. */
export function figures(value: number): string {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size < 1e-4 || size >= 1e7) return value.toExponential(2).replace("e+", "e").replace(/^-/, "−");
  const digits = { minimumSignificantDigits: 3, maximumSignificantDigits: 3 };
  return value.toLocaleString("en-GB", digits).replace("-", "−");
}

/** A whole number: 12,345. */
export function whole(value: number): string {
  return Math.round(value).toLocaleString("en-GB");
}

/** A form factor, whose small values count as well: 0.164, 0.0082, 0.00033. */
export function factor(value: number): string {
  return value >= 0.1 ? value.toFixed(3) : String(Number(value.toPrecision(2)));
}

/** A unit in print: W/m². */
export function printed(unit: string): string {
  return unit.replace("m2", "m²");
}

/** Metres to the millimetre, without a zero that is below zero. */
export function metres(value: number): string {
  return (Math.round(1000 * value) / 1000 + 0).toFixed(3).replace("-", "−");
}
