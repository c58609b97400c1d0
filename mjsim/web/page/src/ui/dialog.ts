/** Questions: a dialog over the page that keeps the keyboard until it is answered. */

import { word } from "../words/words";
import { type Child, el } from "./dom";

export interface Choice<T> {
  text: string;
  value: T;
  kind?: "primary" | "danger";
}

/** Ask with a title, something to read or fill in, and buttons. Escape gives null. */
export function ask<T>(title: string, body: Child[], choices: Choice<T>[]): Promise<T | null> {
  return new Promise((resolve) => {
    let given: T | null = null;
    // Enter in a field presses the first button that submits: that is the main answer.
    const buttons = choices.map(({ text, value, kind }) => {
      const give = (): void => {
        given = value;
        dialog.close();
      };
      return el("button", { type: kind === "primary" ? "submit" : "button", class: kind ?? "", onclick: give }, text);
    });
    const form = el("form", { method: "dialog" }, el("h2", { id: "dialog-title" }, title), ...body);
    form.append(el("div", { class: "choices" }, ...buttons));
    const dialog = el("dialog", { "aria-labelledby": "dialog-title" }, form);
    dialog.addEventListener("close", () => {
      dialog.remove();
      resolve(given);
    });
    document.body.append(dialog);
    dialog.showModal();
    (
      dialog.querySelector<HTMLElement>("[autofocus], input, [role=option]") ??
      buttons.find((button) => button.className === "primary")
    )?.focus();
  });
}

/** Whether a pointer is over the box of an element. */
function isOver(element: HTMLElement, { clientX, clientY }: MouseEvent): boolean {
  const { left, right, top, bottom } = element.getBoundingClientRect();
  return left <= clientX && clientX <= right && top <= clientY && clientY <= bottom;
}

/** Ask with a dialog that closes itself: `make` gets how to give the answer. */
export function askWith<T>(title: string, make: (answer: (value: T | null) => void) => Child[]): Promise<T | null> {
  return new Promise((resolve) => {
    let given: T | null = null;
    const answer = (value: T | null): void => {
      given = value;
      dialog.close();
    };
    const close = el(
      "button",
      { type: "button", class: "quiet square", "aria-label": word("shell.close"), onclick: () => answer(null) },
      "✕",
    );
    const head = el("div", { class: "dialog-head" }, el("h2", { id: "dialog-title" }, title), close);
    const dialog = el("dialog", { "aria-labelledby": "dialog-title" }, head, ...make(answer));
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
    (dialog.querySelector<HTMLElement>("[autofocus]") ?? close).focus();
  });
}
