/** The paths of runs that are compared, on the plan of their world. */

import type { Point } from "../api";
import { inkNow } from "../charts/chart";
import { type Curve, type Figure, rangeOf } from "../charts/figure";
import { rowAt } from "../charts/rows";
import { savingMenu } from "../charts/saving";
import { Plan } from "../plan/plan";
import { filled, inkOf } from "../plan/shapes";
import type { PlanShape } from "../run/protocol";
import { button } from "../ui/controls";
import { el } from "../ui/dom";
import { icon } from "../ui/icons";
import { faded, inLight, readTokens } from "../ui/ink";
import { makeTile, type Tile } from "../ui/tile";
import { word } from "../words/words";
import { type Comparison, type Group, type RunPath, styleOf } from "./comparison";

/** Paths of more runs of a group are drawn paler, and their spots smaller. */
const FEW = 3;
/** What stands in the way of robots. */
const SOLID = new Set(["wall", "obstacle"]);

export class ComparePlan {
  readonly tile: Tile;
  private readonly host = el("div", {
    class: "run-floor",
    tabindex: 0,
    role: "group",
    "aria-label": word("run.planKeys"),
  });
  private readonly note = el("p", { class: "hint compare-no-plan" }, word("review.noPathsWereKept"));
  private readonly legend = el("span", { class: "run-legend" });
  private readonly plan = new Plan(this.host);
  private paths: { path: RunPath; group: number }[] = [];
  private labels: string[] = [];
  private time = 0;

  constructor() {
    const fit = button(
      { class: "quiet square", title: word("review.showTheWholePlan") },
      () => this.plan.fit(),
      icon("fit"),
    );
    const spring = el("span", { class: "run-spring" });
    this.host.append(this.note);
    this.tile = makeTile("compare", word("review.paths"), this.host, this.legend, spring, fit, savingMenu(this));
    this.plan.hiddenKinds.add("robot");
    this.plan.overlay.push((context) => this.draw(context));
  }

  take({ groups, scene }: Comparison): void {
    this.paths = groups.flatMap((group, k) => group.paths.map((path) => ({ path, group: k })));
    this.labels = groups.map(({ label }) => label);
    this.note.hidden = this.paths.length > 0;
    this.legend.textContent = this.paths.length ? told(groups) : "";
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

  /** The paths as vectors on white, with what stands in the way. */
  figure(): Figure {
    return inLight(() => {
      const curves = [...this.curves("truth"), ...this.curves("estimate")];
      const shapes = this.plan.items
        .filter(({ kind }) => SOLID.has(kind))
        .flatMap((item) => filled(item).flatMap((polygons, k) => painted(polygons, item.shapes[k])));
      const corners = shapes.flatMap(({ points }) => points);
      const range = (of: "x" | "y"): [number, number] =>
        rangeOf([...curves.map((curve) => curve[of]), corners.map(([x, y]) => (of === "x" ? x : y))]);
      const axes = { x: "x [m]", y: "y [m]", xRange: range("x"), yRange: range("y"), equal: true };
      return { title: word("review.paths"), ...axes, curves, shapes, ink: inkNow() };
    });
  }

  table(): (string | number | null | undefined)[][] {
    const rows = this.paths.flatMap(({ path: { seed, time, truth, estimate }, group }) =>
      time.map((at, k) => [this.labels[group], seed, at, ...pointOf(truth[k]), ...pointOf(estimate[k])]),
    );
    return [["label", "seed", "time [s]", "truth x [m]", "truth y [m]", "estimate x [m]", "estimate y [m]"], ...rows];
  }

  private style(group: number): ReturnType<typeof styleOf> {
    return styleOf(group, this.labels.length);
  }

  /** How strong lines are: of many runs that lie upon each other each is paler. */
  private strength(): { truth: number; estimate: number } {
    const each = Math.max(...this.labels.map((_, k) => this.paths.filter(({ group }) => group === k).length));
    return each > FEW ? { truth: 0.1, estimate: 0.5 } : { truth: 0.28, estimate: 1 };
  }

  private curves(which: "truth" | "estimate"): Curve[] {
    return this.paths.map(({ path, group }, k): Curve => {
      const { color, dash, width } = this.style(group);
      const points = path[which].map(pointOf);
      const [x, y] = [points.map(([x]) => x), points.map(([, y]) => y)];
      const strength = this.strength();
      if (which === "truth")
        return {
          label: k ? "" : word("review.truthWideAndPale"),
          color: faded(color(), strength.truth),
          width: 5,
          x,
          y,
        };
      const first = this.paths.findIndex((other) => other.group === group) === k;
      return {
        label: first ? (this.labels[group] ?? "") : "",
        color: strength.estimate < 1 ? faded(color(), strength.estimate) : color(),
        width,
        ...(dash ? { dash } : {}),
        x,
        y,
      };
    });
  }

  private draw(context: CanvasRenderingContext2D): void {
    context.save();
    context.lineJoin = context.lineCap = "round";
    const { truth, estimate } = this.strength();
    for (const { path, group } of this.paths)
      this.line(context, path.truth, faded(this.style(group).color(), truth), 5, []);
    for (const { path, group } of this.paths) {
      const { color, dash, width } = this.style(group);
      this.line(context, path.estimate, estimate < 1 ? faded(color(), estimate) : color(), width, dash ?? []);
    }
    for (const { path, group } of this.paths) this.spot(context, path, this.style(group).color());
    context.restore();
  }

  private line(
    context: CanvasRenderingContext2D,
    points: Partial<Point>[],
    color: string,
    width: number,
    dash: number[],
  ): void {
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
    const size = this.strength().estimate < 1 ? 3.5 : 5.5;
    const [was, believed] = [truth[row], estimate[row]];
    context.setLineDash([]);
    for (const [point, filled] of [
      [was, false],
      [believed, true],
    ] as const) {
      if (!point || !isKnown(point)) continue;
      const [x, y] = this.plan.view.toScreen(point);
      context.beginPath();
      context.arc(x, y, size, 0, 2 * Math.PI);
      context.fillStyle = filled ? color : readTokens().paper;
      context.strokeStyle = filled ? readTokens().paper : color;
      context.lineWidth = 2;
      context.fill();
      context.stroke();
    }
  }
}

/** What the lines are, and which paths are missing. */
function told(groups: Group[]): string {
  const without = groups.filter(({ paths }) => !paths.length).map(({ label }) => label);
  const [drawn, runs] = [
    groups.reduce((sum, { paths }) => sum + paths.length, 0),
    groups.reduce((sum, each) => sum + each.runs, 0),
  ];
  const lines = word("review.linesEstimatesWideAndPale");
  if (without.length) return word("review.linesButNotOf", { lines, labels: without.join(", ") });
  return drawn < runs ? word("review.linesOfRuns", { lines, drawn, runs }) : lines;
}

/** Outlines with the fill of a shape. */
function painted(polygons: Point[][], shape: PlanShape | undefined): { points: Point[]; fill: string }[] {
  const fill = shape && inkOf(shape, true, readTokens(), {}).fill;
  return fill ? polygons.map((points) => ({ points, fill })) : [];
}

/** x and y; null where it is not known. */
function pointOf(point: Partial<Point> | undefined): [number | null, number | null] {
  return point && isKnown(point) ? point : [null, null];
}

function isKnown(point: Partial<Point>): point is Point {
  return typeof point[0] === "number" && typeof point[1] === "number";
}
