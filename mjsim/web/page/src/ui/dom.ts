/** Elements that are made once, with attributes, listeners and children; what changes is a view (view.ts). */

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

/** Set the children, touching only what is elsewhere: a view that is moved loses its focus and its scroll. */
export function put(parent: HTMLElement, children: HTMLElement[]): void {
  for (const child of [...parent.children]) if (!children.includes(child as HTMLElement)) child.remove();
  children.forEach((child, k) => {
    if (parent.children[k] !== child) parent.insertBefore(child, parent.children[k] ?? null);
  });
}

/** Tell whether keys belong to what is being typed, so that they are no shortcuts. */
export function isTyping(target: EventTarget | null): boolean {
  if (!(target instanceof HTMLElement)) return false;
  return target.isContentEditable || ["INPUT", "TEXTAREA", "SELECT"].includes(target.tagName);
}

/** Tell whether keys belong to a field of a form whose text is not given on yet. */
export function isHalfTyped(target: EventTarget | null): boolean {
  return target instanceof HTMLInputElement && "typed" in target.dataset && target.value !== target.defaultValue;
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
