// Asks the session for other light: one question at a time, and the last state of things always gets asked.

import { Events } from "./events";
import type { Relight } from "./messages";

export interface Answer {
  /** Milliseconds from the question to its answer. */
  took: number;
  /** Seconds that finding the light took of it; null if it was not found. */
  finding: number | null;
}

interface Answers {
  answered: Answer;
  waiting: boolean;
}

export class Relighting {
  readonly events = new Events<Answers>();
  /** Reflectance of surfaces that are painted, by index. */
  readonly paint = new Map<number, number[]>();
  /** What multiplies lamps that are not as in the scene, by index. */
  readonly lamps = new Map<number, number[]>();
  private asked: number | null = null;
  private isStale = false;

  /** @param send says whether the question went out. */
  constructor(
    private readonly send: (message: Relight) => boolean,
    private readonly now: () => number = () => performance.now(),
  ) {}

  get isWaiting(): boolean {
    return this.asked !== null;
  }

  /** Asks for the light with paint and lamps as they are now, or as they will be once the answer before is here. */
  ask(): void {
    this.isStale = true;
    if (!this.isWaiting) this.next();
  }

  /** The light came, or it was said that it does not come. */
  answered(finding: number | null): void {
    if (this.asked === null) return;
    const took = this.now() - this.asked;
    this.asked = null;
    this.events.emit("answered", { took, finding });
    this.next();
  }

  /** Nothing that was asked will be answered. */
  forget(): void {
    this.asked = null;
    this.isStale = false;
    this.events.emit("waiting", false);
  }

  private next(): void {
    if (this.isStale && this.send(this.message())) {
      this.isStale = false;
      this.asked = this.now();
    }
    this.events.emit("waiting", this.isWaiting);
  }

  private message(): Relight {
    const record = (map: Map<number, number[]>) => Object.fromEntries([...map].map(([k, value]) => [String(k), value]));
    return { type: "relight", reflectance: record(this.paint), lamps: record(this.lamps) };
  }
}
