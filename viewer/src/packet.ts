// A head and arrays in one block of bytes, as python/radiosity/viewer/packet.py writes it.

import type { Head } from "./messages";

const MAGIC = "RADPKT01";

type Numbers = Float32Array | Uint32Array;

interface Described {
  type: "f4" | "u4";
  shape: number[];
  offset: number;
}

export class Packet {
  constructor(
    readonly head: Head,
    private readonly arrays: Record<string, { shape: number[]; numbers: Numbers }>,
  ) {}

  floats(name: string): Float32Array {
    const numbers = this.arrays[name]?.numbers;
    if (!(numbers instanceof Float32Array)) throw new Error(`the packet has no array of floats "${name}"`);
    return numbers;
  }

  indices(name: string): Uint32Array {
    const numbers = this.arrays[name]?.numbers;
    if (!(numbers instanceof Uint32Array)) throw new Error(`the packet has no array of indices "${name}"`);
    return numbers;
  }

  shape(name: string): number[] {
    return this.arrays[name]?.shape ?? [];
  }
}

/** Reads a packet; its arrays are views of the buffer. Throws an Error that says what is wrong with it. */
export function unpack(buffer: ArrayBuffer): Packet {
  const text = new TextDecoder();
  const begin = MAGIC.length + 4;
  if (buffer.byteLength < begin || text.decode(new Uint8Array(buffer, 0, MAGIC.length)) !== MAGIC)
    throw new Error("this is no scene of radiosity");
  const data = begin + new DataView(buffer).getUint32(MAGIC.length, true);
  if (data > buffer.byteLength) throw new Error("the scene is cut off");
  const said = JSON.parse(text.decode(new Uint8Array(buffer, begin, data - begin))) as {
    head: Head;
    arrays: Record<string, Described>;
  };
  const arrays = Object.fromEntries(
    Object.entries(said.arrays).map(([name, { type, shape, offset }]) => {
      const count = shape.reduce((a, b) => a * b, 1);
      if (data + offset + 4 * count > buffer.byteLength) throw new Error("the scene is cut off");
      const numbers = new (type === "f4" ? Float32Array : Uint32Array)(buffer, data + offset, count);
      return [name, { shape, numbers }];
    }),
  );
  return new Packet(said.head, arrays);
}
