/** A tree of topics: what each holds, with types and units; its numbers to draw, and its message as it is. */

import { el } from "../ui/dom";
import { newestWins } from "../ui/signal";
import { draw, html, nothing, repeat, type View } from "../ui/view";
import { word } from "../words/words";
import { type Field, titleOf } from "./layouts";
import { cellsOf, unitOf } from "./message";
import type { Message, Topic } from "./plotter";

/** Of so many numbers the topics that have them are opened. */
const FEW = 60;

export class TopicTree {
  readonly element = el("div", { class: "plotter-found", "aria-label": word("charts.topics"), role: "group" });
  private readonly branches = new Map<string, Branch>();

  constructor(
    private readonly ask: (topic: string) => Promise<Message | null>,
    private readonly pick: (field: Field) => void,
  ) {}

  /** Show fields of topics, opened where they were looked for. */
  show(fields: Field[], topics: Record<string, Topic>, isSearched: boolean): void {
    const byTopic = new Map<string, Field[]>(isSearched ? [] : Object.keys(topics).map((topic) => [topic, []]));
    for (const field of fields) byTopic.set(field[0], [...(byTopic.get(field[0]) ?? []), field]);
    const isOpen = isSearched && fields.length <= FEW;
    const branch = ([topic, some]: [string, Field[]]): View => this.branch(topic).show(some, topics[topic], isOpen);
    const rows = repeat([...byTopic].sort(), ([topic]) => topic, branch);
    draw(this.element, rows);
  }

  /** Ask for the messages that are open again: time has gone on. */
  refresh(): void {
    for (const branch of this.branches.values()) void branch.refresh();
  }

  /** There is another source. */
  clear(): void {
    this.branches.clear();
    draw(this.element, nothing);
  }

  private branch(topic: string): Branch {
    const found = this.branches.get(topic) ?? new Branch(topic, this.ask, this.pick);
    this.branches.set(topic, found);
    return found;
  }
}

/** One topic. */
class Branch {
  private readonly element = el("details", { class: "topic", ontoggle: () => this.turned() });
  private fields: Field[] = [];
  private topic: Topic | undefined;
  /** Whether its message is shown, and that, once it has come. */
  private isRaw = false;
  private message: Message | null | undefined;
  private readonly asked = newestWins(async () => {
    this.message = await this.ask(this.name);
    this.draw();
  });

  constructor(
    private readonly name: string,
    private readonly ask: (topic: string) => Promise<Message | null>,
    private readonly pick: (field: Field) => void,
  ) {}

  show(fields: Field[], topic: Topic | undefined, isOpen: boolean): HTMLElement {
    Object.assign(this, { fields, topic });
    if (isOpen) this.element.open = true;
    this.draw();
    return this.element;
  }

  async refresh(): Promise<void> {
    if (this.isRaw && this.element.open) await this.asked(undefined);
  }

  private turned(): void {
    this.draw();
    void this.refresh();
  }

  /** List the numbers, once somebody looks. */
  private draw(): void {
    const { topic, fields, isRaw } = this;
    const press = (): void => {
      [this.isRaw, this.message] = [!isRaw, undefined];
      this.turned();
    };
    const items = this.element.open ? repeat(fields, titleOf, (field) => this.item(field)) : nothing;
    const view = html`<summary>${this.name} <span class="topic-type">${topic?.type}</span></summary><p class="hint">${topic?.about}</p>
        <button type="button" class="quiet run-small" aria-pressed=${isRaw} @click=${press}>${word("charts.message")}</button>
        <div class="topic-message">${isRaw ? this.told() : nothing}</div><ul>${items}</ul>`;
    draw(this.element, view);
  }

  private item(field: Field): View {
    const title = titleOf(field);
    return html`<li><button type="button" class="quiet" aria-label=${title} title=${word("charts.draw", { title })}
      @click=${() => this.pick(field)}><span>${field[1]}</span><span class="run-unit">${this.unit(field[1])}</span></button></li>`;
  }

  private told(): View {
    const { message } = this;
    if (!message) return message === null ? html`<p class="hint">${word("charts.noMessageYet")}</p>` : nothing;
    const rows = [...cellsOf(message.content)].map(
      ([name, value]) => html`<tr><th scope="row">${name}</th><td>${value}</td><td>${this.unit(name)}</td></tr>`,
    );
    const binary = (): View => html`<p class="hint">${word("charts.binary", { bytes: message.bytes ?? 0 })}</p>`;
    return html`<table><caption>${word("charts.messageAt", { time: message.time.toFixed(3) })}</caption>${rows}</table>${
      message.content === null ? binary() : nothing
    }`;
  }

  private unit(name: string): string {
    return unitOf(name, this.topic?.units ?? {});
  }
}
