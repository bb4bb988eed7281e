import { describe, expect, test } from "vitest";
import { hex, hue, linear } from "../src/colour";
import { AS_IN_SCENE, BRIGHTEST, dimmed, dimmerPlace, isChanged, solo, weights } from "../src/mixing";
import { cube, lit } from "./room";

describe("colours of pickers", () => {
  test("are linear where light is", () => {
    expect(linear("#ffffff")).toEqual([1, 1, 1]);
    expect(linear("#000000")).toEqual([0, 0, 0]);
    // IEC 61966-2-1: 188 of 255 is 0.5029 of the light.
    expect(linear("#bc0000")[0]).toBeCloseTo(0.5029, 4);
  });

  test("are the same again", () => {
    for (const colour of ["#123456", "#0a0b0c", "#fedcba", "#808080"]) expect(hex(linear(colour))).toBe(colour);
    expect(hex([2, -1, 0.5])).toMatch(/^#ff00/);
  });

  test("of light are as bright as can be", () => {
    expect(hue([10, 10, 10])).toBe("#ffffff");
    expect(hue([8, 4, 0]).slice(0, 3)).toBe("#ff");
    expect(hue([3])).toBe("#ffffff");
    expect(hue([0, 0, 0])).toBe("#ffffff");
  });
});

describe("lamps", () => {
  test("multiply their light by dimmer and filter", () => {
    expect(weights(AS_IN_SCENE, 3)).toEqual([1, 1, 1]);
    expect(weights({ isOn: true, dimmer: 2, colour: "#ff0000" }, 3)).toEqual([2, 0, 0]);
    expect(weights({ isOn: true, dimmer: 2, colour: "#ff0000" }, 2)).toEqual([2, 2]);
    expect(weights({ isOn: false, dimmer: 2, colour: "#ffffff" }, 1)).toEqual([0]);
  });

  test("are dimmed finely near nothing", () => {
    expect(dimmed(0)).toBe(0);
    expect(dimmed(0.5)).toBe(1);
    expect(dimmed(1)).toBe(BRIGHTEST);
    for (const factor of [0, 0.01, 0.5, 1, 3.9]) expect(dimmed(dimmerPlace(factor))).toBeCloseTo(factor, 12);
    expect(dimmerPlace(100)).toBe(1);
  });

  test("play alone, and together again", () => {
    const lamps = [AS_IN_SCENE, { ...AS_IN_SCENE, dimmer: 2 }, AS_IN_SCENE];
    const alone = solo(lamps, 1);
    expect(alone.map(({ isOn }) => isOn)).toEqual([false, true, false]);
    expect(alone[1].dimmer).toBe(2);
    expect(solo(alone, 1).map(({ isOn }) => isOn)).toEqual([true, true, true]);
    expect(solo(alone, 2).map(({ isOn }) => isOn)).toEqual([false, false, true]);
    expect(alone.map(isChanged)).toEqual([true, true, true]);
    expect(isChanged(AS_IN_SCENE)).toBe(false);
  });

  test("add up: light is linear", () => {
    const scene = lit(cube(1, () => ({ reflectance: 0.5, emission: [1, 4], irradiance: [2, 6], field: [1, 3, 5, 7] })), 2);
    scene.mix(0, [0.5]);
    scene.mix(1, [2]);
    const { irradiance, emission, radiosity } = scene.of(3);
    expect(irradiance).toEqual([13]);
    expect(emission).toEqual([8.5]);
    expect(radiosity).toEqual([8.5 + 6.5]);
    expect(scene.irradianceAt(3, 1, 0)[0]).toBeCloseTo(2.5 * 3, 6);
    expect(scene.emitters[0]).toEqual({ patch: 0, emission: 5 }); // whatever is mixed
  });
});
