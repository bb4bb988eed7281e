// Where the scene comes from: it lies in the page itself, or a session sends it.

import { unpack, type Packet } from "./packet";

/** The element of an exported page that holds the scene: gzip, base64. */
const ELEMENT = "radiosity-scene";

/** The scene in this page; null if there is none, and a session must be asked. */
export async function embedded(): Promise<Packet | null> {
  const text = document.getElementById(ELEMENT)?.textContent?.trim();
  if (!text) return null;
  // Not from a Blob: browsers keep those in another process, in small pieces.
  const stream = new Response(decoded(text)).body!.pipeThrough(new DecompressionStream("gzip"));
  return unpack(await whole(stream));
}

async function whole(stream: ReadableStream): Promise<ArrayBuffer> {
  try {
    return await new Response(stream).arrayBuffer();
  } catch {
    throw new Error("the scene is cut off");
  }
}

/** The bytes of base64. */
function decoded(text: string): Uint8Array<ArrayBuffer> {
  if ("fromBase64" in Uint8Array) return (Uint8Array.fromBase64 as (text: string) => Uint8Array<ArrayBuffer>)(text);
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = characters.charCodeAt(i);
  return bytes;
}

/** Where the session listens: beside this page; null if the page is a file, which nobody serves. */
export function session(): URL | null {
  if (!location.protocol.startsWith("http")) return null;
  const address = new URL("socket", location.href);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  address.search = address.hash = "";
  return address;
}
