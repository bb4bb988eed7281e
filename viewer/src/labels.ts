// Small texts at places of the scene, over the picture.

import { Vector3 } from "three";
import type { Point } from "./field";
import type { Stage } from "./stage";

export interface Label {
  point: Point;
  text: string;
  /** CSS classes beside "place-label". */
  kind?: string;
}

export class Labels {
  private readonly root = document.createElement("div");
  private labels: { point: Vector3; element: HTMLElement }[] = [];

  constructor(private readonly stage: Stage, parent: HTMLElement) {
    this.root.className = "place-labels";
    this.root.setAttribute("aria-hidden", "true"); // panels say the same
    parent.append(this.root);
    stage.afterFrame.push(() => this.place());
  }

  /** Shows these and no others. */
  show(labels: Label[]): void {
    this.labels = labels.map(({ point, text, kind }) => {
      const element = document.createElement("span");
      element.className = kind ? `place-label ${kind}` : "place-label";
      element.textContent = text;
      return { point: new Vector3(...point), element };
    });
    this.root.replaceChildren(...this.labels.map(({ element }) => element));
    this.stage.invalidate();
  }

  private place(): void {
    const { camera, renderer } = this.stage;
    const { clientWidth: width, clientHeight: height } = renderer.domElement;
    for (const { point, element } of this.labels) {
      const { x, y, z } = point.clone().project(camera);
      element.hidden = z > 1 || Math.abs(x) > 1 || Math.abs(y) > 1;
      element.style.transform = `translate(${((x + 1) / 2) * width}px, ${((1 - y) / 2) * height}px)`;
    }
  }
}
