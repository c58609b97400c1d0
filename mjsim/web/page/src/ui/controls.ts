/** Buttons, switches and lists, and what the page remembers of them. */

import { type Attributes, type Child, el } from "./dom";

/** A button; where it has no words, `title` is its name. */
export function button(attributes: Attributes, press: () => void, ...children: Child[]): HTMLButtonElement {
  const silent = children.every((child) => child instanceof SVGElement);
  const name = silent ? (attributes["title"] ?? null) : null;
  return el("button", { type: "button", "aria-label": name, ...attributes, onclick: press }, ...children);
}

/** A button that stays down until it is pressed again. */
export function toggle(
  attributes: Attributes,
  on: boolean,
  press: (on: boolean) => void,
  ...children: Child[]
): HTMLButtonElement {
  const element = button(
    { ...attributes, "aria-pressed": String(on) },
    () => {
      setPressed(element, !isPressed(element));
      press(isPressed(element));
    },
    ...children,
  );
  return element;
}

export function isPressed(element: HTMLElement): boolean {
  return element.getAttribute("aria-pressed") === "true";
}

export function setPressed(element: HTMLElement, on: boolean): void {
  element.setAttribute("aria-pressed", String(on));
}

/** Set a text only where it is another, so that nothing is laid out again for nothing. */
export function write(element: HTMLElement, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

/** Read or write what the page is to remember between visits; a browser may forbid that. */
export function remembered(key: string, value?: string): string | null {
  try {
    if (value !== undefined) localStorage.setItem(`mjsim.${key}`, value);
    return localStorage.getItem(`mjsim.${key}`);
  } catch {
    return value ?? null;
  }
}
