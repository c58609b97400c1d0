/** Panels of which one is seen, as tabs that the arrow keys go through. */

import { remembered } from "./controls";
import { el } from "./dom";
import { Signal } from "./signal";
import type { Lodger } from "./tile";

export class Tabs {
  readonly element = el("div", { class: "run-tabbed" });
  /** Told with the key of the panel that is seen now. */
  readonly shown = new Signal<string>();
  now = "";
  /** Told when there are other panels than before. */
  readonly offered = new Signal<void>();
  private readonly heads: HTMLButtonElement[];
  /** Panels in which there is nothing, and those that stand elsewhere. */
  private readonly empty = new Set<string>();
  private readonly away = new Set<string>();

  constructor(
    private readonly name: string,
    private readonly panels: [key: string, label: string, panel: HTMLElement][],
  ) {
    this.heads = panels.map(([key, label]) =>
      el("button", { type: "button", role: "tab", id: `${name}-${key}`, onclick: () => this.show(key) }, label),
    );
    for (const [key, , panel] of panels) {
      panel.setAttribute("role", "tabpanel");
      panel.setAttribute("aria-labelledby", `${name}-${key}`);
    }
    const list = el(
      "div",
      { class: "tabs", role: "tablist", onkeydown: (event: KeyboardEvent) => this.key(event) },
      ...this.heads,
    );
    this.element.append(list, ...panels.map(([, , panel]) => panel));
    const kept = remembered(name);
    this.show(panels.some(([key]) => key === kept) ? (kept ?? "") : (panels[0]?.[0] ?? ""));
  }

  show(key: string): void {
    if (this.away.has(key)) return void this.shown.emit(key);
    remembered(this.name, key);
    this.now = key;
    this.drawHeads();
    this.shown.emit(key);
  }

  /** Whether a panel is seen, here or elsewhere. */
  isShown(key: string): boolean {
    return this.now === key || this.away.has(key);
  }

  /** Whether there is anything in a panel; if not, its tab goes, and the first panel is shown in its place. */
  offer(key: string, there: boolean): void {
    if (there !== this.empty.has(key)) return;
    if (there) this.empty.delete(key);
    else this.empty.add(key);
    this.choose();
    this.offered.emit();
  }

  /** The panels as such that may stand among large views. */
  lodgers(): Lodger[] {
    return this.panels.map(([key, title, body], k) => ({
      key: `panel:${key}`,
      title,
      body,
      handle: this.heads[k] as HTMLElement,
      isThere: () => !this.empty.has(key),
      lodge: (isAway) => this.lend(key, body, isAway),
    }));
  }

  /** A button beside the tabs. */
  addAction(action: HTMLElement): void {
    this.element.querySelector("[role='tablist']")?.after(action);
  }

  private lend(key: string, body: HTMLElement, isAway: boolean): void {
    if (isAway) {
      this.away.add(key);
      body.hidden = false;
      body.setAttribute("role", "group");
    } else {
      this.away.delete(key);
      body.setAttribute("role", "tabpanel");
      this.element.append(body);
      this.now = key;
    }
    this.choose();
  }

  private there(): string[] {
    return this.panels.map(([key]) => key).filter((key) => !this.empty.has(key) && !this.away.has(key));
  }

  /** Show the one that was, or the first that is there. */
  private choose(): void {
    const there = this.there();
    this.element.toggleAttribute("data-empty", there.length === 0);
    if (there.includes(this.now)) this.drawHeads();
    else {
      this.now = there[0] ?? "";
      this.drawHeads();
      this.shown.emit(this.now);
    }
  }

  private drawHeads(): void {
    const there = this.there();
    this.panels.forEach(([key, , panel], k) => {
      if (!this.away.has(key)) panel.hidden = key !== this.now;
      const head = this.heads[k];
      if (head) head.hidden = !there.includes(key);
      head?.setAttribute("aria-selected", String(key === this.now));
      head?.setAttribute("tabindex", key === this.now ? "0" : "-1");
    });
  }

  private key(event: KeyboardEvent): void {
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!way) return;
    const there = this.there();
    const next = there[(there.indexOf(this.now) + way + there.length) % there.length];
    if (!next) return;
    this.show(next);
    this.heads[this.panels.findIndex(([key]) => key === next)]?.focus();
    event.preventDefault();
    event.stopPropagation();
  }
}
