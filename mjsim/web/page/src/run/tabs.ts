/** Panels of which one is seen, as tabs that the arrow keys go through. */

import { el } from "../dom";
import { remembered } from "./controls";

export class Tabs {
  readonly element = el("div", { class: "run-tabbed" });
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
    this.panels.forEach(([each, , panel], k) => {
      panel.hidden = each !== key;
      this.heads[k]?.setAttribute("aria-selected", String(each === key));
      this.heads[k]?.setAttribute("tabindex", each === key ? "0" : "-1");
    });
  }

  private key(event: KeyboardEvent): void {
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!way) return;
    const now = this.panels.findIndex(([, , panel]) => !panel.hidden);
    const next = (now + way + this.panels.length) % this.panels.length;
    this.show(this.panels[next]?.[0] ?? "");
    this.heads[next]?.focus();
    event.preventDefault();
    event.stopPropagation();
  }
}
