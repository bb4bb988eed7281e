// Where one looks from, and how large and fast one is.

import { remark } from "../body";
import { h } from "../dom";
import { figures } from "../figures";
import type { LitScene } from "../light";
import type { Navigation } from "../navigation";
import { field, numberField, select, slider, toggle } from "../ui";

export class Move {
  readonly element = h("div", { className: "move" });
  private readonly cameras = h("div", {});
  private list: HTMLSelectElement | null = null;
  private readonly speed = slider({ label: "Speed", min: -2, max: 3, step: 0.1 }, (octaves) => {
    this.navigation.walker.hurry = 2 ** octaves;
    this.show();
  });
  private readonly speedNow = h("output", {});
  private readonly eye = numberField({ label: "Height of the eyes in metres", min: 0.3, max: 3, step: 0.05 }, (eye) => (this.navigation.personEye = eye));
  private readonly collides = toggle({ label: "Walls stop me" }, (isOn) => (this.navigation.walker.collides = isOn));
  private readonly remark = h("p", { className: "reason" });

  constructor(private readonly navigation: Navigation) {
    this.element.append(
      this.cameras, this.remark,
      field("Speed", this.speed, this.speedNow),
      field("Eyes at", h("div", { className: "pair" }, this.eye, h("span", {}, "m"))),
      field("", this.collides.element),
    );
    navigation.events.on("change", () => this.show());
    navigation.events.on("mode", () => this.show());
  }

  /** Lists the cameras of a scene. */
  take({ head }: LitScene): void {
    const options = head.cameras.map(({ name }, k): [string, string] => [String(k), name || `Camera ${k + 1}`]);
    this.list = select({ label: "Camera" }, options, (k) => this.navigation.goTo(Number(k)));
    this.cameras.replaceChildren(field("Camera", this.list));
    this.show();
  }

  private show(): void {
    const { walker, personEye } = this.navigation;
    if (this.list) this.list.value = String(this.navigation.camera);
    this.speed.valueAsNumber = Math.log2(walker.hurry);
    this.speedNow.textContent = `${figures(walker.body.speed * walker.hurry)} m/s`;
    this.eye.value = String(personEye);
    this.collides.input.checked = walker.collides;
    this.remark.textContent = remark(walker.body);
    this.remark.hidden = !this.remark.textContent;
  }
}
