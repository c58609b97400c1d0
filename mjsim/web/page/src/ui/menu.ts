/** A menu at a place of the page, worked with the pointer or with arrows, Enter and Escape. */

import { el } from "./dom";
import "./menu.css";

export interface Entry {
  text: string;
  keys?: string;
  /** One of several that may hold: whether it does, and whether it lies behind the one that does. */
  checked?: boolean;
  faint?: boolean;
  act(): void;
}

/** Open a menu of groups of entries with its corner at a point of the page [px]; groups that are empty are left out. */
export function openMenu(name: string, groups: Entry[][], [x, y]: [number, number]): void {
  const before = document.activeElement;
  const over = new AbortController();
  const menu = el("div", { class: "menu", role: "menu", "aria-label": name });
  const close = (back: boolean): void => {
    over.abort();
    menu.remove();
    if (back && before instanceof HTMLElement) before.focus({ preventScroll: true });
  };
  const filled = groups.filter((group) => group.length > 0);
  filled.forEach((group, index) => {
    if (index) menu.append(el("hr", {}));
    menu.append(...group.map((entry) => button(entry, () => close(true))));
  });
  menu.addEventListener("keydown", (event) => steer(event, menu, () => close(true)));
  menu.addEventListener("contextmenu", (event) => event.preventDefault());
  const leave = (event: Event): void => {
    if (!(event.target instanceof Node && menu.contains(event.target))) close(false);
  };
  window.addEventListener("pointerdown", leave, { capture: true, signal: over.signal });
  window.addEventListener("focusin", leave, { signal: over.signal });
  window.addEventListener("blur", () => close(false), { signal: over.signal });
  // Within the main landmark: a reader of screens finds it where it was asked for.
  (document.querySelector("main") ?? document.body).append(menu);
  const { width, height } = menu.getBoundingClientRect();
  menu.style.left = `${Math.max(4, Math.min(x, window.innerWidth - width - 4))}px`;
  menu.style.top = `${Math.max(4, Math.min(y, window.innerHeight - height - 4))}px`;
  (menu.querySelector<HTMLElement>("[aria-checked=true]") ?? menu.querySelector("button"))?.focus();
}

function button({ text, keys, checked, faint, act }: Entry, close: () => void): HTMLButtonElement {
  const press = (): void => {
    close();
    act();
  };
  const shown = keys ? el("kbd", { "aria-hidden": "true" }, keys) : null;
  const role =
    checked === undefined ? { role: "menuitem" } : { role: "menuitemradio", "aria-checked": String(checked) };
  return el(
    "button",
    { class: faint ? "quiet faint" : "quiet", ...role, tabindex: -1, onclick: press },
    el("span", {}, text),
    shown,
  );
}

function steer(event: KeyboardEvent, menu: HTMLElement, close: () => void): void {
  const entries = [...menu.querySelectorAll("button")];
  const now = entries.indexOf(document.activeElement as HTMLButtonElement);
  const places: Record<string, number> = {
    ArrowDown: now + 1,
    ArrowUp: now - 1 + entries.length,
    Home: 0,
    End: entries.length - 1,
  };
  const place = places[event.key];
  event.stopPropagation();
  if (place !== undefined) entries[place % entries.length]?.focus();
  else if (event.key === "Escape" || event.key === "Tab") close();
  else return;
  event.preventDefault();
}
