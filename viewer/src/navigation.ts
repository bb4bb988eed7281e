// Moving through the scene: around what is looked at, on foot, or through the air.

import { MOUSE, Matrix4, Quaternion, TOUCH, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { bodyFor } from "./body";
import { Obstacles } from "./collide";
import { Compass } from "./compass";
import { Events } from "./events";
import { Flight, isCalm, type View } from "./flight";
import { Keyboard } from "./keyboard";
import type { LitScene } from "./light";
import type { CameraHead } from "./messages";
import { Pointer } from "./pointer";
import type { Rays } from "./rays";
import type { Stage } from "./stage";
import { Stick } from "./stick";
import { Walker } from "./walk";

export type Mode = "orbit" | "walk" | "fly";

/** Radians a second that arrow keys turn. */
const TURNS = 1.6;

/** Seconds of walking for a notch of the wheel, and for a gesture over the whole height of the picture. */
const NOTCH = 0.25;
const GESTURE = 3;

interface Happenings {
  mode: Mode;
  /** Something that the panel shows is another: speed, height of the eyes, collisions, or a camera was chosen. */
  change: undefined;
}

export class Navigation {
  readonly events = new Events<Happenings>();
  readonly keyboard = new Keyboard();
  readonly stick = new Stick();
  readonly pointer: Pointer;
  readonly walker = new Walker(new Compass([0, 1, 0]), bodyFor(1, 1));
  /** What a click that does not capture the mouse is for; pixels from the upper left corner of the picture. */
  onClick: (x: number, y: number) => void = () => {};
  mode: Mode = "orbit";
  /** The camera that was chosen last. */
  camera = 0;
  private lit: LitScene | null = null;
  private orbit: OrbitControls | null = null;
  private flight: Flight | null = null;
  private eyeHeight = 1.65;
  /** Whether the camera is where a file or a script put it, rolled or not, until somebody moves. */
  private isUntouched = true;

  constructor(
    private readonly stage: Stage,
    private readonly canvas: HTMLCanvasElement,
    private readonly rays: Rays,
  ) {
    this.pointer = new Pointer(
      canvas,
      {
        look: (yaw, pitch) => this.look(yaw, pitch),
        walk: (ahead, right) => this.nudge(GESTURE * ahead, GESTURE * right),
        wheel: (notches) => this.nudge(NOTCH * notches, 0),
        click: (x, y, isMouse) => this.click(x, y, isMouse),
      },
      () => stage.verticalAngle / Math.max(canvas.clientHeight, 1),
    );
    this.keyboard.onMove = () => this.mode === "orbit" && this.setMode("walk");
    this.stick.onTake = () => this.keyboard.onMove();
    rays.onReady = () => this.meet();
    stage.beforeFrame.push((seconds) => this.advance(seconds));
  }

  /** Other patches are shown; the first ones from their first camera. */
  take(lit: LitScene): void {
    const isFirst = !this.lit;
    this.lit = lit;
    if (isFirst) this.walker.compass = new Compass(lit.head.up);
    this.fit();
    if (!isFirst) return;
    this.stage.lookThrough(lit.head.cameras[0]);
    this.begin();
  }

  /** @param stands whether one goes where one can stand before one walks. */
  setMode(mode: Mode, stands = true): void {
    if (mode === this.mode) return;
    const wasOrbit = this.mode === "orbit";
    this.mode = mode;
    this.walker.isFlying = mode === "fly";
    if (mode === "orbit") this.pointer.free();
    this.begin();
    if (mode === "walk" && wasOrbit && stands) this.stand();
    this.events.emit("mode", mode);
  }

  /** Goes to a camera of the file by its index, smoothly unless that is unwanted. */
  goTo(camera: number, isAtOnce = isCalm()): void {
    const head = this.lit?.head.cameras[camera];
    if (!head) return;
    this.camera = camera;
    this.lead(viewOf(head), isAtOnce);
    this.events.emit("change", undefined);
  }

  /** Looks from a place to another at once; metres, relative to the origin of the scene. */
  lookAt(position: Vector3, target: Vector3): void {
    const { up } = this.walker.compass;
    this.lead({ position, orientation: facing(target.clone().sub(position), up), angle: this.stage.verticalAngle }, true);
  }

  /** Metres above the ground, if the body were a person's. */
  get personEye(): number {
    return this.eyeHeight;
  }

  set personEye(eye: number) {
    this.eyeHeight = eye;
    this.fit();
    this.events.emit("change", undefined);
  }

  /** Moves on for a while, as if a picture had taken that long. Returns whether there is another view. */
  advance(seconds: number): boolean {
    this.stage.meter.isSmooth = this.mode !== "orbit" && !isCalm();
    if (this.flight) return this.fly(seconds);
    if (this.mode === "orbit") return !this.isUntouched && (this.orbit?.update() ?? false);
    const { walker, keyboard, stick } = this;
    const wish = keyboard.wish;
    if (wish.turn) walker.turn(wish.turn * TURNS * seconds, 0);
    wish.ahead += stick.ahead;
    wish.right += stick.right;
    const isMoved = walker.advance(seconds, wish);
    if (isMoved || wish.turn) this.place();
    return isMoved || !!wish.turn;
  }

  /** What is left of a way somewhere is done at once. */
  arrive(): void {
    while (this.flight) this.fly(1);
  }

  private fly(seconds: number): boolean {
    const { position, orientation, angle, isEnd } = this.flight!.advance(seconds);
    this.show({ position, orientation, angle });
    if (isEnd) {
      this.flight = null;
      this.begin();
    }
    return true;
  }

  private lead(to: View, isAtOnce: boolean): void {
    const { camera } = this.stage;
    this.pause();
    if (isAtOnce) {
      this.flight = null;
      this.show(to);
      this.begin();
      return;
    }
    const from = { position: camera.position.clone(), orientation: camera.quaternion.clone(), angle: this.stage.verticalAngle };
    this.flight = new Flight(from, to);
  }

  /** Takes the view as it is for what moves it from now on. */
  private begin(): void {
    this.pause();
    this.isUntouched = true;
    const { camera } = this.stage;
    const direction = camera.getWorldDirection(new Vector3());
    this.walker.placeAt(camera.position, direction);
    if (this.mode === "orbit") this.turnAround(direction);
    else this.pointer.isActive = true;
  }

  /** There is something to run into, and to turn around. */
  private meet(): void {
    const { tree } = this.rays;
    this.walker.obstacles = tree && new Obstacles(tree);
    if (this.mode === "orbit" && this.isUntouched && !this.flight && this.orbit) this.begin();
  }

  private pause(): void {
    this.orbit?.dispose();
    this.orbit = null;
    this.canvas.style.touchAction = "none"; // orbiting takes it away
    this.pointer.isActive = false;
  }

  private turnAround(direction: Vector3): void {
    const { camera } = this.stage;
    const { quaternion } = camera.clone();
    camera.up.copy(this.walker.compass.up);
    const orbit = new OrbitControls(camera, this.canvas);
    orbit.target.copy(camera.position).addScaledVector(direction, this.sight(direction));
    orbit.zoomToCursor = true;
    orbit.enableDamping = !isCalm();
    orbit.dampingFactor = 0.12;
    orbit.screenSpacePanning = true;
    orbit.minDistance = 4 * camera.near;
    orbit.maxDistance = camera.far / 4;
    orbit.mouseButtons = { LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.PAN };
    orbit.touches = { ONE: TOUCH.ROTATE, TWO: TOUCH.DOLLY_PAN };
    orbit.addEventListener("start", () => (this.isUntouched = false));
    orbit.addEventListener("change", () => this.stage.invalidate());
    orbit.update();
    camera.quaternion.copy(quaternion); // a camera that is rolled stays so until it is moved
    this.orbit = orbit;
  }

  /** Metres to what is in the middle of the picture; to the middle of the scene if nothing is. */
  private sight(direction: Vector3): number {
    const { lit, stage, rays } = this;
    if (!lit) return 1;
    const { x, y, z } = stage.camera.position;
    const hit = rays.tree && rays.closest([x, y, z], [direction.x, direction.y, direction.z]);
    const middle = lit.sphere().center.sub(stage.camera.position).dot(direction);
    return hit?.distance ?? Math.max(middle, 0.1 * lit.size, 1e-6);
  }

  /** From a place where nobody can stand to one near what is looked at, if there is one. */
  private stand(): void {
    const { walker } = this;
    this.rays.now();
    if (!walker.obstacles) return;
    const to = walker.standNear();
    if (!to || to.distanceTo(walker.eye) < walker.body.radius) return;
    const { up } = walker.compass;
    const direction = walker.compass.level(walker.heading.yaw);
    this.lead({ position: to, orientation: facing(direction, up), angle: this.stage.verticalAngle }, isCalm());
  }

  private fit(): void {
    const { lit, walker } = this;
    if (!lit) return;
    const { up } = walker.compass;
    const height = Math.abs(up.x * (lit.high[0] - lit.low[0])) + Math.abs(up.y * (lit.high[1] - lit.low[1])) +
      Math.abs(up.z * (lit.high[2] - lit.low[2]));
    walker.body = bodyFor(height, lit.size, this.eyeHeight);
  }

  private look(yaw: number, pitch: number): void {
    if (this.mode === "orbit" || this.flight) return;
    this.walker.turn(yaw, pitch);
    this.place();
  }

  /** Walks for some seconds at once. */
  private nudge(ahead: number, right: number): void {
    if (this.mode === "orbit" || this.flight) return;
    const seconds = Math.hypot(ahead, right);
    if (!seconds) return;
    this.walker.advance(seconds, { ahead: ahead / seconds, right: right / seconds, up: 0, isFast: false });
    this.place();
  }

  private click(x: number, y: number, isMouse: boolean): void {
    if (isMouse && this.mode !== "orbit" && !this.pointer.isCaptured) void this.pointer.capture();
    else this.onClick(x, y);
  }

  /** Puts the camera where the walker's eyes are. */
  private place(): void {
    const { walker, stage } = this;
    this.isUntouched = false;
    stage.camera.position.copy(walker.eye);
    stage.camera.quaternion.copy(facing(walker.direction, walker.compass.up));
    stage.invalidate();
  }

  private show({ position, orientation, angle }: View): void {
    const { camera } = this.stage;
    camera.position.copy(position);
    camera.quaternion.copy(orientation);
    this.stage.verticalAngle = angle;
  }
}

function viewOf({ position, forward, up, vertical_fov }: CameraHead): View {
  const orientation = facing(new Vector3(...forward), new Vector3(...up));
  return { position: new Vector3(...position), orientation, angle: vertical_fov };
}

function facing(direction: Vector3, up: Vector3): Quaternion {
  const matrix = new Matrix4().lookAt(new Vector3(), direction, up);
  return new Quaternion().setFromRotationMatrix(matrix);
}
