/** Buttons, switches and lists, and what the page remembers of them. */

import { type Attributes, type Child, el, icon } from "../dom";

/** Outlines on a field of 20 by 20. */
const ICONS = {
  play: "M6 4v12l10-6z",
  pause: "M7 4v12M13 4v12",
  step: "M5 4l7 6-7 6zM15 4v12",
  restart: "M4.2 10a5.9 5.9 0 1 0 2-4.4M6 2.2v3.6h3.6",
  stop: "M5 5h10v10H5z",
  enlarge: "M12 3h5v5M17 3l-6 6M8 17H3v-5M3 17l6-6",
  fit: "M3 7V3h4M13 3h4v4M17 13v4h-4M7 17H3v-4",
  follow: "M10 2v3.5M10 14.5V18M2 10h3.5M14.5 10H18M10 6.5a3.5 3.5 0 1 0 0 7 3.5 3.5 0 0 0 0-7z",
  layers: "M10 3l7 3.7-7 3.7-7-3.7zM3 10.4l7 3.7 7-3.7M3 14l7 3.7 7-3.7",
  up: "M4 12l6-6 6 6",
  down: "M4 8l6 6 6-6",
  left: "M12 4l-6 6 6 6",
  right: "M8 4l6 6-6 6",
  turnLeft: "M6 9a5.5 5.5 0 1 1 1.6 5M6 4v5h5",
  turnRight: "M14 9a5.5 5.5 0 1 0-1.6 5M14 4v5H9",
  film: "M3 4h14v12H3zM7 4v12M13 4v12",
  copy: "M7 7h10v10H7zM13 7V3H3v10h4",
  save: "M10 3v9M6.2 8.6l3.8 3.8 3.8-3.8M4 16.5h12",
  side: "M3 4h14v12H3zM8 4v12",
  drive:
    "M10 3a7 7 0 1 0 0 14 7 7 0 0 0 0-14zM10 8a2 2 0 1 0 0 4 2 2 0 0 0 0-4zM10 12v5M8.2 9.2L3.4 8M11.8 9.2l4.8-1.2",
  hand: "M6 10V5.5a1.2 1.2 0 0 1 2.4 0V9V3.7a1.2 1.2 0 0 1 2.4 0V9V4.7a1.2 1.2 0 0 1 2.4 0V10V7a1.2 1.2 0 0 1 2.4 0v5.5a5 5 0 0 1-5 5c-2.4 0-3.6-1-4.8-3L3.6 11.3a1.2 1.2 0 0 1 2-1.300z",
  goal: "M6 17V3M6 3l9 3.5L6 10",
  ruler: "M3 13L13 3l4 4L7 17zM6 10l1.8 1.8M8.5 7.5l1.8 1.8M11 5l1.8 1.8",
  close: "M5 5l10 10M15 5L5 15",
  open: "M3 16V5h5l2 2h7v9z",
} as const;

export type IconName = keyof typeof ICONS;

export function sign(name: IconName): SVGSVGElement {
  return icon(ICONS[name]);
}

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

/** A list to choose from. */
export function choice<T extends string>(
  attributes: Attributes,
  options: readonly (readonly [value: T, label: string])[],
  value: T,
  changed: (value: T) => void,
): HTMLSelectElement {
  const items = options.map(([key, label]) => el("option", { value: key }, label));
  const element = el("select", { ...attributes, onchange: () => changed(element.value as T) }, ...items);
  element.value = value;
  return element;
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
