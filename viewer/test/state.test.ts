import { expect, test } from "vitest";
import { DEFAULTS } from "../src/settings";
import { changed, read, written } from "../src/state";

const STATE = {
  position: [1, 1.65, -3.25], forward: [0, 0, -1], angle: 0.87266, mode: "walk",
  settings: { falseColours: true, range: [0, 12] as [number, number] },
};

test("an address says what it was made of", () => {
  expect(read(written(STATE))).toEqual(STATE);
});

test("only settings that differ are in it", () => {
  expect(changed({ ...DEFAULTS })).toEqual({});
  expect(changed({ ...DEFAULTS, map: "turbo", band: 1 })).toEqual({ map: "turbo", band: 1 });
});

test("addresses without a view, damaged ones and unknown settings change nothing", () => {
  expect(read("")).toBeNull();
  expect(read("#view=%7B")).toBeNull();
  expect(read(written({ ...STATE, position: [1, 2] }))).toBeNull();
  const odd = { map: 7, quantity: "radiosity", wheels: 4, range: [1], band: "all" } as object;
  expect(read(written({ ...STATE, settings: odd }))?.settings).toEqual({ quantity: "radiosity", band: "all" });
});
