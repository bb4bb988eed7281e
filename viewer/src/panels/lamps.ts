// One row a lamp: on or off, dimmed, coloured, alone.

import type { App } from "../app";
import type { Control } from "../control";
import { h } from "../dom";
import { AS_IN_SCENE, BRIGHTEST, dimmed, dimmerPlace, isChanged, type LampSetting } from "../mixing";
import "./lamps.css";

interface LampRow {
  element: HTMLElement;
  show: (setting: LampSetting) => void;
}

export class Lamps {
  readonly element = h("div", { className: "lamps" });
  /** Called when it is known whether there are any. */
  onCount: (count: number) => void = () => {};
  private rows: LampRow[] = [];
  private readonly reason = h("p", { className: "reason" });
  private readonly fields = h("fieldset", {});
  private readonly reset = h("button", { type: "button", className: "plain" }, "As in the scene");
  private readonly allOn = h("button", { type: "button", className: "plain" }, "All on");

  constructor(
    private readonly app: App,
    private readonly control: Control,
  ) {
    this.reset.onclick = () => control.setLamps(control.lamps.map(() => AS_IN_SCENE));
    this.allOn.onclick = () => control.setLamps(control.lamps.map((lamp) => ({ ...lamp, isOn: true })));
    this.element.append(this.reason, this.fields);
    app.events.on("scene", () => this.build());
    control.events.on("settings", () => this.show());
    control.events.on("means", () => this.show());
  }

  private build(): void {
    const { head } = this.app.lit!;
    this.rows = head.lamps.map(({ name }, k) => this.row(name, k, head.bands.length === 3));
    const buttons = h("div", { className: "buttons" }, this.allOn, this.reset);
    this.fields.replaceChildren(...this.rows.map(({ element }) => element), buttons);
    this.onCount(head.lamps.length);
    this.show();
  }

  private show(): void {
    const { control } = this;
    const reason = control.lampsFixed;
    this.reason.textContent = reason;
    this.reason.hidden = !reason;
    this.fields.disabled = !!reason;
    this.rows.forEach((row, k) => row.show(control.lamps[k] ?? AS_IN_SCENE));
    this.reset.disabled = !control.lamps.some(isChanged);
    this.allOn.disabled = control.lamps.every(({ isOn }) => isOn);
  }

  private row(name: string, which: number, isColoured: boolean): LampRow {
    const { control } = this;
    const on = h("input", { type: "checkbox", role: "switch" });
    const slider = h("input", { type: "range", min: "0", max: "1", step: "0.005", "aria-label": `${name}: dimmer` });
    const number = h("input", {
      type: "number", min: "0", max: String(BRIGHTEST), step: "any", "aria-label": `${name}: factor`,
    });
    const colour = h("input", { type: "color", "aria-label": `${name}: filter`, title: "Colour of a filter before it" });
    const solo = h("button", { type: "button", className: "plain", title: "This lamp alone" }, "solo");
    on.onchange = () => control.setLamp(which, { isOn: on.checked });
    slider.oninput = () => control.setLamp(which, { dimmer: rounded(dimmed(slider.valueAsNumber)), isOn: true });
    slider.ondblclick = () => control.setLamp(which, { dimmer: 1 });
    number.onchange = () => {
      const dimmer = Math.min(Math.max(number.valueAsNumber || 0, 0), BRIGHTEST);
      control.setLamp(which, { dimmer });
    };
    colour.oninput = () => control.setLamp(which, { colour: colour.value });
    solo.onclick = () => control.solo(which);
    const element = h(
      "div", { className: "lamp" }, h("label", {}, on, h("span", { className: "name" }, name)), solo,
      h("div", { className: "dimmer" }, slider, number, isColoured && colour),
    );
    return {
      element,
      show: (setting) => {
        on.checked = setting.isOn;
        if (document.activeElement !== slider) slider.valueAsNumber = dimmerPlace(setting.dimmer);
        if (document.activeElement !== number) number.value = String(rounded(setting.dimmer));
        colour.value = setting.colour;
        element.classList.toggle("off", !setting.isOn);
      },
    };
  }
}

/** Two digits, as many as the slider is worth. */
function rounded(factor: number): number {
  return factor < 0.1 ? Number(factor.toFixed(3)) : Number(factor.toFixed(2));
}
