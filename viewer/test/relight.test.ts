import { expect, test } from "vitest";
import type { Relight } from "../src/messages";
import { Relighting } from "../src/relight";

function asked(isOpen = () => true) {
  const sent: Relight[] = [];
  let now = 0;
  const relighting = new Relighting((message) => isOpen() && !!sent.push(message), () => now);
  return { sent, relighting, wait: (milliseconds: number) => (now += milliseconds) };
}

test("one question is under way, and the last state gets asked", () => {
  const { sent, relighting } = asked();
  for (let k = 0; k < 10; k++) {
    relighting.lamps.set(0, [k]);
    relighting.ask();
  }
  expect(sent.map((message) => message.lamps["0"][0])).toEqual([0]);
  relighting.answered(0.1);
  expect(sent.map((message) => message.lamps["0"][0])).toEqual([0, 9]);
  relighting.answered(0.1);
  expect(sent.length).toBe(2);
  expect(relighting.isWaiting).toBe(false);
});

test("paint and lamps go together, and what is as in the scene is left out", () => {
  const { sent, relighting } = asked();
  relighting.paint.set(3, [0.1, 0.2, 0.3]);
  relighting.ask();
  expect(sent[0]).toEqual({ type: "relight", reflectance: { "3": [0.1, 0.2, 0.3] }, lamps: {} });
});

test("it says how long an answer took", () => {
  const { relighting, wait } = asked();
  const took: number[] = [];
  relighting.events.on("answered", (answer) => took.push(answer.took, answer.finding ?? NaN));
  relighting.ask();
  wait(120);
  relighting.answered(0.1);
  relighting.answered(0.1); // light that nobody asked for
  expect(took).toEqual([120, 0.1]);
});

test("what could not be sent is not waited for, and is sent when asked again", () => {
  let isOpen = false;
  const { sent, relighting } = asked(() => isOpen);
  relighting.ask();
  expect(relighting.isWaiting).toBe(false);
  isOpen = true;
  relighting.ask();
  expect(sent.length).toBe(1);
});

test("after a break nothing is waited for", () => {
  const { sent, relighting } = asked();
  relighting.ask();
  relighting.ask();
  relighting.forget();
  expect(relighting.isWaiting).toBe(false);
  relighting.ask();
  expect(sent.length).toBe(2);
});
