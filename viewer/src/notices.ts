// What could not be done, said once and dismissed by whoever has read it.

import type { App } from "./app";
import { h } from "./dom";
import { button } from "./ui";
import "./notices.css";

/** More than these at once would hide the picture. */
const MOST = 3;

export class Notices {
  private readonly root = h("div", { className: "notices", role: "alert" });

  constructor(app: App) {
    app.root.append(this.root);
    app.events.on("message", (message) => {
      if (message.type === "failed") this.say(message.message);
    });
  }

  say(text: string): void {
    const close = button({ label: "×", title: "Dismiss" }, () => notice.remove());
    close.className = "plain";
    const notice = h("div", { className: "notice" }, h("p", {}, text), close);
    this.root.append(notice);
    while (this.root.children.length > MOST) this.root.firstElementChild!.remove();
  }
}
