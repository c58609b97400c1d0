/** Rows of the panel: a field with its name, unit, meaning, reset and error; groups of fields; lists. */

import type { Change, Module, Path, Problem, Values } from "../api";
import { keyOf } from "../plan/plan";
import { sign } from "../ui/icons";
import { choice, html, keyed, nothing, repeat, type View } from "../ui/view";
import { meaningOf, said, word } from "../words/words";
import { isMapping } from "./changes";
import { control, type Tools, useOf } from "./controls";
import { keyAdder } from "./key_adder";
import { type Field, type Kind, labelOf, namingKey, type Option, type Schema, type SchemaBook } from "./schema";

/** What stands where a value or an entry could be. */
const NONE = word("panel.noneSet");

/** What the rows of one item are made from. */
export interface Subject {
  path: Path;
  values: Values;
  /** As it stands in the text. */
  raw: unknown;
  /** The keys that it has there, where `raw` is not known. */
  written?: string[];
  fixed: boolean;
  /** The groups it is in, as they are called: fields of the same name are told apart by them. */
  within?: string;
}

export interface Sheet {
  book: SchemaBook;
  tools: Tools;
  problems: Problem[];
  /** Groups that are open, by the key of their path. */
  open: Map<string, boolean>;
  /** Why fields could not be read, by the key of their path. */
  refused: Map<string, string>;
  redraw(): void;
  change(changes: Change[]): void;
}

/** All fields of an object; simple ones first, in the order of the schema, then what stands between, then groups. */
export function objectRows(
  sheet: Sheet,
  schema: Schema,
  subject: Subject,
  skip: string[] = [],
  between: View = nothing,
): View {
  const fields = sheet.book.fields(schema).filter((field) => !skip.includes(field.key));
  const isSimple = (field: Field): boolean => !["object", "union", "list", "map"].includes(field.kind.is);
  const keyOfField = ({ key }: Field): string => keyOf([...subject.path, key]);
  const rows = (some: Field[]): View => repeat(some, keyOfField, (field) => row(sheet, field, subject));
  return [rows(fields.filter(isSimple)), between, rows(fields.filter((field) => !isSimple(field)))];
}

function row(sheet: Sheet, field: Field, subject: Subject): View {
  const path = [...subject.path, field.key];
  const value = subject.values[field.key] ?? (field.key in subject.values ? null : field.fallback);
  const written = isWritten(subject, field.key);
  const { fixed, within = "" } = subject;
  const raw = under(subject.raw, field.key);
  return valueRow(sheet, { field, path, value, raw, written, fixed, within, give: giver(sheet, path) });
}

/** Writes a value at a path; undefined takes it out. */
function giver(sheet: Sheet, path: Path): (value: unknown) => void {
  return (value) => sheet.change([value === undefined ? { op: "unset", path } : { op: "set", path, value }]);
}

interface Place {
  field: Field;
  path: Path;
  value: unknown;
  raw: unknown;
  written: boolean;
  fixed: boolean;
  within: string;
  give(value: unknown): void;
}

function valueRow(sheet: Sheet, place: Place): View {
  const { kind } = place.field;
  if (kind.is === "object")
    return place.value === null ? emptyRow(sheet, place, kind.schema) : objectGroup(sheet, place, kind.schema);
  if (kind.is === "union") return unionGroup(sheet, place, kind.options);
  if (kind.is === "list") return listGroup(sheet, place, kind.entry);
  if (kind.is === "map") return mapGroup(sheet, place, kind);
  if (kind.is === "module") return moduleRows(sheet, place, kind.schema);
  return simpleRow(sheet, place);
}

/** A value with its control; after it a button that resets it, or what stands `beside` in place of that. */
function simpleRow(sheet: Sheet, place: Place, beside = resetButton(place)): View {
  const { field, path, written, fixed, give } = place;
  const id = keyOf(path);
  const refused = sheet.refused.get(id) ?? null;
  const error = refused ?? errorAt(sheet, path, true) ?? errorAt(sheet, [...path, "use"], true);
  // What is written is shown as it is written: arithmetic, and what is wrong, too.
  const value = written && place.raw !== undefined && place.raw !== null ? place.raw : place.value;
  const refuse = (why: string | null): void => {
    if (why === null) sheet.refused.delete(id);
    else sheet.refused.set(id, why);
    sheet.redraw();
  };
  const label = spoken(place);
  const entry = { id, field, value, written, disabled: fixed, error, label, give, refused: refused !== null, refuse };
  const unit = field.unit && typeof field.fallback === "number" ? ` ${field.unit}` : "";
  const isTold = field.fallback !== null && field.fallback !== undefined;
  const standard = isTold ? word("panel.default", { value: plain(field.fallback) + unit }) : "";
  const meaning = [field.meaning, standard].filter(Boolean).join(" ");
  const state = error ? (!refused && isWarned(sheet, path) ? "odd" : "bad") : "";
  return html`<div class="field ${written ? "written" : ""} ${state}"><span class="label" title=${meaning}>${field.label}</span>
    <div class="value">${control(entry, sheet.tools)}${beside}</div>
    <p class="meaning" id=${`${id}-meaning`}>${meaning}</p>
    ${error && html`<p class="field-error" id=${`${id}-error`} role=${refused ? "alert" : nothing}>${error}</p>`}</div>`;
}

/** What a field is called where its surroundings are not seen. */
function spoken({ within, field }: Place): string {
  return within ? `${within}: ${field.label}` : field.label;
}

function inner(place: Place): string {
  return place.within ? `${place.within}, ${place.field.label}` : place.field.label;
}

/** Takes out what is written; null where nothing is, or it has to be. */
function resetButton(place: Place): View {
  if (!place.written || place.field.required || place.fixed) return null;
  const title = word("panel.resetToItsDefault", { place: spoken(place).toLowerCase() });
  return html`<button type="button" class="quiet reset" title=${title} aria-label=${title}
    @click=${() => place.give(undefined)}>${sign("reset")}</button>`;
}

/** A button that puts something in. */
function addButton(title: string, disabled: boolean, add: () => void): View {
  return html`<button type="button" class="quiet add" ?disabled=${disabled} @click=${add}>${sign("plus")}${title}</button>`;
}

/** An object that is not there, with a button that puts it in. */
function emptyRow(sheet: Sheet, { field, fixed, give }: Place, schema: Schema): View {
  const add = addButton(field.label, fixed, () => give(sheet.book.fresh(schema)));
  return html`<div class="field-add" title=${field.meaning}>${add}</div>`;
}

function objectGroup(sheet: Sheet, place: Place, schema: Schema): View {
  return group(sheet, place, resetButton(place), objectInside(sheet, place, schema));
}

function unionGroup(sheet: Sheet, place: Place, forms: Option[]): View {
  const now = sheet.book.optionOf(forms, place.value);
  const titles = [...(place.field.nullable ? [NONE] : []), ...forms.map(({ title }) => title)];
  const chosen = now?.title ?? NONE;
  const choose = (title: string): void => {
    const wanted = forms.find((form) => form.title === title);
    place.give(wanted ? sheet.book.fresh(wanted.schema) : undefined);
  };
  const isObject = now?.schema["type"] === "object";
  const inside = now && (isObject ? objectInside : plainInside)(sheet, place, now.schema);
  const entries = titles.map((title) => [title, title] as const);
  const list = choice(word("panel.whichForm", { place: spoken(place) }), entries, chosen, choose, place.fixed);
  const form = html`<div class="field"><span class="label">${word("panel.form")}</span><div class="value">${list}</div></div>`;
  return group(sheet, place, resetButton(place), [form, keyed(chosen, html`${inside}`)], chosen);
}

function objectInside(sheet: Sheet, place: Place, schema: Schema): View {
  const values = isMapping(place.value) ? place.value : {};
  const { path, raw, fixed } = place;
  return objectRows(sheet, schema, { path, values, raw, fixed, within: inner(place) }, ["type"]);
}

function plainInside(sheet: Sheet, place: Place, schema: Schema): View {
  const field = { ...sheet.book.field(place.field.key, schema, true), label: word("panel.value"), meaning: "" };
  return simpleRow(sheet, { ...place, within: inner(place), field });
}

function listGroup(sheet: Sheet, place: Place, entry: Schema): View {
  const values = Array.isArray(place.value) ? (place.value as unknown[]) : [];
  const raws = Array.isArray(place.raw) ? (place.raw as unknown[]) : [];
  const rows = values.map((value, index) => listEntry(sheet, place, entry, value, raws[index], index));
  return group(sheet, place, null, [rows, adder(sheet, place, entry)], values.length ? String(values.length) : NONE);
}

function listEntry(sheet: Sheet, place: Place, entry: Schema, value: unknown, raw: unknown, index: number): View {
  const path = [...place.path, index];
  const described = sheet.book.field(place.field.key, entry, true);
  const { kind } = described;
  const schema =
    kind.is === "union" ? sheet.book.optionOf(kind.options, value)?.schema : kind.is === "object" ? kind.schema : null;
  const field = { ...described, label: entryTitle(value, index, schema ?? {}), key: String(index) };
  const give = (fresh: unknown): void => sheet.change([{ op: "set", path, value: fresh }]);
  const remove = html`<button type="button" class="quiet reset" ?disabled=${place.fixed} title=${word("panel.takeItOut")}
    aria-label=${word("panel.takeOut", { label: field.label })} @click=${() => sheet.change([{ op: "remove", path }])}
    >${sign("trash")}</button>`;
  const one = { field, path, value, raw, written: true, fixed: place.fixed, within: inner(place), give };
  const isObject = schema?.["type"] === "object";
  return isObject ? group(sheet, one, remove, objectInside(sheet, one, schema)) : simpleRow(sheet, one, remove);
}

/** Adds an entry to a list: at once, or after the choice of its form. */
function adder(sheet: Sheet, { path, field, fixed }: Place, entry: Schema): View {
  const { kind } = sheet.book.field(field.key, entry, true);
  const forms =
    kind.is === "union" ? kind.options : [{ title: word("panel.addTo", { list: field.label }), schema: entry }];
  const buttons = forms.map(({ title, schema }) =>
    addButton(title, fixed, () => sheet.change([{ op: "add", path, value: sheet.book.fresh(schema) }])),
  );
  return html`<div class="adders">${buttons}</div>`;
}

function mapGroup(sheet: Sheet, place: Place, { entry, names, most }: Extract<Kind, { is: "map" }>): View {
  const values = isMapping(place.value) ? place.value : {};
  const { fixed } = place;
  const entryRow = (key: string): View => {
    const field = { ...sheet.book.field(key, entry, false), label: names.includes(key) ? labelOf(key) : key };
    const path = [...place.path, key];
    const [value, raw, within] = [values[key], under(place.raw, key), inner(place)];
    return valueRow(sheet, { field, path, value, raw, written: true, fixed, within, give: giver(sheet, path) });
  };
  const keys = Object.keys(values);
  const free = [...names, ...sheet.tools.names(place.path)].filter((name) => !(name in values));
  const grow = keys.length < most && !fixed ? keyAdder(sheet, place.path, spoken(place), entry, free) : null;
  const rows = repeat(keys, (key) => key, entryRow);
  return group(sheet, place, null, [rows, grow], keys.length ? String(keys.length) : NONE);
}

/** A module: which one, what it does, and its options. */
function moduleRows(sheet: Sheet, place: Place, schema: Schema): View {
  const use = useOf(place.value);
  const offer = use === null ? null : sheet.tools.module(use);
  return html`<div class="module">${simpleRow(sheet, place)}
    ${offer?.about && html`<p class="hint module-about">${meaningOf(offer.about)}</p>`}
    ${use === null ? null : moduleOptions(sheet, place, schema, use, offer)}</div>`;
}

function moduleOptions(
  sheet: Sheet,
  place: Place,
  schema: Schema,
  use: string,
  offer: Module | null | undefined,
): View {
  const values = place.value as Values;
  const { use: _, ...own } = (schema["properties"] ?? {}) as Record<string, Schema>;
  const known = { ...own, ...(offer?.options["properties"] as Record<string, Schema> | undefined) };
  const others = Object.keys(values).filter((key) => key !== "use" && !(key in known));
  const properties = { ...known, ...Object.fromEntries(others.map((key) => [key, {}])) };
  const options = { type: "object", properties, required: offer?.options["required"] ?? [] };
  const raw = isMapping(place.raw) ? place.raw : null;
  const { path, fixed } = place;
  const subject = { path, values, raw, written: Object.keys(values), fixed, within: inner(place) };
  // Functions and programs take options of any name.
  const isOpen = (!offer || /^exec:|\.m$/.test(use)) && !fixed;
  const field = { ...place.field, label: word("panel.options"), meaning: "" };
  if (!isOpen && Object.keys(properties).length === 0) return null;
  const grow = isOpen ? keyAdder(sheet, path, `${inner(place)}: ${field.label}`, { default: 0 }, []) : null;
  const count = Object.keys(raw ?? {}).length - 1;
  const rows = [objectRows(sheet, options, subject), grow];
  return group(sheet, { ...place, field }, null, rows, count > 0 ? String(count) : "");
}

function group(sheet: Sheet, { field, path }: Place, beside: View, rows: View, count = ""): View {
  const key = keyOf(path);
  const error = errorAt(sheet, path, false);
  const own = errorAt(sheet, path, true);
  const odd = isWarned(sheet, path) ? "odd" : "";
  const dot = html`<span class="bad-dot ${odd}" role="img" aria-label=${word("panel.hasAnError")}></span>`;
  const toggled = (event: Event): unknown => sheet.open.set(key, (event.target as HTMLDetailsElement).open);
  return html`<div class="group ${beside ? "resettable" : ""}">
    <details .open=${sheet.open.get(key) ?? error !== null} @toggle=${toggled}>
      <summary title=${field.meaning}>${sign("down")}<span class="group-name">${field.label}</span>${error && dot}<span
        class="count">${count}</span></summary>
      ${own && html`<p class="field-error">${own}</p>`}${rows}</details>${beside}</div>`;
}

/** What is wrong at a path, or anywhere within it. */
function errorAt({ problems }: Sheet, path: Path, exact: boolean): string | null {
  const key = keyOf(path);
  const found = problems.filter((problem) => {
    if (!problem.path) return false;
    const at = exact && !isSimplePart(problem.path, path) ? problem.path : problem.path.slice(0, path.length);
    return keyOf(at) === key;
  });
  return found.length ? found.map((problem) => said(problem.message)).join("\n") : null;
}

/** Whether all that is said of a path is well written, only hardly meant. */
function isWarned({ problems }: Sheet, path: Path): boolean {
  const key = keyOf(path);
  const said = problems.filter((problem) => problem.path && keyOf(problem.path.slice(0, path.length)) === key);
  return said.every((problem) => problem.kind === "warning");
}

/** Whether a problem lies in a number of a row such as [x, y], which has no row of its own. */
function isSimplePart(problem: Path, path: Path): boolean {
  return problem.length === path.length + 1 && typeof problem.at(-1) === "number" && typeof path.at(-1) === "string";
}

function isWritten({ raw, written = [] }: Subject, key: string): boolean {
  return isMapping(raw) ? key in raw : written.includes(key);
}

function under(raw: unknown, key: string): unknown {
  return isMapping(raw) ? raw[key] : undefined;
}

function entryTitle(value: unknown, index: number, schema: Schema): string {
  if (!isMapping(value)) return String(index + 1);
  const naming = namingKey(schema);
  if (naming && typeof value[naming] === "string") return `${labelOf(naming)} ${value[naming]}`;
  return typeof value["name"] === "string" ? value["name"] : String(index + 1);
}

function plain(value: unknown): string {
  if (typeof value === "boolean") return word(value ? "panel.yes" : "panel.no");
  return typeof value === "object" ? JSON.stringify(value) : String(value);
}
