/** Charts of numbers that were chosen: over time, and one against another. */

import uPlot from "uplot";

import { el, setAttributes } from "../ui/dom";
import { enlarger } from "../ui/enlarge";
import { inLight, readTokens } from "../ui/ink";
import { themeChanged } from "../ui/theme";
import { word } from "../words/words";
import { Chart, type Handlers, inkNow, type Marks, NO_MARKS } from "./chart";
import { colorsOf } from "./colors";
import { type Curve, type Drawing, drawFigure, type Figure, rangeOf } from "./figure";
import { legend } from "./head";
import { type Field, type PlotChart, titleOf } from "./layouts";
import { rowAt } from "./rows";
import { savingMenu } from "./saving";

type Values = (number | null)[];

export interface Column {
  time: number[];
  values: Values;
}

/** A chart of the columns of some fields. */
export interface Plot {
  readonly element: HTMLElement;
  show(columns: Column[]): void;
  mark(marks: Marks): void;
  close(): void;
}

/** Make the chart that a layout asks for, of those of its fields that there are. */
export function makePlot({ kind, equal = false }: PlotChart, fields: Field[], handlers: Handlers, sync: string): Plot {
  if (kind === "time") return new TimePlot(fields, handlers, sync);
  return new XyPlot(fields, equal, handlers);
}

function labelOf([topic, name]: Field): string {
  return `${topic.split("/").pop() ?? ""} ${name}`;
}

class TimePlot implements Plot {
  readonly element: HTMLElement;
  private readonly chart: Chart;

  constructor(fields: Field[], handlers: Handlers, sync: string) {
    const several = fields.length > 1;
    const colorOf = colorsOf(fields);
    const lines = fields.map((field, k) => ({
      label: several ? labelOf(field) : "",
      name: titleOf(field),
      color: () => colorOf(k),
    }));
    const [only] = fields;
    const title = several || !only ? word("charts.chosenNumbers") : titleOf(only);
    this.chart = new Chart({ title, unit: "", lines, digits: 4, each: several, tight: true }, handlers, sync);
    this.element = this.chart.element;
  }

  show(columns: Column[]): void {
    const joined = uPlot.join(columns.map(({ time, values }) => [time, values] as uPlot.AlignedData));
    this.chart.show(joined as unknown as Parameters<Chart["show"]>[0]);
  }

  mark(marks: Marks): void {
    this.chart.mark(marks);
  }

  close(): void {
    this.chart.close();
  }
}

/** A number, or several, against the first one; the point of the time that is looked at is marked. */
class XyPlot implements Plot {
  readonly element = el("figure", { class: "run-chart" });
  private readonly box = el("div", {
    class: "run-chart-box plotter-xy",
    role: "img",
    "data-empty": word("charts.noValues"),
  });
  private readonly reading = el("output", {});
  private readonly endings: (() => void)[] = [];
  private readonly colorOf: (k: number) => string;
  /** A row for each time of a curve. */
  private curves: { time: number[]; x: Values; y: Values }[] = [];
  private drawing: Drawing | null = null;
  private marks = NO_MARKS;

  constructor(
    private readonly fields: Field[],
    private readonly equal: boolean,
    private readonly handlers: Handlers,
  ) {
    const drawn = fields.slice(1);
    this.colorOf = colorsOf(drawn);
    const lines = drawn.map((field, k) => ({
      label: drawn.length > 1 ? labelOf(field) : "",
      color: () => this.colorOf(k),
    }));
    this.box.setAttribute("aria-label", this.title);
    const head = [legend(lines, this.endings), savingMenu(this), enlarger(this.element), this.reading];
    this.element.append(el("figcaption", {}, el("strong", {}, this.title), ...head), this.box);
    const sizes = new ResizeObserver(() => this.draw());
    sizes.observe(this.box);
    this.endings.push(
      () => sizes.disconnect(),
      themeChanged.on(() => this.draw()),
    );
    this.box.addEventListener("pointerup", (event) => this.pick(event));
  }

  show([along, ...columns]: Column[]): void {
    const { time, values } = along ?? { time: [], values: [] };
    this.curves = columns.map((column) => ({
      time: column.time,
      // The newest one that there was; before the first there is none.
      x: column.time.map((at) =>
        (time[0] ?? Number.POSITIVE_INFINITY) <= at ? (values[rowAt(time, at)] ?? null) : null,
      ),
      y: column.values,
    }));
    const known = this.curves.some(({ x, y }) => x.some((each, k) => each !== null && y[k] != null));
    this.element.classList.toggle("unknown", !known);
    this.draw();
  }

  mark(marks: Marks): void {
    this.marks = marks;
    const spots = this.drawing?.svg.querySelector("g.spots");
    if (!this.drawing || !spots) return;
    const marked = this.curves.map((curve) => pointAt(curve, marks.now));
    const { place } = this.drawing;
    const drawn = marked.flatMap((point, k) => (point ? circle(place(...point), this.colorOf(k)) : []));
    spots.replaceChildren(...drawn);
    const [first] = marked;
    this.reading.value = first ? first.map((value) => Number(value.toPrecision(5))).join(", ") : "";
  }

  close(): void {
    for (const end of this.endings) end();
    this.element.remove();
  }

  figure(): Figure {
    return inLight(() => this.figureNow());
  }

  table(): (string | number | null)[][] {
    const [x, ...ys] = this.fields.map(titleOf);
    const rows = this.curves.flatMap((curve, k) =>
      curve.time.map((time, row) => [ys[k] ?? "", time, curve.x[row] ?? null, curve.y[row] ?? null]),
    );
    return [["curve", word("charts.timeAxis"), x ?? "", "value"], ...rows];
  }

  private get title(): string {
    const [x, ...ys] = this.fields.map(labelOf);
    const drawn = ys.join(", ");
    return ys.length ? word("charts.against", { drawn, x }) : word("charts.addANumberFor", { x });
  }

  private figureNow(): Figure {
    const [x, ...ys] = this.fields.map(labelOf);
    const several = ys.length > 1;
    const curves = this.curves.map(
      ({ x, y }, k): Curve => ({ label: several ? (ys[k] ?? "") : "", color: this.colorOf(k), x, y }),
    );
    return {
      title: this.title,
      x: x ?? "",
      y: several ? "" : (ys[0] ?? ""),
      curves,
      xRange: rangeOf(curves.map((curve) => curve.x)),
      yRange: rangeOf(curves.map((curve) => curve.y)),
      equal: this.equal,
      ink: inkNow(),
    };
  }

  private draw(): void {
    const { clientWidth, clientHeight } = this.box;
    if (!clientWidth || !clientHeight) return;
    this.drawing = drawFigure(this.figureNow(), [clientWidth, clientHeight], false);
    const spots = document.createElementNS("http://www.w3.org/2000/svg", "g");
    spots.setAttribute("class", "spots");
    this.drawing.svg.append(spots);
    this.box.replaceChildren(this.drawing.svg);
    this.mark(this.marks);
  }

  /** Choose the time of the point that is nearest to the pointer. */
  private pick(event: PointerEvent): void {
    const { left, top } = this.box.getBoundingClientRect();
    let [nearest, best] = [null as number | null, Number.POSITIVE_INFINITY];
    for (const { time, x, y } of this.curves)
      time.forEach((at, k) => {
        const [px, py] = [x[k], y[k]];
        if (px == null || py == null || !this.drawing) return;
        const [across, down] = this.drawing.place(px, py);
        const far = Math.hypot(across - (event.clientX - left), down - (event.clientY - top));
        if (far < best) [nearest, best] = [at, far];
      });
    if (nearest !== null) this.handlers.pick?.(nearest);
  }
}

/** Where a curve is at a time; at its end where none is looked at. */
function pointAt(
  { time, x, y }: { time: number[]; x: Values; y: Values },
  now: number | null,
): [number, number] | null {
  if (!time.length || (now !== null && now + 1e-6 < (time[0] ?? 0))) return null;
  const row = now === null ? time.length - 1 : rowAt(time, now + 1e-6);
  const [across, up] = [x[row], y[row]];
  return across == null || up == null ? null : [across, up];
}

function circle([x, y]: [number, number], color: string): SVGElement {
  const spot = document.createElementNS("http://www.w3.org/2000/svg", "circle");
  setAttributes(spot, { cx: x, cy: y, r: 5, fill: color, stroke: readTokens().paper, "stroke-width": 2 });
  return spot;
}
