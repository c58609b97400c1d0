/** Any numbers of a recording in one chart over time: chosen from a list that is searched, kept, and given away. */

import uPlot from "uplot";

import { el, fill } from "../dom";
import { button, remembered } from "../run/controls";
import { rowColor } from "../run/ink";
import { csvOf, save } from "./save";
import { Chart, NO_MARKS, type Handlers, type Marks } from "./chart";

/** Topic and the number's place in its messages. */
export type Field = [topic: string, name: string];
export interface Column {
  time: number[];
  values: (number | null)[];
}

/** So many are drawn in one chart. */
const MOST = 6;
/** So many are offered for what was typed. */
const OFFERED = 60;
const KEPT = "review.plot";

export class Plotter {
  /** The list of what is drawn, and the search. */
  readonly element = el("div", { class: "plotter" });
  private readonly chart = el("div", { class: "plotter-chart" });
  private readonly search = el("input", {
    type: "search",
    placeholder: "Search topics and fields",
    "aria-label": "Search topics and fields",
    oninput: () => this.offer(),
  });
  private readonly found = el("ul", { class: "plotter-found", "aria-label": "Fields" });
  private readonly list = el("ul", { class: "plotter-list", "aria-label": "Drawn" });
  private readonly note = el("p", { class: "hint", role: "status" });
  private readonly files: HTMLElement;
  private chosen: Field[] = kept();
  private all: Field[] = [];
  private readonly columns = new Map<string, Column>();
  private drawn: Chart | null = null;
  private joined: uPlot.AlignedData | null = null;
  private marks = NO_MARKS;
  /** Counts recordings: an answer for another one is dropped. */
  private turn = 0;

  constructor(
    /** Among whose children the chart stands first, when there is one. */
    private readonly host: HTMLElement,
    private readonly fields: () => Promise<Field[]>,
    private readonly column: (field: Field) => Promise<Column>,
    private readonly handlers: Handlers,
    private readonly fail: (error: unknown) => void,
  ) {
    this.files = el(
      "div",
      { class: "plotter-files", hidden: true },
      button({ class: "run-small" }, () => this.saveCsv(), "Save CSV"),
      button({ class: "run-small" }, () => this.savePng(), "Save PNG"),
    );
    this.element.append(this.list, this.files, this.search, this.note, this.found);
  }

  /** Another recording is open. */
  async load(): Promise<void> {
    const turn = ++this.turn;
    this.columns.clear();
    this.note.textContent = "Reading the list of fields …";
    try {
      const all = await this.fields();
      if (turn !== this.turn) return;
      this.all = all;
      this.offer();
      await this.draw();
    } catch (error) {
      this.fail(error);
    }
  }

  mark(marks: Marks): void {
    this.marks = marks;
    this.drawn?.mark(marks);
  }

  private offer(): void {
    const words = this.search.value.toLowerCase().split(/\s+/);
    const fit = this.all.filter((field) => words.every((word) => title(field).toLowerCase().includes(word)));
    this.note.textContent =
      fit.length > OFFERED ? `${fit.length} numbers; the first ${OFFERED} are listed` : `${fit.length} ${fit.length === 1 ? "number" : "numbers"}`;
    fill(
      this.found,
      ...fit.slice(0, OFFERED).map((field) => {
        const add = button({ class: "quiet", title: `Draw ${title(field)}` }, () => void this.add(field), title(field));
        return el("li", {}, add);
      }),
    );
  }

  private async add(field: Field): Promise<void> {
    const there = this.chosen.some((each) => title(each) === title(field));
    if (there || this.chosen.length >= MOST) {
      this.note.textContent = there ? `${title(field)} is drawn already` : `A chart holds ${MOST}; remove one first`;
      return;
    }
    await this.choose([...this.chosen, field]);
  }

  private async choose(fields: Field[]): Promise<void> {
    this.chosen = fields;
    remembered(KEPT, JSON.stringify(fields));
    await this.draw();
  }

  private async draw(): Promise<void> {
    const turn = this.turn;
    const there = this.chosen.filter((field) => this.all.some((each) => title(each) === title(field)));
    try {
      for (const field of there)
        if (!this.columns.has(title(field))) this.columns.set(title(field), await this.column(field));
    } catch (error) {
      return this.fail(error);
    }
    if (turn !== this.turn) return;
    this.show(there);
  }

  private show(there: Field[]): void {
    fill(
      this.list,
      ...this.chosen.map((field, k) => {
        const gone = there.includes(field) ? "" : " (not in this recording)";
        const swatch = el("i", { style: `background: ${rowColor(there.indexOf(field))}` });
        const remove = (): void => void this.choose(this.chosen.filter((_, other) => other !== k));
        const drop = button({ class: "quiet square", "aria-label": `Remove ${title(field)}` }, remove, "×");
        return el("li", {}, gone ? null : swatch, el("span", {}, title(field) + gone), drop);
      }),
    );
    this.drawn?.close();
    this.drawn = this.joined = null;
    this.chart.remove();
    this.files.hidden = there.length === 0;
    if (!there.length) return;
    this.host.prepend(this.chart);
    const tables = there.map((field) => this.columns.get(title(field)) ?? { time: [], values: [] });
    this.joined = uPlot.join(tables.map(({ time, values }) => [time, values] as uPlot.AlignedData));
    const lines = there.map(([topic, name], k) => ({
      label: there.length > 1 ? `${topic.split("/").pop() ?? ""} ${name}` : "",
      color: () => rowColor(k),
    }));
    const [only] = there;
    const heading = there.length === 1 && only ? title(only) : "Chosen numbers";
    this.drawn = new Chart({ title: heading, unit: "", lines, digits: 4 }, this.handlers, "review");
    this.chart.append(this.drawn.element);
    this.drawn.show(this.joined as unknown as Parameters<Chart["show"]>[0]);
    this.drawn.mark(this.marks);
  }

  private saveCsv(): void {
    if (!this.joined) return;
    const there = this.chosen.filter((field) => this.columns.has(title(field)));
    const [times, ...columns] = this.joined;
    const rows = Array.from(times, (time, row) => [time, ...columns.map((each) => each[row])]);
    const text = csvOf([["time", ...there.map(title)], ...rows]);
    save(new Blob([text], { type: "text/csv" }), "plot.csv");
  }

  private savePng(): void {
    const canvas = this.chart.querySelector("canvas");
    canvas?.toBlob((blob) => blob && save(blob, "plot.png"));
  }
}

function title([topic, name]: Field): string {
  return `${topic}.${name}`;
}

function kept(): Field[] {
  const found = JSON.parse(remembered(KEPT) ?? "[]") as Field[];
  return found.slice(0, MOST);
}
