/** Building the page: elements with attributes, listeners and children; text is always text, never markup. */

import { unpressed } from "./press";

type Listener = (event: never) => void;
export type Attributes = Record<string, string | number | boolean | Listener | null | undefined>;
export type Child = Node | string | null | undefined | false;

/** Make an element; `on...` attributes are listeners, true is an empty attribute, false and null none. */
export function el<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  setAttributes(element, attributes);
  element.append(...present(children));
  return element;
}

/** Put these in the place of an element's children, once none of them is pressed. */
export function fill(element: Element, ...children: Child[]): void {
  unpressed(element, () => element.replaceChildren(...present(children)));
}

/** Set the children, touching only what is elsewhere: a view that is moved loses its focus and its scroll. */
export function put(parent: HTMLElement, children: HTMLElement[]): void {
  for (const child of [...parent.children]) if (!children.includes(child as HTMLElement)) child.remove();
  children.forEach((child, k) => {
    if (parent.children[k] !== child) parent.insertBefore(child, parent.children[k] ?? null);
  });
}

/** Controls that can have the focus. */
const CONTROLS = ":is(button, input, select, summary):not(:disabled)";

/** Replace an element's children; the focus stays on the control of the same name or, for keyboard users, near it. */
export function refill(element: Element, ...children: Child[]): void {
  unpressed(element, () => refillNow(element, children));
}

function refillNow(element: Element, children: Child[]): void {
  const before = [...element.querySelectorAll<HTMLElement>(CONTROLS)];
  const index = before.indexOf(document.activeElement as HTMLElement);
  const active = before[index];
  const byKeys = active?.matches(":focus-visible") ?? false;
  element.replaceChildren(...present(children));
  if (!active) return;
  const after = [...element.querySelectorAll<HTMLElement>(CONTROLS)];
  const again = after.find((control) => nameOf(control) === nameOf(active));
  (again ?? (byKeys ? after[Math.min(index, after.length - 1)] : null))?.focus({ preventScroll: true });
}

/** What it is known by: the words of a file's entry change when its facts come. */
function nameOf(control: HTMLElement): string {
  return `${control.tagName} ${control.dataset["path"] ?? control.getAttribute("aria-label") ?? control.textContent}`;
}

/** Tell whether keys belong to what is being typed, so that they are no shortcuts. */
export function isTyping(target: EventTarget | null): boolean {
  if (!(target instanceof HTMLElement)) return false;
  return target.isContentEditable || ["INPUT", "TEXTAREA", "SELECT"].includes(target.tagName);
}

/** Tell whether Space presses a button that was focused by keyboard, so that it is no shortcut. */
export function isPress({ key, target }: KeyboardEvent): boolean {
  return key === " " && target instanceof HTMLElement && target.matches(":is(button, summary):focus-visible");
}

/** Tell whether the key for shortcuts is held: Ctrl, or Cmd on a Mac. */
export function isCommand(event: KeyboardEvent | MouseEvent): boolean {
  return (event.ctrlKey || event.metaKey) && !isSign(event);
}

/** Tell whether AltGr is held, which types characters such as [ on some keyboards; Windows adds Ctrl and Alt. */
export function isSign(event: KeyboardEvent | MouseEvent): boolean {
  return event.getModifierState("AltGraph");
}

function present(children: Child[]): (Node | string)[] {
  return children.filter((child): child is Node | string => child !== null && child !== undefined && child !== false);
}

export function setAttributes(element: Element, attributes: Attributes): void {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (typeof value === "function") element.addEventListener(name.slice(2), value as EventListener);
    else element.setAttribute(name, value === true ? "" : String(value));
  }
}
