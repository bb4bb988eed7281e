import { describe, expect, test } from "vitest";
import type { App } from "../src/app";
import { Control } from "../src/control";
import { Events } from "../src/events";
import type { FromPage, LampHead, Relight, Status } from "../src/messages";
import { AS_IN_SCENE } from "../src/mixing";
import { cube, lit } from "./room";

const LAMPS: LampHead[] = ["window", "lamp"].map((name, k) => ({ name, surfaces: [k], lights: [] }));
const READY: Status = { type: "status", stage: "ready", done: 1, can_relight: true, text: "ready" };

/** What a control sees of the page: a scene with two lamps, in layers or with a session. */
function page(layers: number, hasSession: boolean) {
  const sent: Relight[] = [];
  const scene = lit(cube(1, () => ({ emission: [1, 2], irradiance: [1, 3] })), layers, 1, LAMPS);
  const app = {
    events: new Events(),
    lit: scene,
    link: hasSession ? { send: (message: FromPage) => !!sent.push(message as Relight) } : null,
    mix: (layer: number, weights: number[]) => app.lit!.mix(layer, weights),
  } as unknown as App;
  const control = new Control(app);
  app.events.emit("scene", scene);
  return { app, control, scene, sent };
}

describe("lamps with layers", () => {
  test("are mixed here", () => {
    const { control, scene, sent } = page(2, true);
    expect(control.lampsFixed).toBe("");
    control.setLamp(1, { dimmer: 0.5 });
    expect([...scene.weights]).toEqual([1, 0.5]);
    control.solo(0);
    expect([...scene.weights]).toEqual([1, 0]);
    control.setLamps(control.lamps.map(() => AS_IN_SCENE));
    expect([...scene.weights]).toEqual([1, 1]);
    expect(sent).toEqual([]);
  });

  test("stay as they are set when other patches come", () => {
    const { app, control } = page(2, true);
    control.setLamp(0, { isOn: false });
    app.lit = lit(cube(1, () => ({ emission: [1, 2] })), 2, 1, LAMPS);
    app.events.emit("scene", app.lit);
    expect([...app.lit.weights]).toEqual([0, 1]);
  });
});

describe("lamps without layers", () => {
  test("are relit by a session that can, with the last state after the answer", () => {
    const { app, control, sent } = page(1, true);
    expect(control.lampsFixed).toMatch(/Waiting/);
    app.events.emit("message", { ...READY, stage: "solving", can_relight: false, text: "solving: mesh 2" });
    expect(control.lampsFixed).toMatch(/solving: mesh 2/);
    app.events.emit("message", READY);
    expect(control.lampsFixed).toBe("");
    for (const dimmer of [0.9, 0.6, 0.3]) control.setLamp(1, { dimmer });
    expect(sent.map(({ lamps }) => lamps)).toEqual([{ "1": [0.9] }]);
    app.events.emit("head", { type: "light", reflectance: [], seconds: 0.1, is_final: true, report: {} });
    expect(sent.map(({ lamps }) => lamps)).toEqual([{ "1": [0.9] }, { "1": [0.3] }]);
    app.events.emit("message", { type: "failed", message: "no" });
    control.setLamp(1, AS_IN_SCENE);
    expect(sent.at(-1)!.lamps).toEqual({});
  });

  test("are asked for again when other patches come", () => {
    const { app, control, sent } = page(1, true);
    app.events.emit("message", READY);
    control.setLamp(0, { isOn: false });
    app.events.emit("scene", app.lit!);
    app.events.emit("head", app.lit!.head);
    app.events.emit("message", READY);
    expect(sent.map(({ lamps }) => lamps)).toEqual([{ "0": [0] }, { "0": [0] }]);
  });

  test("are fixed where nobody can relight, and it is said why", () => {
    expect(page(1, false).control.lampsFixed).toMatch(/found before.*layers/);
    const { app, control } = page(1, true);
    app.events.emit("message", READY);
    app.events.emit("closed", undefined);
    expect(control.lampsFixed).toMatch(/has ended/);
  });
});

test("paint stays below one, and goes back to what the scene has", () => {
  const { app, control, sent } = page(2, true);
  app.events.emit("message", READY);
  control.paint(3, [1.5]);
  app.events.emit("head", { type: "light", reflectance: [], seconds: 0.1, is_final: true, report: {} });
  control.paint(3, null);
  expect(sent.map(({ reflectance }) => reflectance)).toEqual([{ "3": [0.99] }, {}]);
});

test("the back of a sheet has the paint of its front", () => {
  const { app, control, sent } = page(2, true);
  app.lit!.head.surfaces.forEach((surface, k) => (surface.name = k < 3 ? `sheet ${k}` : `sheet ${k - 3} (back)`));
  app.events.emit("message", READY);
  control.paint(4, [0.5]);
  expect(sent[0].reflectance).toEqual({ "1": [0.5] });
  expect(control.paintOf(1)).toEqual([0.5]);
  expect(control.paintOf(4)).toEqual([0.5]);
  expect(control.paintOf(3)).toBeUndefined();
});

test("lamps that were relit are mixed once their layers are here, and not dimmed twice", () => {
  const { app, control, sent } = page(1, true);
  app.events.emit("message", READY);
  control.setLamp(0, { dimmer: 0.5 });
  app.lit = lit(cube(1, () => ({ emission: [1, 2] })), 2, 1, LAMPS);
  app.events.emit("scene", app.lit);
  app.events.emit("head", app.lit.head);
  expect([...app.lit.weights]).toEqual([0.5, 1]);
  control.paint(2, [0.2]);
  expect(sent.at(-1)!.lamps).toEqual({});
});
