// Keys that are held down to move, and those that do something at once.

import type { Wish } from "./walk";

/** Where keys lie, whatever is printed on them. */
const MOVES: Record<string, Partial<Record<"ahead" | "right" | "up" | "turn", number>>> = {
  KeyW: { ahead: 1 }, ArrowUp: { ahead: 1 }, KeyS: { ahead: -1 }, ArrowDown: { ahead: -1 },
  KeyD: { right: 1 }, KeyA: { right: -1 }, ArrowLeft: { turn: 1 }, ArrowRight: { turn: -1 },
  KeyE: { up: 1 }, Space: { up: 1 }, KeyQ: { up: -1 }, KeyC: { up: -1 },
};

/** A key by what it writes, and what it does. */
export interface Shortcut {
  keys: string[];
  label: string;
  run: () => void;
}

export class Keyboard {
  /** Called when a key is pressed that moves. */
  onMove: () => void = () => {};
  shortcuts: Shortcut[] = [];
  private readonly held = new Set<string>();
  private isFast = false;

  constructor() {
    addEventListener("keydown", (event) => this.press(event));
    addEventListener("keyup", (event) => {
      this.isFast = event.shiftKey;
      this.held.delete(event.code);
    });
    addEventListener("blur", () => this.held.clear());
  }

  /** What the keys say that are down; `turn` is 1 to the left. */
  get wish(): Wish & { turn: number } {
    const wish = { ahead: 0, right: 0, up: 0, turn: 0, isFast: this.isFast };
    for (const code of this.held)
      for (const [axis, amount] of Object.entries(MOVES[code])) wish[axis as "ahead"] += amount;
    return wish;
  }

  /** Holds just these down, for scripts. */
  hold(codes: string[], isFast = false): void {
    this.held.clear();
    this.isFast = isFast;
    codes.filter((code) => code in MOVES).forEach((code) => this.held.add(code));
  }

  private press(event: KeyboardEvent): void {
    this.isFast = event.shiftKey;
    if (event.ctrlKey || event.metaKey || event.altKey || isUsed(event)) return;
    if (event.code in MOVES) {
      event.preventDefault();
      if (this.held.has(event.code)) return;
      this.held.add(event.code);
      this.onMove();
      return;
    }
    if (event.repeat) return;
    this.shortcuts.find(({ keys }) => keys.includes(event.key.toLowerCase()))?.run();
  }
}

/** Whether a control takes the key for itself. */
function isUsed({ target, code }: KeyboardEvent): boolean {
  if (!(target instanceof HTMLElement) || target === document.body || target instanceof HTMLCanvasElement) return false;
  if (target instanceof HTMLInputElement) {
    if (target.type === "checkbox") return code === "Space";
    return target.type !== "range" && target.type !== "radio" ? true : code.startsWith("Arrow") || code === "Home" || code === "End";
  }
  if (target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement) return true;
  if (target.closest("dialog")) return true;
  return code === "Space" || code === "Enter" || code.startsWith("Arrow");
}
