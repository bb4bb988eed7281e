// The session behind the page, if there is one: packets and messages over one websocket.

import { Events } from "./events";
import type { FromPage, ToPage } from "./messages";
import { type Packet, unpack } from "./packet";

interface Heard {
  packet: Packet;
  message: ToPage;
  open: undefined;
  closed: undefined;
}

export class Link {
  readonly events = new Events<Heard>();
  private readonly socket: WebSocket;

  constructor(address: URL) {
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => this.events.emit("open", undefined);
    this.socket.onclose = () => this.events.emit("closed", undefined);
    this.socket.onmessage = ({ data }: MessageEvent<string | ArrayBuffer>) => {
      if (typeof data === "string") this.events.emit("message", JSON.parse(data) as ToPage);
      else this.events.emit("packet", unpack(data));
    };
  }

  /** Whether it went out. */
  send(message: FromPage): boolean {
    const isOpen = this.socket.readyState === WebSocket.OPEN;
    if (isOpen) this.socket.send(JSON.stringify(message));
    return isOpen;
  }
}
