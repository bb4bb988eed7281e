import { describe, expect, test } from "vitest";
import { clock, duration, factor, figures, metres, percent, whole } from "../src/figures";
import { linearScale, linearTicks, logarithmicScale, logarithmicTicks, timeTicks } from "../src/plot";

describe("scales of the plot", () => {
  test("logarithmic: whole decades around the values", () => {
    const scale = logarithmicScale([0.9, 0.03, 0]);
    expect([scale.low, scale.high]).toEqual([0.01, 1]);
    expect(scale(0.01)).toBeCloseTo(0, 12);
    expect(scale(0.1)).toBeCloseTo(0.5, 12);
    expect(scale(1)).toBeCloseTo(1, 12);
    expect([scale(0), scale(5)]).toEqual([0, 1]);
    expect(logarithmicTicks(scale)).toEqual([0.01, 0.1, 1]);
  });

  test("logarithmic: a decade at least, and decades themselves are ends", () => {
    expect(logarithmicTicks(logarithmicScale([0.001]))).toEqual([0.001, 0.01]);
    expect(logarithmicTicks(logarithmicScale([]))).toEqual([1, 10]);
    expect(logarithmicTicks(logarithmicScale([0.001, 0.1, NaN]))).toEqual([0.001, 0.01, 0.1]);
  });

  test.each([0.7, 1, 3.3, 9, 48, 1000])("linear to %d: three to six round values within it", (high) => {
    const scale = linearScale([0.1 * high, high]);
    expect(scale(high)).toBe(1);
    const ticks = linearTicks(scale);
    expect(ticks.length).toBeGreaterThanOrEqual(3);
    expect(ticks.length).toBeLessThanOrEqual(6);
    expect(Math.max(...ticks)).toBeLessThanOrEqual(high * (1 + 1e-9));
  });
});

test.each([61, 100, 150, 400, 3000])("times to %d s: two to six, of whole quarters of minutes", (high) => {
  const ticks = timeTicks(linearScale([high]));
  expect(ticks.length).toBeGreaterThanOrEqual(2);
  expect(ticks.length).toBeLessThanOrEqual(6);
  expect(ticks.every((tick) => tick % 15 === 0 && tick <= high)).toBe(true);
});

describe("numbers for people", () => {
  test("shares", () => {
    expect([0.019, 0.12, 0.0005, 1, 0, NaN].map(percent)).toEqual(["1.9 %", "12 %", "0.05 %", "100 %", "0 %", "unknown"]);
  });

  test("seconds", () => {
    expect([0.0412, 3.24, 42.4, 125].map(duration)).toEqual(["0.041 s", "3.2 s", "42 s", "2 min 5 s"]);
    expect([0, 30, 90, 600].map(clock)).toEqual(["0 s", "30 s", "1:30", "10:00"]);
  });

  test("values", () => {
    expect([0, 0.012345, 1.2, 123.45, 12345, 1.2345e-5, -2.5, 1.5e9, NaN].map(figures)).toEqual([
      "0", "0.0123", "1.20", "123", "12,300", "1.23e-5", "−2.50", "1.50e9", "–",
    ]);
    expect(whole(12345.4)).toBe("12,345");
    expect([-1e-5, -0.5, 1.23456].map(metres)).toEqual(["0.000", "−0.500", "1.235"]);
    expect([0.16449, 0.0082, 0.000327, 0].map(factor)).toEqual(["0.164", "0.0082", "0.00033", "0"]);
  });
});
