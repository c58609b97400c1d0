/**
 * Views that change: templates, drawn into a place. What is drawn again keeps its elements, in lists those of the same
 * key, and with them focus, selection and a press.
 */

import { html, noChange, nothing, render } from "lit-html";
import { Directive, directive, type ElementPart } from "lit-html/directive.js";
import { keyed } from "lit-html/directives/keyed.js";
import { live } from "lit-html/directives/live.js";
import { repeat } from "lit-html/directives/repeat.js";
import { heirOf } from "./heir";

export { html, keyed, live, nothing, repeat };

/** A template, an element, a text, a list of these, or nothing. */
export type View = unknown;

/** Draw a view in a place; where what had the keyboard is gone, what stands there now has it, or else `beyond`. */
export function draw(place: HTMLElement, view: View, beyond?: HTMLElement): void {
  if (!place.contains(document.activeElement)) return void render(view, place);
  const before = controlsOf(place);
  const index = before.indexOf(document.activeElement as HTMLElement);
  const active = before[index];
  const isByKeys = active?.matches(":focus-visible");
  const around = active ? ancestorsOf(active, place) : [];
  // A browser has a field that goes tell of what is half typed, and that it is left.
  for (const kind of ["change", "blur"]) place.addEventListener(kind, stop, { capture: true });
  render(view, place);
  for (const kind of ["change", "blur"]) place.removeEventListener(kind, stop, { capture: true });
  if (active?.isConnected ? active === document.activeElement : !isByKeys) return;
  const isAnother = !before.some((each) => each.isConnected);
  const now =
    around
      .filter((each) => each.isConnected)
      .map(controlsOf)
      .find((each) => each.length) ?? [];
  // One that was moved among others has lost it, too.
  const next = active?.isConnected ? active : isAnother ? beyond : heirOf(before, index, now);
  next?.focus({ preventScroll: true });
}

const stop = (event: Event): void => event.stopImmediatePropagation();

/** What can have the focus. */
function controlsOf(place: HTMLElement): HTMLElement[] {
  return [...place.querySelectorAll<HTMLElement>(":is(button, input, select, summary):not(:disabled)")];
}

/** What is around an element within a place, and that, the nearest first. */
function ancestorsOf(element: HTMLElement, place: HTMLElement): HTMLElement[] {
  const above = element.parentElement;
  return above && element !== place ? [above, ...ancestorsOf(above, place)] : [];
}

/** The text of a field, `typed(text, keep)`: what is typed and not given on yet is left to the hand. */
export const typed = directive(
  class extends Directive {
    render(_text: string, _keep?: boolean): void {}

    override update({ element }: ElementPart, [text, keep = false]: [string, boolean?]): void {
      const field = element as HTMLInputElement;
      field.dataset["typed"] = "";
      const isTyped = field.value !== field.defaultValue && (keep || field === document.activeElement);
      field.defaultValue = text;
      if (!isTyped && field.value !== text) field.value = text;
    }
  },
);

/** The `.value` of a slider or a field, `unheld(value)`: while a hand is there, it is left to that. */
export const unheld = directive(
  class extends Directive {
    render(value: string): unknown {
      return live(value);
    }

    override update({ element }: ElementPart, [value]: [string]): unknown {
      return element === document.activeElement ? noChange : live(value);
    }
  },
);

/** The entries of a list to choose from. */
export function options<T extends string | number>(entries: readonly (readonly [T, string])[], now: T): View {
  return entries.map(([value, text]) => html`<option value=${value} .selected=${live(value === now)}>${text}</option>`);
}

/** The same for names, which say what they are. */
export function namesToChoose(names: string[], now: string): View {
  const entries = names.map((name) => [name, name] as const);
  return options(entries, now);
}

/** A list to choose from. */
export function choice<T extends string>(
  label: string,
  entries: readonly (readonly [T, string])[],
  now: T,
  use: (value: T) => unknown,
  disabled = false,
): View {
  const take = withValue((value) => use(value as T));
  return html`<select aria-label=${label} ?disabled=${disabled} @change=${take}>${options(entries, now)}</select>`;
}

/** A box to tick, with what stands behind it. */
export function tickBox(kind: string, label: View, on: boolean, use: (on: boolean) => unknown): View {
  const take = ({ target }: Event): unknown => use((target as HTMLInputElement).checked);
  return html`<label class=${kind}><input type="checkbox" .checked=${live(on)} @change=${take}>${label}</label>`;
}

/** A listener that takes up what a field or a list says. */
export function withValue(use: (value: string) => unknown): (event: Event) => void {
  return ({ target }) => void use((target as HTMLInputElement).value);
}

/** A listener that takes up the number of a field; an empty one, or no number, is none. */
export function withNumber(use: (value: number) => unknown): (event: Event) => void {
  return ({ target }) => {
    const { valueAsNumber } = target as HTMLInputElement;
    if (!Number.isNaN(valueAsNumber)) use(valueAsNumber);
  };
}
