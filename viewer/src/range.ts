// Which values a colour scale spans.

/** Bits of a float32 that are too fine to tell: bins are 0.1 % wide. */
const FINE = 13;

/**
 * The value that one part in two hundred of the lit area exceeds: a few lamps do not make all else dark. It is found to
 * one part in a thousand, by the bits of the values, which are in the order of the values.
 *
 * @param values n of them, at least zero or not counted.
 * @param area n, what each counts for.
 * @returns 1 where there is no light.
 */
export function top(values: Float32Array, area: Float32Array): number {
  const bits = new Uint32Array(values.buffer, values.byteOffset, values.length);
  const bins = new Float64Array(1 << (31 - FINE));
  let left = 0;
  for (let i = 0; i < values.length; i++) {
    if (!(values[i] > 0 && values[i] < Infinity)) continue;
    bins[bits[i] >>> FINE] += area[i];
    left += area[i];
  }
  left *= 0.005;
  for (let bin = bins.length - 1; bin >= 0; bin--) {
    left -= bins[bin];
    if (left < 0 && bins[bin] > 0) return middle(bin);
  }
  return 1;
}

/** The value in the middle of a bin. */
function middle(bin: number): number {
  return new Float32Array(new Uint32Array([(bin << FINE) + (1 << (FINE - 1))]).buffer)[0];
}

/** Round numbers from `low` to `high`, some `count` of them: 0, 20, 40; 1, 10, 100 or 1, 2, 5, 10 if logarithmic. */
export function ticks(low: number, high: number, isLogarithmic: boolean, count = 5): number[] {
  if (!(high > low)) return [low];
  if (isLogarithmic) return decades(low, high, count);
  const step = roundStep((high - low) / count);
  const all: number[] = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high * (1 + 1e-9); k++) all.push(exact(k * step));
  return all;
}

/** The least of 1, 2, 5, 10, 20 ... that is no less. */
export function roundStep(rough: number): number {
  const decade = 10 ** Math.floor(Math.log10(rough || 1));
  return exact(decade * ([1, 2, 5, 10].find((step) => step * decade >= rough * 0.999) ?? 10));
}

function decades(low: number, high: number, count: number): number[] {
  if (!(low > 0)) return [high];
  const first = Math.floor(Math.log10(low));
  const last = Math.ceil(Math.log10(high));
  const within = Math.log10(high / low);
  const steps = within > 2 ? [1] : within > 1 ? [1, 3] : [1, 2, 3, 5, 7];
  const stride = Math.max(1, Math.ceil(within / count));
  const all: number[] = [];
  for (let k = first; k <= last; k += stride) for (const step of steps) all.push(exact(step * 10 ** k));
  return all.filter((value) => value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9));
}

/** Without what rounding left: 0.30000000000000004 is 0.3. */
function exact(value: number): number {
  return Number(value.toPrecision(12));
}
