// How large and fast whoever walks is.

/** Metres, of a person; times `scale`. */
const PERSON = { eye: 1.65, crown: 0.1, radius: 0.22, step: 0.4, speed: 1.6 };

/** Metres of height that a person stands in, and of length that is a room. */
const STANDING = 2.2;
const ROOM = 10;

/** Metres beyond which a person would walk for too long. */
const LANDSCAPE = 1000;

export interface Body {
  /** Relative to a person. */
  scale: number;
  /** Height of the eyes over the ground, and of the crown over the eyes, metres. */
  eye: number;
  crown: number;
  radius: number;
  /** The highest step that is climbed, metres. */
  step: number;
  /** Metres a second, when in no hurry. */
  speed: number;
}

/**
 * A body for a scene: a person, but in scenes too small to stand in a smaller one, and in landscapes a larger one.
 *
 * @param height, length metres: how far the scene goes upward, and the farthest it goes in any direction.
 * @param eye height of the eyes if the body were a person, metres.
 */
export function bodyFor(height: number, length: number, eye = PERSON.eye): Body {
  const small = Math.max(height / STANDING, length / ROOM);
  const scale = !(small > 0) ? 1 : small < 1 ? small : Math.max(1, length / LANDSCAPE);
  const { crown, radius, step, speed } = PERSON;
  return { scale, eye: scale * eye, crown: scale * crown, radius: scale * radius, step: scale * step, speed: scale * speed };
}

/** What to say of a body that is no person's; empty if it is. */
export function remark({ scale }: Body): string {
  if (scale < 0.99) return `This scene is too small to stand in, so you are 1 : ${round(1 / scale)} of a person.`;
  if (scale > 1.01) return `This scene is a landscape, so you are ${round(scale)} times as large and fast as a person.`;
  return "";
}

function round(x: number): string {
  return x < 10 ? String(Number(x.toPrecision(2))) : x.toFixed(0);
}
