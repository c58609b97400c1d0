/** Questions: a dialog over the page that keeps the keyboard until it is answered. */

import { word } from "../words/words";
import { el } from "./dom";
import { draw, html, type View } from "./view";

export interface Choice<T> {
  text: string;
  value: T;
  kind?: "primary" | "danger";
}

/** Ask with a title, something to read or fill in, and buttons. Escape gives null. */
export function ask<T>(title: string, body: View, choices: Choice<T>[]): Promise<T | null> {
  return new Promise((resolve) => {
    let given: T | null = null;
    // Enter in a field presses the first button that submits: that is the main answer.
    const button = ({ text, value, kind }: Choice<T>): View => {
      const give = (): void => {
        given = value;
        dialog.close();
      };
      return html`<button type=${kind === "primary" ? "submit" : "button"} class=${kind ?? ""} @click=${give}>${text}</button>`;
    };
    const dialog = el("dialog", { "aria-labelledby": "dialog-title" });
    const view = html`<form method="dialog"><h2 id="dialog-title">${title}</h2>${body}<div class="choices">${choices.map(button)}</div></form>`;
    draw(dialog, view);
    dialog.addEventListener("close", () => {
      dialog.remove();
      resolve(given);
    });
    document.body.append(dialog);
    dialog.showModal();
    const first = dialog.querySelector<HTMLElement>("[autofocus], input, [role=option]");
    (first ?? dialog.querySelector<HTMLElement>(".choices .primary"))?.focus();
  });
}

/** Whether a pointer is over the box of an element. */
function isOver(element: HTMLElement, { clientX, clientY }: MouseEvent): boolean {
  const { left, right, top, bottom } = element.getBoundingClientRect();
  return left <= clientX && clientX <= right && top <= clientY && clientY <= bottom;
}

/** Ask with a dialog that closes itself: `make` gets how to give the answer. */
export function askWith<T>(title: string, make: (answer: (value: T | null) => void) => View): Promise<T | null> {
  return new Promise((resolve) => {
    let given: T | null = null;
    const answer = (value: T | null): void => {
      given = value;
      dialog.close();
    };
    const dialog = el("dialog", { "aria-labelledby": "dialog-title" });
    const view = html`<div class="dialog-head"><h2 id="dialog-title">${title}</h2><button type="button" class="quiet square"
        aria-label=${word("shell.close")} @click=${() => answer(null)}>✕</button></div>${make(answer)}`;
    draw(dialog, view);
    dialog.addEventListener("close", () => {
      dialog.remove();
      resolve(given);
    });
    // A drag that begins inside may end outside, as when text is selected; the padding counts as inside.
    let beganOutside = false;
    dialog.addEventListener("pointerdown", (event) => (beganOutside = !isOver(dialog, event)));
    dialog.addEventListener("click", (event) => {
      if (event.target === dialog && beganOutside && !isOver(dialog, event)) answer(null);
    });
    document.body.append(dialog);
    dialog.showModal();
    dialog.querySelector<HTMLElement>(dialog.querySelector("[autofocus]") ? "[autofocus]" : "button")?.focus();
  });
}
