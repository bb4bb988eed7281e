// What panels draw over the picture: a picture of its own, so that what measures or saves the one below sees light alone.

import * as THREE from "three";
import type { Stage } from "./stage";

export class Overlay {
  private readonly scene = new THREE.Scene();

  constructor(readonly stage: Stage) {
    stage.afterFrame.push(() => this.draw());
  }

  add(object: THREE.Mesh): void {
    this.scene.add(object);
    this.stage.invalidate();
  }

  /** Takes it away, and its geometry from the graphics card. */
  remove(object: THREE.Mesh): void {
    this.scene.remove(object);
    object.geometry.dispose();
    this.stage.invalidate();
  }

  private draw(): void {
    if (!this.scene.children.length) return;
    const { renderer, camera } = this.stage;
    renderer.autoClear = false;
    renderer.render(this.scene, camera);
    renderer.autoClear = true;
  }
}
