/** One control for each kind of value. What was entered is given on at Enter, or when it is left. */

import type { Module, Path } from "../api";
import { sign } from "../ui/icons";
import { html, live, nothing, options, typed, type View, withValue } from "../ui/view";
import { word } from "../words/words";
import { readNumber, shown, stepped } from "./numbers";
import type { Field, Kind } from "./schema";
import { SEVERAL } from "./several";

export interface Entry {
  /** The key of its path. */
  id: string;
  field: Field;
  value: unknown;
  /** Whether it stands in the text; else the value is a default, shown pale. */
  written: boolean;
  disabled: boolean;
  error: string | null;
  label: string;
  give(value: unknown): void;
  /** Whether what was typed could not be read: it stays as it is. */
  refused: boolean;
  /** Say why; null when that is over. */
  refuse(why: string | null): void;
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
export function control(entry: Entry, tools: Tools): View {
  const { kind } = entry.field;
  switch (kind.is) {
    case "number":
      return withUnit(numberField(entry, kind), entry.field.unit);
    case "numbers":
      return numberRow(entry, kind.parts);
    case "text":
      return textField(entry, tools.suggestions(entry.id));
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

/** What sets one field of text apart from others. */
interface Look {
  part?: string;
  kind?: string;
  list?: string;
  /** How far arrows up and down change a number, with Shift a tenth of it. */
  step?: number;
}

/** A field whose text is given on when it is complete; Escape takes back what was typed. */
function field(
  entry: Entry,
  text: string,
  read: (text: string) => void,
  { part = "", kind = "", list, step }: Look = {},
): View {
  const known = entry.written ? text : "";
  const given = withValue((value) => {
    const now = value.trim();
    if (now !== known) read(now);
    else if (entry.refused) entry.refuse(null);
  });
  const key = (event: KeyboardEvent): void => {
    const input = event.target as HTMLInputElement;
    const next = step ? stepped(input.value || input.placeholder, event, step) : null;
    if (next !== null) {
      event.preventDefault();
      input.value = next;
      read(next);
    }
    if (event.key === "Escape") {
      input.value = known;
      if (entry.refused) entry.refuse(null);
    }
    if (event.key === "Enter" || event.key === "Escape") input.blur();
  };
  const named = part && ` ${part}`;
  return html`<input class=${kind} data-id=${entry.id + named} aria-label=${entry.label + named}
    placeholder=${entry.written ? "" : text} ?disabled=${entry.disabled} inputmode=${step ? "decimal" : nothing}
    aria-invalid=${entry.error ? "true" : nothing} list=${list ?? nothing} autocomplete="off" spellcheck="false"
    aria-describedby=${`${entry.id}-${entry.error ? "error" : "meaning"}`} ${typed(known, entry.refused)}
    @change=${given} @keydown=${key}>`;
}

function textOf(value: unknown): string {
  return value === SEVERAL ? word("panel.several") : shown(value);
}

/** Take up the text of a number. */
function reading(entry: Entry, give: (value: number | string) => void): (text: string) => void {
  return (text) => {
    const value = readNumber(text);
    if (value !== undefined) give(value);
    else if (text === "" && !entry.field.required) entry.give(undefined);
    else entry.refuse(word(text.includes(",") ? "panel.hasAComma" : "panel.isNoNumber", { text }));
  };
}

function numberField(entry: Entry, kind: Extract<Kind, { is: "number" }>): View {
  const step = kind.whole ? 1 : entry.field.unit.startsWith("°") ? 5 : 0.1;
  return field(entry, textOf(entry.value), reading(entry, entry.give), { kind: "number", step });
}

function numberRow(entry: Entry, parts: string[]): View {
  const values = Array.isArray(entry.value) ? (entry.value as unknown[]) : parts.map(() => 0);
  // Includes parts that were entered while the server has not answered yet.
  let now = values;
  const inputs = parts.map((part, index) => {
    const give = (value: number | string): void => entry.give((now = now.map((old, k) => (k === index ? value : old))));
    const input = field(entry, textOf(values[index]), reading(entry, give), { part, kind: "number", step: 0.1 });
    return html`<label class="part"><span>${part}</span>${input}</label>`;
  });
  const words = parts.length > 2 || parts.some((part) => part.length > 1) ? " words" : "";
  return html`<div class="parts${words}" data-parts=${parts.length}>${inputs}</div>`;
}

/** Why a text names nothing: names are followed wherever they are written, and a wrong one would be in vain. */
function nameFault({ id, field: { key, kind } }: Entry, text: string): string | null {
  if (key !== "name" || text.includes("${")) return null;
  if (text === "run" && /^\["robots",\d+,"name"\]$/.test(id)) return word("panel.isReserved", { text });
  return kind.is === "text" && kind.pattern?.test(text) === false ? word("panel.isNoName", { text }) : null;
}

function textField(entry: Entry, offers: string[]): View {
  const list = offers.length ? `${entry.id}-offers` : undefined;
  const read = (text: string): void => {
    const fault = text === "" ? null : nameFault(entry, text);
    if (text === "" && entry.field.required) entry.refuse(word("panel.giveItAName"));
    else if (fault) entry.refuse(fault);
    else entry.give(text === "" ? undefined : text);
  };
  const input = field(entry, textOf(entry.value), read, { list });
  const offered = offers.map((value) => html`<option value=${value}></option>`);
  return list ? html`<div>${input}<datalist id=${list}>${offered}</datalist></div>` : input;
}

function switchField({ id, value, disabled, label, give }: Entry): View {
  const isMixed = value === SEVERAL;
  const said = word(isMixed ? "panel.several" : value === true ? "panel.yes" : "panel.no");
  return html`<label class="switch"><input type="checkbox" role="switch" data-id=${id} aria-label=${label}
    aria-describedby=${`${id}-meaning`} ?disabled=${disabled} .checked=${live(value === true)}
    .indeterminate=${live(isMixed)} @change=${(event: Event) => give((event.target as HTMLInputElement).checked)}
    ><span class="hint">${said}</span></label>`;
}

function choiceField(entry: Entry, choices: (string | number)[]): View {
  const { value } = entry;
  const isKnown = choices.some((option) => option === value) || value === null || value === undefined;
  // Values that differ, and expressions, are not among the options: they get an entry of their own.
  const none = isKnown ? (entry.field.nullable ? "–" : null) : textOf(value);
  const all = none === null ? choices : ["", ...choices];
  const titled = all.map((option) => [option, option === "" ? (none ?? "") : String(option)] as const);
  const now = (isKnown ? (value ?? "") : "") as string | number;
  const give = (event: Event): void => {
    const chosen = all[(event.target as HTMLSelectElement).selectedIndex];
    entry.give(chosen === "" ? undefined : chosen);
  };
  return html`<select data-id=${entry.id} class=${entry.written ? "" : "pale"} ?disabled=${entry.disabled}
    aria-label=${entry.label} @change=${give}>${options(titled, now)}</select>`;
}

const COLOR = /^#[0-9a-f]{6}$/i;

function colorField(entry: Entry): View {
  const read = (text: string): void => {
    if (COLOR.test(text) || text.includes("${")) entry.give(text);
    else if (text === "" && !entry.field.required) entry.give(undefined);
    else entry.refuse(word("panel.isNoColourWriteIt", { text }));
  };
  const value = typeof entry.value === "string" && COLOR.test(entry.value) ? entry.value : "#888888";
  return html`<div class="joined"><input type="color" .value=${live(value)} ?disabled=${entry.disabled}
    aria-label=${word("panel.chooseFor", { label: entry.label })}
    @change=${withValue(entry.give)}
    >${field(entry, textOf(entry.value), read, { kind: "mono" })}</div>`;
}

function pictureField(entry: Entry, tools: Tools): View {
  const path = typeof entry.value === "string" ? entry.value : null;
  const choose = async (): Promise<void> => {
    const chosen = await tools.choosePicture();
    if (chosen) entry.give(chosen);
  };
  const picture = path ? html`<img src=${tools.picture(path)} alt="" loading="lazy">` : sign("beacon");
  const name = entry.value === SEVERAL ? word("panel.several") : (path?.replace(/^.*\//, "") ?? word("panel.choose"));
  return html`<button type="button" class="pick" data-id=${entry.id} ?disabled=${entry.disabled}
    aria-label=${word("panel.choosePictureFor", { label: entry.label })} title=${path ?? word("panel.chooseAPicture")}
    @click=${choose}>${picture}<span class="path">${name}</span></button>`;
}

/** The module that is chosen, which opens what there is. */
function moduleField(entry: Entry, tools: Tools): View {
  const name = moduleTitle(entry.value, tools);
  const choose = async (): Promise<void> => {
    const chosen = await tools.chooseModule(JSON.parse(entry.id) as Path);
    if (chosen) entry.give(chosen.value);
  };
  return html`<button type="button" class="pick module-pick ${entry.value ? "" : "pale"}" data-id=${entry.id}
    ?disabled=${entry.disabled} aria-label=${word("panel.chooseModuleFor", { label: entry.label, name })}
    title=${useOf(entry.value) ?? word("panel.chooseAModule")} @click=${choose}
    ><span class="path">${name}</span>${sign("down")}</button>`;
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
function dataField(entry: Entry): View {
  const text = entry.value === SEVERAL ? textOf(entry.value) : JSON.stringify(entry.value ?? null);
  const read = (text: string): void => {
    try {
      entry.give(text === "" ? undefined : (JSON.parse(text) as unknown));
    } catch {
      entry.give(text);
    }
  };
  return field(entry, text, read, { kind: "mono" });
}

function withUnit(input: View, unit: string): View {
  return unit ? html`<div class="with-unit">${input}<span class="unit">${unit}</span></div>` : input;
}
