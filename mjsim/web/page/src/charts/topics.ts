/** A tree of topics: what each holds, with types and units; its numbers to draw, and its message as it is. */

import { button, isPressed, toggle } from "../ui/controls";
import { el, fill, put } from "../ui/dom";
import { newestWins } from "../ui/signal";
import { word } from "../words/words";
import { type Field, titleOf } from "./layouts";
import { cellsOf, unitOf } from "./message";
import type { Message, Topic } from "./plotter";

/** Of so many numbers the topics that have them are opened. */
const FEW = 60;

export class TopicTree {
  readonly element = el("div", { class: "plotter-found", "aria-label": word("charts.topics"), role: "group" });
  private readonly branches = new Map<string, Branch>();
  private topics: Record<string, Topic> = {};

  constructor(
    private readonly ask: (topic: string) => Promise<Message | null>,
    private readonly pick: (field: Field) => void,
  ) {}

  /** Show fields of topics, opened where they were looked for. */
  show(fields: Field[], topics: Record<string, Topic>, isSearched: boolean): void {
    this.topics = topics;
    const byTopic = new Map<string, Field[]>(isSearched ? [] : Object.keys(topics).map((topic) => [topic, []]));
    for (const field of fields) byTopic.set(field[0], [...(byTopic.get(field[0]) ?? []), field]);
    const isOpen = isSearched && fields.length <= FEW;
    put(
      this.element,
      [...byTopic].sort().map(([topic, some]) => this.branch(topic).show(some, this.topics[topic], isOpen)),
    );
  }

  /** Ask for the messages that are open again: time has gone on. */
  refresh(): void {
    for (const branch of this.branches.values()) void branch.refresh();
  }

  /** There is another source. */
  clear(): void {
    this.branches.clear();
    fill(this.element);
  }

  private branch(topic: string): Branch {
    const found = this.branches.get(topic) ?? new Branch(topic, this.ask, this.pick);
    this.branches.set(topic, found);
    return found;
  }
}

/** One topic. */
class Branch {
  private readonly element = el("details", { class: "topic", ontoggle: () => this.draw() });
  private readonly about = el("p", { class: "hint" });
  private readonly list = el("ul", {});
  private readonly table = el("div", { class: "topic-message" });
  private readonly type = el("span", { class: "topic-type" });
  private readonly raw: HTMLButtonElement;
  private fields: Field[] = [];
  private topic: Topic | undefined;
  private readonly asked = newestWins(async () => this.tell(await this.ask(this.name)));

  constructor(
    private readonly name: string,
    private readonly ask: (topic: string) => Promise<Message | null>,
    private readonly pick: (field: Field) => void,
  ) {
    const press = (): void => void this.refresh();
    this.raw = toggle({ class: "quiet run-small" }, false, press, word("charts.message"));
    this.element.append(el("summary", {}, name, this.type), this.about, this.raw, this.table, this.list);
  }

  show(fields: Field[], topic: Topic | undefined, isOpen: boolean): HTMLElement {
    const same =
      this.topic && fields.length === this.fields.length && fields.every((each, k) => each === this.fields[k]);
    Object.assign(this, { fields, topic });
    this.type.textContent = topic?.type ?? "";
    this.about.textContent = topic?.about ?? "";
    if (isOpen) this.element.open = true;
    if (!same) this.draw();
    return this.element;
  }

  async refresh(): Promise<void> {
    if (!isPressed(this.raw)) fill(this.table);
    else if (this.element.open) await this.asked(undefined);
  }

  /** List the numbers, once somebody looks; those that stay are not touched: one may be pressed as another comes. */
  private draw(): void {
    if (!this.element.open) return;
    const before = new Map([...this.list.children].map((item) => [item.textContent, item as HTMLElement]));
    const unit = (field: Field): string => unitOf(field[1], this.topic?.units ?? {});
    put(
      this.list,
      this.fields.map((field) => before.get(field[1] + unit(field)) ?? this.item(field, unit(field))),
    );
    void this.refresh();
  }

  private item(field: Field, unit: string): HTMLElement {
    const title = titleOf(field);
    const attributes = { class: "quiet", "aria-label": title, title: word("charts.draw", { title }) };
    const parts = [el("span", {}, field[1]), el("span", { class: "run-unit" }, unit)];
    return el(
      "li",
      {},
      button(attributes, () => this.pick(field), ...parts),
    );
  }

  private tell(message: Message | null): void {
    if (!isPressed(this.raw)) return;
    if (!message) return fill(this.table, el("p", { class: "hint" }, word("charts.noMessageYet")));
    const units = this.topic?.units ?? {};
    const head = el("caption", {}, word("charts.messageAt", { time: message.time.toFixed(3) }));
    const rows = [...cellsOf(message.content)].map(([name, value]) =>
      el("tr", {}, el("th", { scope: "row" }, name), el("td", {}, value), el("td", {}, unitOf(name, units))),
    );
    const binary = message.content === null && word("charts.binary", { bytes: message.bytes ?? 0 });
    fill(this.table, el("table", {}, head, ...rows), binary && el("p", { class: "hint" }, binary));
  }
}
