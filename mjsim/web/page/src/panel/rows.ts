/** Rows of the panel: a field with its name, unit, meaning, reset and error; groups of fields; lists. */

import type { Change, Path, Problem, Values } from "../api";
import { keyOf } from "../plan/plan";
import { type Child, el } from "../ui/dom";
import { icon } from "../ui/icons";
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
  change(changes: Change[]): void;
}

/** All fields of an object; simple ones first, in the order of the schema, then what stands between, then groups. */
export function objectRows(
  sheet: Sheet,
  schema: Schema,
  subject: Subject,
  skip: string[] = [],
  between: Child[] = [],
): Child[] {
  const fields = sheet.book.fields(schema).filter((field) => !skip.includes(field.key));
  const isSimple = (field: Field): boolean => !["object", "union", "list", "map"].includes(field.kind.is);
  const rows = (some: Field[]): Child[] => some.map((field) => row(sheet, field, subject));
  return [...rows(fields.filter(isSimple)), ...between, ...rows(fields.filter((field) => !isSimple(field)))];
}

function row(sheet: Sheet, field: Field, subject: Subject): Child {
  const path = [...subject.path, field.key];
  const value = subject.values[field.key] ?? (field.key in subject.values ? null : field.fallback);
  const written = isWritten(subject, field.key);
  const { fixed, within = "" } = subject;
  return valueRow(sheet, {
    field,
    path,
    value,
    raw: under(subject.raw, field.key),
    written,
    fixed,
    within,
    give: giver(sheet, path),
  });
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

function valueRow(sheet: Sheet, place: Place): Child {
  const { kind } = place.field;
  if (kind.is === "object")
    return place.value === null ? emptyRow(sheet, place, kind.schema) : objectGroup(sheet, place, kind.schema);
  if (kind.is === "union") return unionGroup(sheet, place, kind.options);
  if (kind.is === "list") return listGroup(sheet, place, kind.entry);
  if (kind.is === "map") return mapGroup(sheet, place, kind);
  if (kind.is === "module") return moduleRows(sheet, place, kind.schema);
  return simpleRow(sheet, place);
}

function simpleRow(sheet: Sheet, place: Place): HTMLElement {
  const { field, path, written, fixed } = place;
  const error = errorAt(sheet, path, true) ?? errorAt(sheet, [...path, "use"], true);
  const id = keyOf(path);
  // What is written is shown as it is written: arithmetic, and what is wrong, too.
  const value = written && place.raw !== undefined && place.raw !== null ? place.raw : place.value;
  const input = control(
    { id, field, value, written, disabled: fixed, error, label: spoken(place), give: place.give },
    sheet.tools,
  );
  const standard =
    field.fallback === null || field.fallback === undefined
      ? ""
      : word("panel.default", {
          value: `${plain(field.fallback)}${field.unit && typeof field.fallback === "number" ? ` ${field.unit}` : ""}`,
        });
  const meaning = [field.meaning, standard].filter(Boolean).join(" ");
  return el(
    "div",
    { class: `field${written ? " written" : ""}${error ? (isWarned(sheet, path) ? " odd" : " bad") : ""}` },
    el("span", { class: "label", title: meaning }, field.label),
    el("div", { class: "value" }, input, resetButton(place)),
    el("p", { class: "meaning", id: `${id}-meaning` }, meaning),
    error ? el("p", { class: "field-error", id: `${id}-error` }, error) : null,
  );
}

/** What a field is called where its surroundings are not seen. */
function spoken({ within, field }: Place): string {
  return within ? `${within}: ${field.label}` : field.label;
}

function inner(place: Place): string {
  return place.within ? `${place.within}, ${place.field.label}` : place.field.label;
}

/** Takes out what is written; null where nothing is, or it has to be. */
function resetButton(place: Place): Child {
  const { path, give } = place;
  if (!place.written || place.field.required || place.fixed) return null;
  const title = word("panel.resetToItsDefault", { place: spoken(place).toLowerCase() });
  return el(
    "button",
    {
      type: "button",
      class: "quiet reset",
      title,
      "aria-label": title,
      "data-id": `${keyOf(path)} reset`,
      onclick: () => give(undefined),
    },
    icon("reset"),
  );
}

/** An object that is not there, with a button that puts it in. */
function emptyRow(sheet: Sheet, { field, path, fixed, give }: Place, schema: Schema): HTMLElement {
  const add = el(
    "button",
    {
      type: "button",
      class: "quiet add",
      disabled: fixed,
      "data-id": `${keyOf(path)} add`,
      onclick: () => give(sheet.book.fresh(schema)),
    },
    icon("plus"),
    field.label,
  );
  return el("div", { class: "field-add", title: field.meaning }, add);
}

function objectGroup(sheet: Sheet, place: Place, schema: Schema): HTMLElement {
  return group(sheet, place, resetButton(place), objectInside(sheet, place, schema));
}

function unionGroup(sheet: Sheet, place: Place, options: Option[]): HTMLElement {
  const now = sheet.book.optionOf(options, place.value);
  const titles = [...(place.field.nullable ? [NONE] : []), ...options.map((option) => option.title)];
  const chosen = now ? now.title : NONE;
  const select = el(
    "select",
    {
      "data-id": `${keyOf(place.path)} form`,
      disabled: place.fixed,
      "aria-label": word("panel.whichForm", { place: spoken(place) }),
    },
    ...titles.map((title) => el("option", { value: title, selected: title === chosen }, title)),
  );
  select.addEventListener("change", () => {
    const wanted = options.find((option) => option.title === select.value);
    place.give(wanted ? sheet.book.fresh(wanted.schema) : undefined);
  });
  const inside =
    now && now.schema["type"] === "object"
      ? objectInside(sheet, place, now.schema)
      : now
        ? [plainInside(sheet, place, now.schema)]
        : [];
  const form = el(
    "div",
    { class: "field" },
    el("span", { class: "label" }, word("panel.form")),
    el("div", { class: "value" }, select),
  );
  return group(sheet, place, resetButton(place), [form, ...inside], chosen);
}

function objectInside(sheet: Sheet, place: Place, schema: Schema): Child[] {
  const values = isMapping(place.value) ? place.value : {};
  const { path, raw, fixed } = place;
  return objectRows(sheet, schema, { path, values, raw, fixed, within: inner(place) }, ["type"]);
}

function plainInside(sheet: Sheet, place: Place, schema: Schema): Child {
  return simpleRow(sheet, {
    ...place,
    within: inner(place),
    field: { ...sheet.book.field(place.field.key, schema, true), label: word("panel.value"), meaning: "" },
  });
}

function listGroup(sheet: Sheet, place: Place, entry: Schema): HTMLElement {
  const values = Array.isArray(place.value) ? (place.value as unknown[]) : [];
  const raws = Array.isArray(place.raw) ? (place.raw as unknown[]) : [];
  const rows = values.map((value, index) => listEntry(sheet, place, entry, value, raws[index], index));
  return group(sheet, place, null, [...rows, adder(sheet, place, entry)], values.length ? String(values.length) : NONE);
}

function listEntry(
  sheet: Sheet,
  place: Place,
  entry: Schema,
  value: unknown,
  raw: unknown,
  index: number,
): HTMLElement {
  const path = [...place.path, index];
  const described = sheet.book.field(place.field.key, entry, true);
  const { kind } = described;
  const schema =
    kind.is === "union" ? sheet.book.optionOf(kind.options, value)?.schema : kind.is === "object" ? kind.schema : null;
  const field = { ...described, label: entryTitle(value, index, schema ?? {}), key: String(index) };
  const give = (fresh: unknown): void => sheet.change([{ op: "set", path, value: fresh }]);
  const remove = el(
    "button",
    {
      type: "button",
      class: "quiet reset",
      disabled: place.fixed,
      title: word("panel.takeItOut"),
      "aria-label": word("panel.takeOut", { label: field.label }),
      "data-id": `${keyOf(path)} remove`,
      onclick: () => sheet.change([{ op: "remove", path }]),
    },
    icon("trash"),
  );
  const within = inner(place);
  const one = { field, path, value, raw, written: true, fixed: place.fixed, within, give };
  if (schema && schema["type"] === "object") return group(sheet, one, remove, objectInside(sheet, one, schema));
  const simple = simpleRow(sheet, one);
  simple.querySelector(".value")?.append(remove);
  return simple;
}

/** Adds an entry to a list: at once, or after the choice of its form. */
function adder(sheet: Sheet, place: Place, entry: Schema): HTMLElement {
  const field = sheet.book.field(place.field.key, entry, true);
  const add = (schema: Schema): void =>
    sheet.change([{ op: "add", path: place.path, value: sheet.book.fresh(schema) }]);
  const options =
    field.kind.is === "union"
      ? field.kind.options
      : [{ title: word("panel.addTo", { list: place.field.label }), schema: entry }];
  const buttons = options.map(({ title, schema }) =>
    el(
      "button",
      {
        type: "button",
        class: "quiet add",
        disabled: place.fixed,
        "data-id": `${keyOf(place.path)} add ${title}`,
        onclick: () => add(schema),
      },
      icon("plus"),
      title,
    ),
  );
  return el("div", { class: "adders" }, ...buttons);
}

function mapGroup(sheet: Sheet, place: Place, { entry, names, most }: Extract<Kind, { is: "map" }>): HTMLElement {
  const values = isMapping(place.value) ? place.value : {};
  const rows = Object.entries(values).map(([key, value]) => {
    const field = { ...sheet.book.field(key, entry, false), label: names.includes(key) ? labelOf(key) : key };
    const path = [...place.path, key];
    const [raw, within] = [under(place.raw, key), inner(place)];
    return valueRow(sheet, {
      field,
      path,
      value,
      raw,
      written: true,
      fixed: place.fixed,
      within,
      give: giver(sheet, path),
    });
  });
  const free = [...names, ...sheet.tools.names(place.path)].filter((name) => !(name in values));
  const grow = rows.length < most && !place.fixed ? keyAdder(sheet, place.path, spoken(place), entry, free) : null;
  return group(sheet, place, null, [...rows, grow], rows.length ? String(rows.length) : NONE);
}

/** A module: which one, what it does, and its options. */
function moduleRows(sheet: Sheet, place: Place, schema: Schema): HTMLElement {
  const use = useOf(place.value);
  if (use === null) return el("div", { class: "module" }, simpleRow(sheet, place));
  const offer = sheet.tools.module(use);
  const values = place.value as Values;
  const { use: _, ...own } = (schema["properties"] ?? {}) as Record<string, Schema>;
  const known = { ...own, ...(offer?.options["properties"] as Record<string, Schema> | undefined) };
  const others = Object.keys(values).filter((key) => key !== "use" && !(key in known));
  const properties = { ...known, ...Object.fromEntries(others.map((key) => [key, {}])) };
  const options = { type: "object", properties, required: offer?.options["required"] ?? [] };
  const raw = isMapping(place.raw) ? place.raw : null;
  const subject = {
    path: place.path,
    values,
    raw,
    written: Object.keys(values),
    fixed: place.fixed,
    within: inner(place),
  };
  const rows = objectRows(sheet, options, subject);
  // Functions and programs take options of any name.
  const isOpen = !offer || /^exec:|\.m$/.test(use);
  const field = { ...place.field, label: word("panel.options"), meaning: "" };
  if (isOpen && !place.fixed)
    rows.push(keyAdder(sheet, place.path, `${inner(place)}: ${field.label}`, { default: 0 }, []));
  const count = Object.keys(raw ?? {}).length - 1;
  return el(
    "div",
    { class: "module" },
    simpleRow(sheet, place),
    offer?.about ? el("p", { class: "hint module-about" }, meaningOf(offer.about)) : null,
    rows.length ? group(sheet, { ...place, field }, null, rows, count > 0 ? String(count) : "") : null,
  );
}

function group(sheet: Sheet, { field, path }: Place, beside: Child, rows: Child[], count = ""): HTMLElement {
  const key = keyOf(path);
  const error = errorAt(sheet, path, false);
  const own = errorAt(sheet, path, true);
  const head = el(
    "summary",
    { title: field.meaning, "data-id": `${key} group` },
    icon("down"),
    el("span", { class: "group-name" }, field.label),
    error
      ? el("span", {
          class: `bad-dot${isWarned(sheet, path) ? " odd" : ""}`,
          role: "img",
          "aria-label": word("panel.hasAnError"),
        })
      : null,
    el("span", { class: "count" }, count),
  );
  const details = el(
    "details",
    { open: sheet.open.get(key) ?? error !== null },
    head,
    own ? el("p", { class: "field-error" }, own) : null,
    ...rows,
  );
  details.addEventListener("toggle", () => sheet.open.set(key, details.open));
  return el("div", { class: `group${beside ? " resettable" : ""}` }, details, beside);
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
