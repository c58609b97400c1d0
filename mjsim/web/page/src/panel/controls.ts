/** One control for each kind of value. What was entered is given on at Enter, or when it is left. */

import type { Module, Path } from "../api";
import { el, fill } from "../ui/dom";
import { icon } from "../ui/icons";
import { word } from "../words/words";
import type { Field, Kind } from "./schema";
import { SEVERAL } from "./several";

export interface Entry {
  /** Stands for it when the page is drawn anew: keeps the keyboard's place. */
  id: string;
  field: Field;
  value: unknown;
  /** Whether it stands in the text; else the value is a default, shown pale. */
  written: boolean;
  disabled: boolean;
  error: string | null;
  label: string;
  give(value: unknown): void;
}

export interface Tools {
  /** Address of a thumbnail. */
  picture(path: string): string;
  choosePicture(): Promise<string | null>;
  /** What may be entered at a key of a type of item, so that nobody need know it by heart. */
  suggestions(id: string): string[];
  /** Keys that a map may have. */
  names(path: Path): string[];
  /** A module by its `use`; undefined for one that is not known, or not yet. */
  module(use: string): Module | undefined;
  /** Let the person choose a module for a key of the world file; null when they would rather not. */
  chooseModule(path: Path): Promise<{ value: unknown } | null>;
}

/** The control of a simple value; null for what is made of parts. */
export function control(entry: Entry, tools: Tools): HTMLElement | null {
  const { kind } = entry.field;
  switch (kind.is) {
    case "number":
      return withUnit(numberField(entry, kind), entry.field.unit);
    case "numbers":
      return numberRow(entry, kind.parts);
    case "text":
      return textField(entry, tools);
    case "switch":
      return switchField(entry);
    case "choice":
      return choiceField(entry, kind.options);
    case "color":
      return colorField(entry);
    case "picture":
      return pictureField(entry, tools);
    case "module":
      return moduleField(entry, tools);
    case "data":
      return dataField(entry);
    default:
      return null;
  }
}

/** Give the text of a field on when it is complete. */
function commit(input: HTMLInputElement, read: (text: string) => void): HTMLInputElement {
  input.addEventListener("change", () => "replaced" in input.dataset || read(input.value.trim()));
  input.addEventListener("input", () => (input.dataset["touched"] = ""));
  input.addEventListener("keydown", (event) => {
    if (event.key === "Enter") input.blur();
    if (event.key === "Escape") {
      input.value = input.defaultValue;
      input.blur();
    }
  });
  return input;
}

function base(entry: Entry, text: string, part = ""): Record<string, string | boolean | null> {
  return {
    "data-id": part ? `${entry.id} ${part}` : entry.id,
    value: entry.written ? text : "",
    placeholder: entry.written ? "" : text,
    disabled: entry.disabled,
    "aria-label": part ? `${entry.label} ${part}` : entry.label,
    "aria-invalid": entry.error ? "true" : null,
    "aria-describedby": entry.error ? `${entry.id}-error` : `${entry.id}-meaning`,
    autocomplete: "off",
    spellcheck: "false",
  };
}

/** Smaller numbers are rounding errors. */
const NOTHING = 1e-12;

/** Format a value: numbers to four decimals, small ones, such as inertias, to four significant digits. */
function shown(value: unknown): string {
  if (value === null || value === undefined) return "–";
  if (value === SEVERAL) return word("panel.several");
  if (typeof value !== "number") return String(value);
  const size = Math.abs(value);
  return size < NOTHING ? "0" : String(Number(size < 0.1 ? value.toPrecision(4) : value.toFixed(4)));
}

/** A number, or arithmetic such as ${width / 2}; undefined when it is neither: a comma may separate decimals or thousands. */
function readNumber(text: string): number | string | undefined {
  if (text.includes("${")) return text;
  const value = Number(text.replace("−", "-"));
  return text === "" || !Number.isFinite(value) ? undefined : value;
}

function numberField(entry: Entry, kind: Extract<Kind, { is: "number" }>): HTMLInputElement {
  const input = el("input", { ...base(entry, shown(entry.value)), inputmode: "decimal", class: "number" });
  const step = kind.whole ? 1 : entry.field.unit.startsWith("°") ? 5 : 0.1;
  return stepping(input, entry, step, (value) => entry.give(value));
}

/** Arrows up and down change a number by a step, with Shift by a tenth of it. */
function stepping(
  input: HTMLInputElement,
  entry: Entry,
  step: number,
  give: (value: number | string) => void,
): HTMLInputElement {
  input.addEventListener("keydown", (event) => {
    const sign = event.key === "ArrowUp" ? 1 : event.key === "ArrowDown" ? -1 : 0;
    const now = Number(input.value || input.placeholder);
    if (!sign || !Number.isFinite(now)) return;
    event.preventDefault();
    input.value = String(Number((now + sign * step * (event.shiftKey && step < 1 ? 0.1 : 1)).toFixed(4)));
    input.dataset["touched"] = "";
    give(Number(input.value));
  });
  return commit(input, (text) => {
    if (text === input.defaultValue) return;
    const value = readNumber(text);
    if (value !== undefined) give(value);
    else if (text === "" && !entry.field.required) entry.give(undefined);
    else refuse(input, entry, word(text.includes(",") ? "panel.hasAComma" : "panel.isNoNumber", { text }));
  });
}

function refuse(input: HTMLInputElement, entry: Entry, message: string): void {
  input.setAttribute("aria-invalid", "true");
  const row = input.closest(".field");
  row?.querySelector(".field-error")?.remove();
  row?.append(el("p", { class: "field-error", role: "alert", id: `${entry.id}-error` }, message));
}

function numberRow(entry: Entry, parts: string[]): HTMLElement {
  const values = Array.isArray(entry.value) ? (entry.value as unknown[]) : parts.map(() => 0);
  // Includes parts that were entered while the server has not answered yet.
  let now = values;
  const step = 0.1;
  const inputs = parts.map((part, index) => {
    const input = el("input", { ...base(entry, shown(values[index]), part), inputmode: "decimal", class: "number" });
    const give = (value: number | string): void => entry.give((now = now.map((old, k) => (k === index ? value : old))));
    return el("label", { class: "part" }, el("span", {}, part), stepping(input, entry, step, give));
  });
  return el(
    "div",
    {
      class: `parts${parts.length > 2 || parts.some((part) => part.length > 1) ? " words" : ""}`,
      "data-parts": parts.length,
    },
    ...inputs,
  );
}

function textField(entry: Entry, tools: Tools): HTMLElement {
  const offers = tools.suggestions(entry.id);
  const list = `${entry.id}-offers`;
  const input = el("input", { ...base(entry, shown(entry.value)), ...(offers.length ? { list } : {}) });
  commit(input, (text) => {
    if (text === input.defaultValue) return;
    if (text === "" && entry.field.required) refuse(input, entry, word("panel.giveItAName"));
    else entry.give(text === "" ? undefined : text);
  });
  if (offers.length === 0) return input;
  return el("div", {}, input, el("datalist", { id: list }, ...offers.map((value) => el("option", { value }))));
}

function switchField(entry: Entry): HTMLElement {
  const input = el("input", {
    type: "checkbox",
    "data-id": entry.id,
    role: "switch",
    disabled: entry.disabled,
    "aria-label": entry.label,
    "aria-describedby": `${entry.id}-meaning`,
  });
  input.checked = entry.value === true;
  input.indeterminate = entry.value === SEVERAL;
  input.addEventListener("change", () => entry.give(input.checked));
  const said = input.indeterminate ? "panel.several" : input.checked ? "panel.yes" : "panel.no";
  return el("label", { class: "switch" }, input, el("span", { class: "hint" }, word(said)));
}

function choiceField(entry: Entry, options: (string | number)[]): HTMLSelectElement {
  const { value } = entry;
  const isKnown = options.some((option) => option === value) || value === null || value === undefined;
  // Values that differ, and expressions, are not among the options: they get an entry of their own.
  const none = isKnown ? (entry.field.nullable ? "–" : null) : shown(value);
  const all = none === null ? options : ["", ...options];
  const now = isKnown ? (value ?? "") : "";
  const nodes = all.map((option) =>
    el("option", { value: option, selected: option === now }, option === "" ? none : String(option)),
  );
  const select = el(
    "select",
    { "data-id": entry.id, disabled: entry.disabled, "aria-label": entry.label, class: entry.written ? "" : "pale" },
    ...nodes,
  );
  select.addEventListener("change", () => {
    const chosen = all[select.selectedIndex];
    entry.give(chosen === "" ? undefined : chosen);
  });
  return select;
}

function colorField(entry: Entry): HTMLElement {
  const value = typeof entry.value === "string" ? entry.value : "";
  const input = commit(el("input", { ...base(entry, shown(entry.value)), class: "mono" }), (text) => {
    if (text === input.defaultValue) return;
    if (/^#[0-9a-f]{6}$/i.test(text) || text.includes("${")) entry.give(text);
    else if (text === "" && !entry.field.required) entry.give(undefined);
    else refuse(input, entry, word("panel.isNoColourWriteIt", { text }));
  });
  const swatch = el("input", {
    type: "color",
    value: /^#[0-9a-f]{6}$/i.test(value) ? value : "#888888",
    disabled: entry.disabled,
    "aria-label": word("panel.chooseFor", { label: entry.label }),
    "data-id": `${entry.id} swatch`,
  });
  swatch.addEventListener("change", () => entry.give(swatch.value));
  return el("div", { class: "joined" }, swatch, input);
}

function pictureField(entry: Entry, tools: Tools): HTMLElement {
  const path = typeof entry.value === "string" ? entry.value : null;
  const choose = async (): Promise<void> => {
    const chosen = await tools.choosePicture();
    if (chosen) entry.give(chosen);
  };
  const picture = path ? el("img", { src: tools.picture(path), alt: "", loading: "lazy" }) : icon("beacon");
  const button = el("button", {
    type: "button",
    class: "pick",
    "data-id": entry.id,
    disabled: entry.disabled,
    "aria-label": word("panel.choosePictureFor", { label: entry.label }),
    title: path ?? word("panel.chooseAPicture"),
    onclick: () => void choose(),
  });
  const name = entry.value === SEVERAL ? word("panel.several") : (path?.replace(/^.*\//, "") ?? word("panel.choose"));
  fill(button, picture, el("span", { class: "path" }, name));
  return button;
}

/** The module that is chosen, which opens what there is. */
function moduleField(entry: Entry, tools: Tools): HTMLElement {
  const name = moduleTitle(entry.value, tools);
  const choose = async (): Promise<void> => {
    const chosen = await tools.chooseModule(JSON.parse(entry.id) as Path);
    if (chosen) entry.give(chosen.value);
  };
  return el(
    "button",
    {
      type: "button",
      class: `pick module-pick${entry.value ? "" : " pale"}`,
      "data-id": entry.id,
      disabled: entry.disabled,
      "aria-label": word("panel.chooseModuleFor", { label: entry.label, name }),
      title: useOf(entry.value) ?? word("panel.chooseAModule"),
      onclick: () => void choose(),
    },
    el("span", { class: "path" }, name),
    icon("down"),
  );
}

/** The name of a module as it is written: on for one that is built in. */
export function moduleTitle(value: unknown, tools: Pick<Tools, "module">): string {
  const use = useOf(value);
  if (use !== null) return tools.module(use)?.title ?? use.replace(/^exec:|^[^:]*:(?=\w+$)/, "");
  return word(value === true ? "panel.builtIn" : "panel.noModule");
}

export function useOf(value: unknown): string | null {
  const use = typeof value === "object" && value !== null ? (value as Record<string, unknown>)["use"] : null;
  return typeof use === "string" ? use : null;
}

/** What has no control of its own is written as JSON. */
function dataField(entry: Entry): HTMLInputElement {
  const text = entry.value === SEVERAL ? shown(entry.value) : JSON.stringify(entry.value ?? null);
  const input = el("input", { ...base(entry, text), class: "mono" });
  return commit(input, (text) => {
    if (text === input.defaultValue) return;
    try {
      entry.give(text === "" ? undefined : (JSON.parse(text) as unknown));
    } catch {
      entry.give(text);
    }
  });
}

function withUnit(input: HTMLElement, unit: string): HTMLElement {
  return unit ? el("div", { class: "with-unit" }, input, el("span", { class: "unit" }, unit)) : input;
}
