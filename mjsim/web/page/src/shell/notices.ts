/** Notices above the view: what the person should know or decide, without taking the keyboard from them. */

import { el } from "../ui/dom";
import { word } from "../words/words";

export interface Action {
  text: string;
  /** What it does, in more words. */
  title?: string;
  kind?: "primary" | "danger";
  act: () => void;
}

export class Notices {
  readonly element = el("div", { class: "notices", role: "status", "aria-live": "polite" });
  private readonly shown = new Map<string, { element: HTMLElement; text: string }>();

  /** Show a notice in place of the one with this key; `close` is called when it is clicked away. */
  set(key: string, text: string, actions: Action[], close: () => void = () => undefined): void {
    const old = this.shown.get(key);
    if (old?.text === text) return;
    const away = (): void => {
      this.clear(key);
      close();
    };
    const buttons = actions.map(({ text, title, kind, act }) =>
      el("button", { class: kind ?? "", title, onclick: act }, text),
    );
    const element = el(
      "div",
      { class: "notice", "data-notice": key },
      el("div", {}, el("span", {}, text), ...buttons),
      el("button", { class: "quiet square", "aria-label": word("shell.close"), onclick: away }, "✕"),
    );
    this.shown.set(key, { element, text });
    if (old) old.element.replaceWith(element);
    else this.element.append(element);
  }

  clear(key: string): void {
    this.shown.get(key)?.element.remove();
    this.shown.delete(key);
  }
}
