/** Short messages at the foot of the page: what went wrong and what to do, or that something was done. */

import { ApiError } from "../api";
import { el } from "../ui/dom";
import { word } from "../words/words";

const STAYS = { error: 9000, done: 3000 };

export class Toasts {
  readonly element = el("div", { class: "toasts", role: "status", "aria-live": "polite" });

  /** What was wrong is so no longer, for the next thing worked. */
  worked(): void {
    for (const old of this.element.querySelectorAll(".toast.error")) old.remove();
  }

  /** Say that something was done. */
  done(text: string): void {
    this.worked();
    this.say(text, "done");
  }

  /** Say what is wrong; it stays until it was read, or clicked away. */
  error(problem: unknown): void {
    if (!(problem instanceof Error) && typeof problem !== "string") throw problem;
    if (problem instanceof Error && !(problem instanceof ApiError)) console.error(problem);
    this.say(sentence(problem instanceof Error ? problem.message : problem), "error");
  }

  private say(text: string, kind: "error" | "done"): void {
    for (const old of [...this.element.children]) if (old.firstChild?.textContent === text) old.remove();
    const close = el(
      "button",
      { class: "quiet", "aria-label": word("shell.close"), onclick: () => toast.remove() },
      "✕",
    );
    const toast = el("div", { class: `toast ${kind}` }, el("span", {}, text), close);
    this.element.append(toast);
    while (this.element.children.length > 4) this.element.firstElementChild?.remove();
    window.setTimeout(() => toast.remove(), STAYS[kind] + text.length * 40);
  }
}

/** Begin with a capital, so that a line of an error reads as a sentence; names of files stay as they are. */
function sentence(text: string): string {
  return /^[a-z][a-z]* /.test(text) ? text.charAt(0).toUpperCase() + text.slice(1) : text;
}
