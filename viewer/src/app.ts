// Puts the parts together.

import { Vector3 } from "three";
import { Commands } from "./commands";
import { Banner, Curtain } from "./curtain";
import { h } from "./dom";
import { Events } from "./events";
import { Legend } from "./legend";
import { LitScene } from "./light";
import { Link } from "./link";
import { type Head, type ToPage, VERSION } from "./messages";
import { Navigation } from "./navigation";
import type { Packet } from "./packet";
import { LightPanels } from "./panels/light";
import { Move } from "./panels/move";
import { Toolbar } from "./panels/toolbar";
import { View } from "./panels/view";
import { Rays } from "./rays";
import type { Settings } from "./settings";
import { embedded, session } from "./source";
import { Stage } from "./stage";
import { changed, read, type State } from "./state";
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

const NO_SCENE =
  "Open one with `radiosity view room.glb`, or make a page that holds one with `radiosity view --export page.html room.glb`.";

export class App {
  readonly events = new Events<Happenings>();
  /** The picture and all that lies over it. */
  readonly root = h("main", { className: "picture" });
  readonly canvas = h("canvas", { tabIndex: 0, ariaLabel: "The scene. Press H for the keys that move through it." });
  readonly curtain = new Curtain();
  readonly banner = new Banner();
  readonly stage: Stage;
  readonly rays: Rays;
  readonly navigation: Navigation;
  readonly legend: Legend;
  readonly sidebar: Sidebar;
  readonly light: LightPanels;
  readonly commands: Commands;
  lit: LitScene | null = null;
  link: Link | null = null;
  private readonly statistics = h("output", { className: "statistics", hidden: true });
  private isLit = true;

  /** Throws where the browser has no WebGL 2. */
  constructor(readonly page: HTMLElement) {
    page.append(this.root);
    this.root.append(this.canvas);
    this.stage = new Stage(this.canvas);
    this.rays = new Rays(this.stage);
    this.navigation = new Navigation(this.stage, this.canvas, this.rays);
    this.legend = new Legend(this.stage);
    this.commands = new Commands(this);
    this.sidebar = new Sidebar(page);
    this.light = new LightPanels(this, this.rays);
    this.navigation.onClick = (x, y) => this.light.click(x, y);
    this.furnish();
    this.watch();
  }

  async start(): Promise<void> {
    this.curtain.say("Waiting for the scene", "It appears here as soon as it has been read.", true);
    try {
      const packet = await embedded();
      if (packet) return this.take(packet);
    } catch (error) {
      return this.failed((error as Error).message);
    }
    const address = session();
    if (address) this.listen(new Link(address));
    else this.curtain.say("There is no scene here", NO_SCENE);
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

  /** The view as a link has it. */
  get state(): State {
    const { camera } = this.stage;
    const origin = this.lit?.head.origin ?? [0, 0, 0];
    return {
      position: camera.position.toArray().map((x, axis) => x + origin[axis]),
      forward: camera.getWorldDirection(new Vector3()).toArray(),
      angle: this.stage.verticalAngle,
      mode: this.navigation.mode,
      settings: changed(this.stage.settings),
    };
  }

  toggleStatistics(): void {
    this.statistics.hidden = !this.statistics.hidden;
    this.stage.invalidate();
  }

  private listen(link: Link): void {
    this.link = link;
    link.events.on("packet", (packet) => this.take(packet));
    link.events.on("message", (message) => this.events.emit("message", message));
    link.events.on("damaged", (why) => this.failed(why));
    link.events.on("closed", () => {
      this.events.emit("closed", undefined);
      if (this.lit) this.banner.keep("The program that served this page has ended; what you see stays.");
      else this.curtain.say("There is no scene here", NO_SCENE);
    });
  }

  private furnish(): void {
    const { sidebar, navigation } = this;
    const move = new Move(navigation);
    this.light.addReadings(sidebar);
    sidebar.add("View", new View(this).element);
    this.light.addControls(sidebar);
    sidebar.add("Move", move.element, false);
    this.events.on("scene", (lit) => {
      move.take(lit);
      sidebar.title = lit.head.title;
    });
    this.root.append(
      this.legend.element, this.statistics, h("div", { className: "crosshair" }),
      navigation.stick.element, this.banner.element, new Toolbar(navigation, this.commands).element,
      this.bareCorner(), this.curtain.element,
    );
    navigation.events.on("mode", (mode) => (this.root.dataset.mode = mode));
    this.root.dataset.mode = navigation.mode;
  }

  /** Where fingers have all back that was hidden. */
  private bareCorner(): HTMLElement {
    const corner = h("button", { type: "button", className: "bare-corner", ariaLabel: "Show all again" });
    corner.onclick = () => this.commands.hideAll();
    return corner;
  }

  private watch(): void {
    const { canvas, stage, statistics } = this;
    new ResizeObserver(() => stage.resize(canvas.clientWidth, canvas.clientHeight)).observe(canvas);
    document.addEventListener("pointerlockchange", () =>
      this.root.classList.toggle("captured", document.pointerLockElement === canvas),
    );
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.curtain.say("The graphics card was taken away", "The picture comes back as soon as the browser returns it.", true);
    });
    canvas.addEventListener("webglcontextrestored", () => {
      this.curtain.rise();
      stage.invalidate();
    });
    stage.afterFrame.push(() => {
      if (statistics.hidden) return;
      const { frames, script } = stage.statistics.speed;
      statistics.textContent = `${frames.toFixed(0)} pictures/s · ${script.toFixed(1)} ms of script each`;
    });
  }

  private take(packet: Packet): void {
    try {
      if (packet.head.type === "light") this.takeLight(packet);
      else this.takeScene(packet);
    } catch (error) {
      return this.failed((error as Error).message);
    }
    this.events.emit("head", packet.head);
  }

  private takeLight(packet: Packet): void {
    if (!this.lit) return;
    this.lit.relight(packet);
    this.isLit = true;
    this.lightChanged();
    this.banner.keep("");
  }

  private takeScene(packet: Packet): void {
    const isFirst = !this.lit;
    const lit = new LitScene(packet);
    if (lit.head.version !== VERSION) throw new Error("it was made by another version of radiosity than this page");
    if (!lit.count) throw new Error("it has no surfaces");
    this.lit = lit;
    this.isLit = lit.head.is_lit;
    document.title = lit.head.title;
    this.stage.show(lit, this.isLit);
    this.navigation.take(lit);
    if (isFirst) this.begin(lit);
    this.curtain.rise();
    this.banner.keep(this.isLit ? "" : "Waiting for light …");
    this.events.emit("scene", lit);
  }

  /** The first scene is shown as the address of the page says. */
  private begin({ head }: LitScene): void {
    const state = read(location.hash);
    this.set({ unit: head.unit as Unit, ...state?.settings });
    if (!state) return;
    const position = new Vector3(...state.position).sub(new Vector3(...head.origin));
    this.navigation.lookAt(position, position.clone().add(new Vector3(...state.forward)));
    this.stage.verticalAngle = state.angle;
    if (state.mode === "fly" || state.mode === "walk") this.navigation.setMode(state.mode, false);
  }

  /** Says what cannot be shown; a picture that there is stays. */
  private failed(why: string): void {
    if (this.lit) this.banner.say(`What came last cannot be shown: ${why}.`, 10_000);
    else this.curtain.say("This scene cannot be shown", `Its data is damaged or of another kind: ${why}. Make it anew with \`radiosity view\`.`);
  }

  private lightChanged(): void {
    if (!this.lit) return;
    this.stage.show(this.lit, this.isLit);
    this.events.emit("light", this.lit);
  }
}
