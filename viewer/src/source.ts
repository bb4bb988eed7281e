// Where the scene comes from: it lies in the page itself, or a session sends it.

import { unpack, type Packet } from "./packet";

/** The element of an exported page that holds the scene: gzip, base64. */
const ELEMENT = "radiosity-scene";

/** The scene in this page; null if there is none, and a session must be asked. */
export async function embedded(): Promise<Packet | null> {
  const text = document.getElementById(ELEMENT)?.textContent?.trim();
  if (!text) return null;
  const zipped = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([zipped]).stream().pipeThrough(new DecompressionStream("gzip"));
  return unpack(await new Response(stream).arrayBuffer());
}

/** Where the session listens: beside this page. */
export function session(): URL {
  const address = new URL("socket", location.href);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  address.search = address.hash = "";
  return address;
}
