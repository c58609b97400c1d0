/** Light or dark: as the system has it, until the switch says otherwise; kept for the next time. */

import { Signal } from "./signal";

const KEY = "mjsim-theme";
const system = window.matchMedia("(prefers-color-scheme: dark)");

/** Told after the colours have changed: what is drawn on a canvas is to be drawn again. */
export const themeChanged = new Signal();

export type Theme = "light" | "dark";

export function theme(): Theme {
  const kept = window.localStorage.getItem(KEY);
  if (kept === "light" || kept === "dark") return kept;
  return system.matches ? "dark" : "light";
}

/** Take up the colours, and those of the system whenever it changes them. */
export function startTheme(): void {
  apply();
  system.addEventListener("change", apply);
}

/** Change to the other one. Where that is what the system has, it is followed again. */
export function switchTheme(): void {
  const wanted: Theme = theme() === "dark" ? "light" : "dark";
  if (wanted === (system.matches ? "dark" : "light")) window.localStorage.removeItem(KEY);
  else window.localStorage.setItem(KEY, wanted);
  apply();
}

/** The value of one of the colours of theme.css, such as "--truth". */
export function color(token: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(token).trim();
}

function apply(): void {
  document.documentElement.dataset["theme"] = theme();
  themeChanged.emit();
}
