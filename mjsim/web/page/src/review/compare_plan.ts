/** The paths of runs that are compared, on the plan of their world. */

import { rowAt } from "../charts/chart";
import { el } from "../dom";
import type { Point } from "../api";
import { Plan } from "../plan/plan";
import { button, sign } from "../run/controls";
import { faded, readTokens } from "../run/ink";
import { makeTile, type Tile } from "../run/tile";
import type { Comparison, RunPath } from "./comparison";
import { styleOf } from "./compare";

export class ComparePlan {
  readonly tile: Tile;
  private readonly host = el("div", { class: "run-floor", tabindex: 0, role: "group", "aria-label": "Plan; + - and 0 zoom" });
  private readonly note = el("p", { class: "hint compare-no-plan" }, "No paths: a sweep keeps errors over time only.");
  private readonly legend = el("span", { class: "run-legend" });
  private readonly plan = new Plan(this.host);
  private paths: { path: RunPath; group: number }[] = [];
  private time = 0;

  constructor() {
    const fit = button({ class: "quiet square", title: "Show the whole plan (0)" }, () => this.plan.fit(), sign("fit"));
    const spring = el("span", { class: "run-spring" });
    this.host.append(this.note);
    this.tile = makeTile("compare", "Paths", this.host, this.legend, spring, fit);
    this.plan.hiddenKinds.add("robot");
    this.plan.overlay.push((context) => this.draw(context));
  }

  take({ groups, scene }: Comparison): void {
    this.paths = groups.flatMap((group, k) => group.paths.map((path) => ({ path, group: k })));
    this.note.hidden = this.paths.length > 0;
    this.legend.textContent = this.paths.length ? "lines: estimates; wide and pale: the truth" : "";
    this.plan.forgetView();
    this.plan.setItems(scene?.items ?? [], scene?.bounds ?? [0, 0, 8, 6]);
  }

  show(time: number): void {
    this.time = time;
    this.plan.drawOver();
  }

  key(event: KeyboardEvent): boolean {
    return this.plan.key(event);
  }

  private draw(context: CanvasRenderingContext2D): void {
    context.save();
    context.lineJoin = context.lineCap = "round";
    for (const { path, group } of this.paths) this.line(context, path.truth, faded(styleOf(group).color(), 0.28), 5, []);
    for (const { path, group } of this.paths) {
      const { color, dash } = styleOf(group);
      this.line(context, path.estimate, color(), 1.75, dash ?? []);
    }
    for (const { path, group } of this.paths) this.spot(context, path, styleOf(group).color());
    context.restore();
  }

  private line(context: CanvasRenderingContext2D, points: Partial<Point>[], color: string, width: number, dash: number[]): void {
    context.beginPath();
    let begun = false;
    for (const point of points) {
      const [x, y] = isKnown(point) ? this.plan.view.toScreen(point) : [null, 0];
      if (x === null) begun = false;
      else if (begun) context.lineTo(x, y);
      else context.moveTo(x, y);
      begun = x !== null;
    }
    context.setLineDash(dash);
    context.strokeStyle = color;
    context.lineWidth = width;
    context.stroke();
  }

  /** Where a run believed to be at the time that is looked at, and where it was. */
  private spot(context: CanvasRenderingContext2D, { time, truth, estimate }: RunPath, color: string): void {
    const row = rowAt(time, this.time + 1e-6);
    const [was, believed] = [truth[row], estimate[row]];
    context.setLineDash([]);
    for (const [point, filled] of [[was, false], [believed, true]] as const) {
      if (!point || !isKnown(point)) continue;
      const [x, y] = this.plan.view.toScreen(point);
      context.beginPath();
      context.arc(x, y, 5.5, 0, 2 * Math.PI);
      context.fillStyle = filled ? color : readTokens().paper;
      context.strokeStyle = filled ? readTokens().paper : color;
      context.lineWidth = 2;
      context.fill();
      context.stroke();
    }
  }
}

function isKnown(point: Partial<Point>): point is Point {
  return typeof point[0] === "number" && typeof point[1] === "number";
}
