// Puts the parts together.

import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Events } from "./events";
import { LitScene } from "./light";
import { Link } from "./link";
import type { Head, ToPage } from "./messages";
import type { Packet } from "./packet";
import type { Settings } from "./settings";
import { embedded, session } from "./source";
import { LightPanels } from "./panels/light";
import { Rays } from "./rays";
import { Stage } from "./stage";
import { Sidebar } from "./ui";
import type { Unit } from "./units";
import "./style.css";

interface Happenings {
  /** Other patches are shown. */
  scene: LitScene;
  /** The light on them is another: from the session, or mixed. */
  light: LitScene;
  settings: Settings;
  /** A packet came and is shown. */
  head: Head;
  message: ToPage;
  closed: undefined;
}

export class App {
  readonly events = new Events<Happenings>();
  readonly canvas = document.createElement("canvas");
  readonly stage: Stage;
  readonly rays: Rays;
  readonly sidebar: Sidebar;
  readonly light: LightPanels;
  lit: LitScene | null = null;
  link: Link | null = null;

  constructor(readonly root: HTMLElement) {
    root.append(this.canvas);
    this.stage = new Stage(this.canvas);
    this.rays = new Rays(this.stage);
    this.sidebar = new Sidebar(root);
    this.light = new LightPanels(this, this.sidebar, this.rays);
    new ResizeObserver(() => this.stage.resize(this.canvas.clientWidth, this.canvas.clientHeight)).observe(this.canvas);
  }

  async start(): Promise<void> {
    const packet = await embedded();
    if (packet) return this.take(packet);
    this.link = new Link(session());
    this.link.events.on("packet", (packet) => this.take(packet));
    this.link.events.on("message", (message) => this.events.emit("message", message));
    this.link.events.on("closed", () => this.events.emit("closed", undefined));
  }

  set(change: Partial<Settings>): void {
    this.stage.set(change);
    this.events.emit("settings", this.stage.settings);
  }

  /** Sets how much there is of a layer, by band. */
  mix(layer: number, weights: number[]): void {
    this.lit?.mix(layer, weights);
    this.lightChanged();
  }

  private take(packet: Packet): void {
    if (packet.head.type === "light") {
      this.lit?.relight(packet);
      this.lightChanged();
      this.events.emit("head", packet.head);
      return;
    }
    const isFirst = !this.lit;
    this.lit = new LitScene(packet);
    document.title = this.lit.head.title;
    if (isFirst) {
      this.set({ unit: this.lit.head.unit as Unit });
      this.stage.lookThrough(this.lit.head.cameras[0]);
      const controls = new OrbitControls(this.stage.camera, this.canvas);
      controls.addEventListener("change", () => this.stage.invalidate());
    }
    this.stage.show(this.lit);
    this.events.emit("scene", this.lit);
    this.events.emit("head", packet.head);
  }

  private lightChanged(): void {
    if (!this.lit) return;
    this.stage.show(this.lit);
    this.events.emit("light", this.lit);
  }
}
