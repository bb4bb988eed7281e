// How fast pictures are drawn.

/** Seconds that are looked back on. */
const SPAN = 2;

export interface Speed {
  /** Pictures a second while they are drawn; 0 while nothing changes. */
  frames: number;
  /** Milliseconds of this program for one picture, on average; what the graphics card does comes on top. */
  script: number;
  /** Pictures since the page was opened. */
  drawn: number;
}

export class Statistics {
  private drawn = 0;
  private recent: { at: number; script: number }[] = [];

  /** @param at, script milliseconds: when a picture began, and what was spent on it here. */
  count(at: number, script: number): void {
    this.drawn++;
    this.recent.push({ at, script });
    while (at - this.recent[0].at > 1000 * SPAN) this.recent.shift();
  }

  /** Nothing was to be drawn: the next picture is not late. */
  rest(): void {
    if (this.recent.length) this.recent = [];
  }

  get speed(): Speed {
    const { recent, drawn } = this;
    const seconds = recent.length > 1 ? (recent.at(-1)!.at - recent[0].at) / 1000 : 0;
    return {
      frames: seconds > 0 ? (recent.length - 1) / seconds : 0,
      script: recent.length ? recent.reduce((sum, { script }) => sum + script, 0) / recent.length : 0,
      drawn,
    };
  }
}
