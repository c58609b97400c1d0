/** Panels of which one is seen, as tabs that the arrow keys go through. */

import { remembered } from "./controls";
import { el } from "./dom";
import { Signal } from "./signal";

export class Tabs {
  readonly element = el("div", { class: "run-tabbed" });
  /** Told with the key of the panel that is seen now. */
  readonly shown = new Signal<string>();
  now = "";
  private readonly heads: HTMLButtonElement[];

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
    remembered(this.name, key);
    this.now = key;
    this.panels.forEach(([each, , panel], k) => {
      panel.hidden = each !== key;
      this.heads[k]?.setAttribute("aria-selected", String(each === key));
      this.heads[k]?.setAttribute("tabindex", each === key ? "0" : "-1");
    });
    this.shown.emit(key);
  }

  /** Whether there is anything in a panel; if not, its tab goes, and the first panel is shown in its place. */
  offer(key: string, there: boolean): void {
    const k = this.panels.findIndex(([each]) => each === key);
    const head = this.heads[k];
    if (!head) return;
    head.hidden = !there;
    if (!there && !this.panels[k]?.[2].hidden) this.show(this.panels[0]?.[0] ?? "");
  }

  private key(event: KeyboardEvent): void {
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!way) return;
    const there = this.panels.filter((_, k) => !this.heads[k]?.hidden);
    const now = there.findIndex(([, , panel]) => !panel.hidden);
    const next = there[(now + way + there.length) % there.length];
    if (!next) return;
    this.show(next[0]);
    this.heads[this.panels.indexOf(next)]?.focus();
    event.preventDefault();
    event.stopPropagation();
  }
}
