// One row a lamp: on or off, dimmed, coloured, alone.

import type { App } from "../app";
import type { Control } from "../control";
import { h } from "../dom";
import { AS_IN_SCENE, BRIGHTEST, dimmed, dimmerPlace, isChanged, type LampSetting } from "../mixing";
import { button, colourField, numberField, slider, toggle } from "../ui";
import "./lamps.css";

interface LampRow {
  element: HTMLElement;
  show: (setting: LampSetting) => void;
}

export class Lamps {
  readonly element = h("div", { className: "lamps" });
  private rows: LampRow[] = [];
  private readonly reason = h("p", { className: "reason" });
  private readonly fields = h("fieldset", {});
  private readonly reset = button({ label: "As in the scene" }, () => this.setAll(() => AS_IN_SCENE));
  private readonly allOn = button({ label: "All on" }, () => this.setAll((lamp) => ({ ...lamp, isOn: true })));

  constructor(
    private readonly app: App,
    private readonly control: Control,
  ) {
    this.element.append(this.reason, this.fields);
    app.events.on("scene", () => this.build());
    control.events.on("settings", () => this.show());
    control.events.on("means", () => this.show());
  }

  private setAll(change: (lamp: LampSetting) => LampSetting): void {
    this.control.setLamps(this.control.lamps.map(change));
  }

  private build(): void {
    const { head } = this.app.lit!;
    this.rows = head.lamps.map(({ name }, k) => this.row(name, k, head.bands.length === 3));
    const buttons = h("div", { className: "buttons" }, this.allOn, this.reset);
    this.fields.replaceChildren(...this.rows.map(({ element }) => element), buttons);
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
    const set = (change: Partial<LampSetting>) => control.setLamp(which, change);
    const on = toggle({ label: name }, (isOn) => set({ isOn }));
    const dimmer = slider({ label: `${name}: dimmer`, title: "Twice clicked: as in the scene", min: 0, max: 1, step: 0.005 }, (place) =>
      set({ dimmer: rounded(dimmed(place)), isOn: true }),
    );
    dimmer.ondblclick = () => set({ dimmer: 1 });
    const number = numberField({ label: `${name}: factor`, min: 0, max: BRIGHTEST }, (factor) => set({ dimmer: factor }));
    const colour = colourField({ label: `${name}: filter`, title: "Colour of a filter before it" }, (filter) =>
      set({ colour: filter }),
    );
    const solo = button({ label: "Solo", title: "This lamp alone" }, () => control.solo(which));
    const element = h(
      "div", { className: "lamp" }, on.element, solo, h("div", { className: "dimmer" }, dimmer, number, isColoured && colour),
    );
    return {
      element,
      show: (setting) => {
        on.input.checked = setting.isOn;
        // A slider that says the same already stays where it was put.
        if (rounded(dimmed(dimmer.valueAsNumber)) !== setting.dimmer) dimmer.valueAsNumber = dimmerPlace(setting.dimmer);
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
