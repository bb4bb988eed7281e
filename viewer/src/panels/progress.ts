// How far the session is, and how the error fell; one line when there is nothing more to wait for.

import type { App } from "../app";
import type { Control } from "../control";
import { h } from "../dom";
import { duration, percent, whole } from "../figures";
import type { Convergence, Head, Status } from "../messages";
import { plot, type Curve } from "../plot";
import { reportLine, reportLines, type Report } from "../report";
import { button } from "../ui";
import "./progress.css";

/** Names of the curves by stage. */
const CURVES: Record<string, string> = { shooting: "unshot light", solving: "estimated error" };

export class Progress {
  readonly element = h("div", { className: "progress" });
  private readonly line = h("p", { className: "line", role: "status" });
  private readonly bar = h("progress", { max: 1 });
  private readonly stop: HTMLButtonElement;
  private readonly figure = h("figure", {});
  private readonly details = h("details", {}, h("summary", {}, "How it was found"));
  private readonly table = h("table", {});
  private readonly history: Convergence[] = [];
  private status: Status | null = null;
  private report: Report = {};
  private seconds = NaN;
  private isDrawn = true;

  constructor(app: App, control: Control) {
    this.stop = button({ label: "Stop", title: "What was found so far stays" }, () => {
      this.stop.disabled = true;
      control.stop();
    });
    this.details.append(this.table);
    this.element.append(h("div", { className: "working" }, this.bar, this.stop), this.line, this.figure, this.details);
    app.events.on("head", (head) => this.takeHead(head));
    app.events.on("message", (message) => {
      if (message.type === "status") this.takeStatus(message);
      else if (message.type === "convergence") this.takePoint(message);
    });
    app.events.on("closed", () => this.takeStatus(null));
    this.show();
  }

  private get isWorking(): boolean {
    return this.status !== null && this.status.stage !== "ready";
  }

  private takeHead(head: Head): void {
    if (Object.keys(head.report).length) this.report = head.report;
    if (head.type === "light" && head.is_final) this.seconds = head.seconds;
    this.show();
  }

  private takeStatus(status: Status | null): void {
    if (status?.stage !== this.status?.stage) this.stop.disabled = false;
    this.status = status;
    this.show();
  }

  private takePoint(point: Convergence): void {
    // A page that comes later hears all of it; one that comes back hears it again.
    const last = this.history.at(-1);
    if (last && point.seconds < last.seconds) this.history.length = 0;
    this.history.push(point);
    if (!this.isDrawn) return;
    this.isDrawn = false;
    requestAnimationFrame(() => this.show());
  }

  private show(): void {
    const { status, isWorking, history } = this;
    this.element.classList.toggle("is-working", isWorking);
    this.stop.hidden = !isWorking || status!.stage === "relighting";
    if (isWorking && status!.done >= 0) this.bar.value = status!.done;
    else this.bar.removeAttribute("value");
    // Screen readers are told what came out, not every step.
    this.line.setAttribute("aria-live", isWorking ? "off" : "polite");
    this.line.textContent = isWorking ? this.now(status!) : this.summary();
    this.isDrawn = true;
    this.figure.hidden = history.length < 2;
    // In sight while it grows; then what is left is one line.
    if (isWorking) this.details.before(this.figure);
    else this.table.before(this.figure);
    if (!this.figure.hidden) this.figure.replaceChildren(...this.picture());
    const lines = reportLines(this.report);
    this.details.hidden = !lines.length && (isWorking || this.figure.hidden);
    this.table.replaceChildren(
      h("tbody", {}, ...lines.map(([label, text]) => h("tr", {}, h("th", { scope: "row" }, label), h("td", {}, text)))),
    );
  }

  private now({ text, stage }: Status): string {
    const last = this.history.at(-1);
    return last && last.patches && stage !== "relighting" ? `${text} · ${whole(last.patches)} patches` : text;
  }

  private summary(): string {
    const spent = this.history.at(-1)?.seconds ?? this.seconds;
    return reportLine(this.report, Number.isFinite(spent) ? duration(spent) : "") || this.status?.text || "";
  }

  private picture(): Element[] {
    const curves = Object.keys(CURVES).map((stage) => this.curve(stage)).filter(({ points }) => points.length);
    const wanted = this.history.at(-1)!.wanted;
    const said = curves.map(({ name, points }) => `${name} ${percent(points.at(-1)!.y)}`).join(", ");
    const key = curves.map(({ name, kind, points }) =>
      h("span", { className: `key ${kind}` }, `${name} ${percent(points.at(-1)!.y)}`),
    );
    const goal = wanted > 0 && h("span", { className: "key wanted" }, `wanted ${percent(wanted)}`);
    return [plot(`Over time: ${said}`, curves, wanted), h("figcaption", {}, ...key, goal)];
  }

  private curve(stage: string): Curve {
    const points = this.history.filter((p) => p.stage === stage && p.error > 0).map((p) => ({ x: p.seconds, y: p.error }));
    return { name: CURVES[stage], kind: stage, points };
  }
}
