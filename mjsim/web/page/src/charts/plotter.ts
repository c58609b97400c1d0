/** Any numbers in charts of one's own: found by words, over time or against each other, in layouts that are kept. */

import { ask } from "../ui/dialog";
import { el, put } from "../ui/dom";
import { sign } from "../ui/icons";
import { newestWins } from "../ui/signal";
import { themeChanged } from "../ui/theme";
import { choice, draw, html, nothing, repeat, tickBox, type View } from "../ui/view";
import { word } from "../words/words";
import { type Handlers, type Marks, NO_MARKS } from "./chart";
import { colorsOf } from "./colors";
import { empty, type Field, Layouts, MOST, type PlotChart, type PlotKind, titleOf } from "./layouts";
import { type Column, makePlot, type Plot } from "./plots";
import { suggested } from "./suggested";
import { TopicTree } from "./topics";

export type { Column, Field };

/** What a topic holds. */
export interface Topic {
  /** Of its messages, as "mjsim.Command". */
  type: string;
  about: string;
  /** Of its numbers, by their names without indices. */
  units: Record<string, string>;
}

export interface Message {
  time: number;
  /** null where it is no JSON, but so many bytes. */
  content: unknown;
  bytes?: number;
}

/** Where numbers come from. */
export interface Source {
  fields(): Promise<{ fields: Field[]; topics: Record<string, Topic> }>;
  column(field: Field): Promise<Column>;
  /** The last message of a topic until a time; live, the newest one. */
  message(topic: string, time: number | null): Promise<Message | null>;
}

const KINDS: [PlotKind, string][] = [
  ["time", word("charts.overTime")],
  ["xy", word("charts.xAndY")],
];

export class Plotter {
  /** The layouts, the list of what is drawn, and the search. */
  readonly element = el("div", { class: "plotter" });
  private readonly charts = el("div", { class: "plotter-chart" });
  private readonly search = el("input", {
    type: "search",
    placeholder: word("charts.searchTopicsAndFields"),
    "aria-label": word("charts.searchTopicsAndFields"),
    oninput: () => this.offer(),
  });
  private readonly tree = new TopicTree(
    (topic) => this.source.message(topic, this.marks.now),
    (field) => this.add(field),
  );
  private readonly head = el("div", { class: "plotter-layouts" });
  private readonly cards = el("div", { class: "plotter-cards" });
  private readonly note = el("p", { class: "hint", role: "status" });
  private readonly layouts: Layouts;
  /** The chart that takes the next number. */
  private current = 0;
  private all: Field[] = [];
  private topics: Record<string, Topic> = {};
  private known = new Set<string>();
  private drawn: { plot: Plot; fields: Field[] }[] = [];
  private marks = NO_MARKS;
  private suggests = false;
  /** Counts sources: an answer for another one is dropped. */
  private turn = 0;
  /** Draw anew, with the charts as they are now. */
  private readonly draw = newestWins(async (turn: number) => {
    try {
      await this.drawAll(turn);
    } catch (error) {
      this.fail(error);
    }
  });

  constructor(
    /** Among whose children the charts stand first. */
    private readonly host: HTMLElement,
    /** Of what the layouts are: 'review' or 'run'; also the key by which the cursors of charts are tied. */
    private readonly key: string,
    private readonly source: Source,
    private readonly handlers: Handlers,
    private readonly fail: (error: unknown) => void,
  ) {
    this.layouts = new Layouts(`${key}.layouts`);
    this.element.append(this.head, this.cards, this.search, this.note, this.tree.element);
    themeChanged.on(() => this.list());
    this.list();
  }

  /** There is another source. */
  async load(): Promise<void> {
    const turn = ++this.turn;
    this.note.textContent = word("charts.readingTheListOf");
    try {
      const { fields, topics } = await this.source.fields();
      if (turn !== this.turn) return;
      this.tree.clear();
      this.take(fields, topics);
      this.list();
      await this.draw(turn);
    } catch (error) {
      if (turn !== this.turn) return;
      // What was drawn is of another source.
      this.take([], {});
      this.list();
      void this.draw(turn);
      this.note.textContent = "";
      this.fail(error);
    }
  }

  /** The source goes on: show what it has now. */
  async refresh(): Promise<void> {
    const { fields: all, topics } = await this.source.fields();
    this.tree.refresh();
    if (all.length !== this.all.length) {
      const before = this.there().map((fields) => fields.length);
      this.take(all, topics);
      const now = this.there();
      if (now.length !== before.length || now.some((fields, k) => fields.length !== before[k])) {
        this.list();
        return this.draw(this.turn);
      }
    }
    for (const each of [...this.drawn]) {
      const columns = await this.columns(each.fields);
      // It may have been closed meanwhile.
      if (this.drawn.includes(each)) each.plot.show(columns);
    }
  }

  mark(marks: Marks): void {
    this.marks = marks;
    for (const { plot } of this.drawn) plot.mark(marks);
    this.tree.refresh();
  }

  private take(all: Field[], topics: Record<string, Topic>): void {
    Object.assign(this, { all, topics });
    this.known = new Set(all.map(titleOf));
    this.offer();
  }

  /** Whether charts are suggested as long as none are chosen. */
  suggest(on: boolean): void {
    if (on === this.suggests) return;
    this.suggests = on;
    void this.draw(this.turn);
  }

  /** The charts that were chosen, or those that are suggested in their place. */
  private get shown(): PlotChart[] {
    const { charts } = this.layouts.now;
    return this.suggests && charts.every(({ fields }) => fields.length === 0) ? suggested(this.all, MOST) : charts;
  }

  /** Of each chart the fields that the source has. */
  private there(): Field[][] {
    return this.shown.map(({ kind, fields }) => {
      const found = fields.filter((field) => this.known.has(titleOf(field)));
      // Without its x nothing can be drawn against it.
      return kind === "xy" && found[0] !== fields[0] ? [] : found;
    });
  }

  private columns(fields: Field[]): Promise<Column[]> {
    return Promise.all(fields.map((field) => this.source.column(field)));
  }

  private async drawAll(turn: number): Promise<void> {
    const charts = this.shown.map((chart, k) => ({ chart, fields: this.there()[k] ?? [] }));
    const full = charts.filter(({ fields }) => fields.length > 0);
    const columns = await Promise.all(full.map(({ fields }) => this.columns(fields)));
    if (turn !== this.turn) return;
    for (const { plot } of this.drawn) plot.close();
    this.drawn = full.map(({ chart, fields }) => ({ plot: makePlot(chart, fields, this.handlers, this.key), fields }));
    put(
      this.charts,
      this.drawn.map(({ plot }) => plot.element),
    );
    if (full.length) this.host.prepend(this.charts);
    else this.charts.remove();
    this.drawn.forEach(({ plot }, k) => {
      plot.show(columns[k] ?? []);
      plot.mark(this.marks);
    });
  }

  private offer(): void {
    const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const fit = this.all.filter((field) => words.every((part) => titleOf(field).toLowerCase().includes(part)));
    this.note.textContent = fit.length === 1 ? word("charts.oneNumber") : word("charts.numbers", { count: fit.length });
    this.tree.show(fit, this.topics, words.length > 0);
  }

  private add(field: Field): void {
    const chart = this.layouts.now.charts[this.current];
    if (!chart) return;
    const there = chart.fields.some((each) => titleOf(each) === titleOf(field));
    if (there || chart.fields.length >= MOST.fields) {
      this.note.textContent = there
        ? word("charts.isDrawnAlready", { field: titleOf(field) })
        : word("charts.aChartHoldsRemove", { fields: MOST.fields });
      return;
    }
    chart.fields.push(field);
    this.changed();
  }

  /** Keep and show the layout as it is now. */
  private changed(): void {
    this.layouts.keep();
    this.list();
    void this.draw(this.turn);
  }

  private list(): void {
    const { charts } = this.layouts.now;
    this.current = Math.min(this.current, charts.length - 1);
    const add = (): void => {
      this.current = charts.push(empty()) - 1;
      this.changed();
    };
    const keyOf = (chart: PlotChart): PlotChart => chart;
    draw(this.head, this.layoutControls());
    const more = small(word("charts.addChart"), add, charts.length >= MOST.charts);
    draw(this.cards, [repeat(charts, keyOf, (chart, k) => this.card(chart, k)), more]);
  }

  private layoutControls(): View {
    const { layouts } = this;
    const choose = (name: string): void => {
      layouts.choose(name);
      this.changed();
    };
    const remove = (): void => {
      layouts.remove();
      this.changed();
    };
    const begin = (): void => void this.name(word("charts.newLayout"), "", (name) => layouts.add(name));
    const rename = (): void =>
      void this.name(word("charts.renameLayout"), layouts.now.name, (name) => layouts.rename(name));
    const names = layouts.all.map(({ name }) => [name, name] as const);
    return html`${choice(word("charts.layout"), names, layouts.now.name, choose)}
      ${small(word("charts.new"), begin)}${small(word("charts.rename"), rename)}${small(word("charts.removeLayout"), remove)}`;
  }

  private async name(title: string, value: string, use: (name: string) => string | null): Promise<void> {
    const input = el("input", { type: "text", value, maxlength: 60, "aria-label": word("charts.nameOfTheLayout") });
    const choices = [
      { text: word("charts.cancel"), value: false },
      { text: word("charts.keep"), value: true, kind: "primary" as const },
    ];
    if (!(await ask(title, [input], choices))) return;
    const wrong = use(input.value.trim());
    this.changed();
    this.note.textContent = wrong ?? this.note.textContent;
  }

  private card(chart: PlotChart, k: number): View {
    const number = k + 1;
    const choose = (kind: PlotKind): void => {
      chart.kind = kind;
      this.changed();
    };
    const select = (): void => {
      this.current = k;
      this.list();
    };
    const remove = (): void => {
      this.layouts.now.charts.splice(k, 1);
      if (!this.layouts.now.charts.length) this.layouts.now.charts.push(empty());
      this.changed();
    };
    const isXy = chart.kind === "xy";
    const hint = word(isXy ? "charts.chooseXFirstThen" : "charts.chooseNumbersBelow");
    const isNow = k === this.current;
    return html`<section class="plotter-card" aria-label=${word("charts.chart", { number })} ?data-current=${isNow}>
      <header><button type="button" class="quiet run-small plotter-pick" aria-pressed=${isNow} @click=${select}
          title=${word("charts.numbersGoIntoThis")}>${word("charts.chart", { number })}</button>
        ${choice(word("charts.kindOfChart", { number }), KINDS, chart.kind, choose)}
        ${dropper(word("charts.removeChart", { number }), remove)}</header>
      <ul class="plotter-list" aria-label=${word("charts.drawn")}>${this.rows(chart)}</ul>
      ${chart.fields.length < (isXy ? 2 : 1) ? html`<p class="hint">${hint}</p>` : nothing}
      ${isXy ? this.scaleBox(chart) : nothing}</section>`;
  }

  private scaleBox(chart: PlotChart): View {
    const set = (on: boolean): void => {
      chart.equal = on;
      this.changed();
    };
    return tickBox("run-check", word("charts.oneScaleForBoth"), chart.equal ?? false, set);
  }

  private rows(chart: PlotChart): View {
    const there = chart.fields.filter((field) => this.known.has(titleOf(field)));
    const first = chart.kind === "xy" ? 1 : 0;
    const colorOf = colorsOf(there.slice(first));
    return repeat(chart.fields, titleOf, (field) => {
      const gone = there.includes(field) ? "" : word("charts.notThere");
      const place = there.indexOf(field) - first;
      const mark = place < 0 ? html`<b>${gone ? "–" : "x"}</b>` : html`<i style="background: ${colorOf(place)}"></i>`;
      const remove = (): void => {
        chart.fields.splice(chart.fields.indexOf(field), 1);
        this.changed();
      };
      const title = titleOf(field);
      return html`<li>${mark}<span>${title + gone}</span>${dropper(word("charts.removeField", { field: title }), remove)}</li>`;
    });
  }
}

function small(text: string, press: () => void, disabled = false): View {
  return html`<button type="button" class="quiet run-small" ?disabled=${disabled} @click=${press}>${text}</button>`;
}

function dropper(label: string, press: () => void): View {
  return html`<button type="button" class="quiet square" aria-label=${label} @click=${press}>${sign("close")}</button>`;
}
