// The session behind the page, if there is one: packets and messages over one websocket.

import { Events } from "./events";
import type { FromPage, ToPage } from "./messages";
import { type Packet, unpack } from "./packet";

interface Heard {
  packet: Packet;
  message: ToPage;
  open: undefined;
  closed: undefined;
  /** What came is no packet; says why. */
  damaged: string;
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
      else this.hear(data);
    };
  }

  private hear(data: ArrayBuffer): void {
    let packet: Packet;
    try {
      packet = unpack(data);
    } catch (error) {
      return this.events.emit("damaged", (error as Error).message);
    }
    this.events.emit("packet", packet);
  }

  /** Whether it went out. */
  send(message: FromPage): boolean {
    const isOpen = this.socket.readyState === WebSocket.OPEN;
    if (isOpen) this.socket.send(JSON.stringify(message));
    return isOpen;
  }
}
