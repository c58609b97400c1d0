/** What the JSON Schema says of a field: which control it wants, its unit, its meaning and its default. */

import type { Values } from "../api";
import { meaningOf, word, wordFor } from "../words/words";

export type Schema = Record<string, unknown>;

export type Kind =
  | { is: "number"; whole: boolean; least: number | null; most: number | null }
  | { is: "text"; pattern?: RegExp }
  | { is: "switch" }
  | { is: "choice"; options: (string | number)[] }
  | { is: "color" }
  | { is: "picture" }
  | { is: "numbers"; parts: string[]; entry: Schema }
  | { is: "object"; schema: Schema }
  | { is: "union"; options: Option[] }
  | { is: "list"; entry: Schema }
  | { is: "map"; entry: Schema; names: string[]; most: number }
  | { is: "module"; schema: Schema; switchable: boolean }
  | { is: "data" };

/** One of the forms that a value may have. */
export interface Option {
  title: string;
  schema: Schema;
}

export interface Field {
  key: string;
  label: string;
  unit: string;
  meaning: string;
  fallback: unknown;
  nullable: boolean;
  required: boolean;
  kind: Kind;
}

/** A key of a text, and all keys of the mapping that it stands in. */
export interface Level {
  key: string;
  beside: string[];
}

const PICTURES = ["image", "texture"];
const AXES: Record<string, string[]> = {
  box: ["length", "width", "height"],
  ramp: ["length", "width", "rise"],
  steps: ["length", "width", "rise"],
  size: ["length", "width", "height"],
  cylinder: ["radius", "height"],
  range: ["near", "far"],
};

export class SchemaBook {
  constructor(private readonly root: Schema) {}

  /** The definition of a type of item; the whole world for "". */
  definition(name: string): Schema | null {
    if (!name) return this.root;
    const found = (this.root["$defs"] as Record<string, Schema> | undefined)?.[name];
    return found ?? null;
  }

  /** What several definitions have in common: the properties that all of them have alike; null when there are none. */
  shared(names: string[]): Schema | null {
    const each = names.map((name) => (this.definition(name)?.["properties"] ?? {}) as Record<string, Schema>);
    const [first, ...others] = each.map((properties) =>
      Object.entries(properties).map((entry) => JSON.stringify(entry)),
    );
    const alike = new Set((first ?? []).filter((entry) => others.every((other) => other.includes(entry))));
    const properties = Object.fromEntries(
      Object.entries(each[0] ?? {}).filter((entry) => alike.has(JSON.stringify(entry))),
    );
    return alike.size ? { ...this.definition(names[0] ?? ""), properties } : null;
  }

  /** The field that keys lead to from the world; null where the keys beside it fit none, or the keys are a module's own. */
  along(levels: Level[]): Field | null {
    const last = levels.at(-1);
    if (!last) return null;
    const kinds = this.reached(levels.slice(0, -1));
    return kinds.flatMap((kind) => this.inside(kind, last.key, last.beside))[0] ?? null;
  }

  /** The fields that a mapping may have, which keys lead to, beside those that it has. */
  missing(levels: Level[], has: string[]): Field[] {
    const fields = this.reached(levels).flatMap((kind) => this.open(kind, has));
    return [...new Map(fields.map((field) => [field.key, field])).values()];
  }

  /** What the value of the last of some keys may be. */
  private reached(levels: Level[]): Kind[] {
    let kinds: Kind[] = [{ is: "object", schema: this.root }];
    for (const { key, beside } of levels)
      kinds = kinds.flatMap((kind) => this.inside(kind, key, beside)).map((field) => field.kind);
    return kinds;
  }

  /** The fields that a value of a kind may still have. */
  private open(kind: Kind, has: string[]): Field[] {
    const of = (schema: Schema): Field[] => this.open(this.kind("", this.forms(schema).main, schema), has);
    if (kind.is === "union") return kind.options.flatMap(({ schema }) => of(schema));
    if (kind.is === "list") return of(kind.entry);
    if (kind.is === "map")
      return kind.names.filter((name) => !has.includes(name)).flatMap((name) => this.inside(kind, name, has));
    if (kind.is !== "object" && kind.is !== "module") return [];
    const names = Object.keys(kind.schema["properties"] as Record<string, Schema>).filter(
      (name) => !has.includes(name),
    );
    return names.flatMap((name) => this.inside(kind, name, has));
  }

  /** The fields of a name in a value of a kind, whose keys are these. */
  private inside(kind: Kind, key: string, beside: string[]): Field[] {
    const of = (schema: Schema): Field[] => this.inside(this.kind(key, this.forms(schema).main, schema), key, beside);
    if (kind.is === "union") return kind.options.flatMap(({ schema }) => of(schema));
    if (kind.is === "list") return of(kind.entry);
    if (kind.is === "map") return [this.field(key, kind.entry, false)];
    if (kind.is !== "object" && kind.is !== "module") return [];
    const properties = kind.schema["properties"] as Record<string, Schema>;
    const node = properties[key];
    const required = (kind.schema["required"] ?? []) as string[];
    const isOpen = kind.schema["additionalProperties"] === true;
    const fits = isOpen || beside.every((other) => other in properties || other === "repeat");
    return node && fits ? [this.field(key, node, required.includes(key))] : [];
  }

  /** Fields of an object, in the order of the schema, but for what names and places it. */
  fields(schema: Schema): Field[] {
    const properties = (schema["properties"] ?? {}) as Record<string, Schema>;
    const required = (schema["required"] ?? []) as string[];
    return Object.entries(properties)
      .filter(([, node]) => node["const"] === undefined || node["default"] === undefined)
      .map(([key, node]) => this.field(key, node, required.includes(key)))
      .sort((a, b) => rank(a.key) - rank(b.key));
  }

  field(key: string, node: Schema, required: boolean): Field {
    const said = String(node["description"] ?? this.resolve(node)["description"] ?? "");
    const unit = typeof node["unit"] === "string" ? pretty(node["unit"]) : unitOf(key, said);
    const english = said
      .replace(/\s*\[[^\]]*\]\s*\.?$/, "")
      .replace(/\s+/g, " ")
      .trim();
    const { main, nullable } = this.forms(node);
    const label = labelOf(key);
    return {
      key,
      label,
      unit,
      meaning: meaningOf(english),
      fallback: node["default"],
      nullable,
      required,
      kind: this.kind(key, main, node),
    };
  }

  /** Follow a reference to the definition that it names. */
  resolve(node: Schema): Schema {
    const reference = node["$ref"];
    if (typeof reference !== "string") return node;
    return { ...this.definition(reference.replace("#/$defs/", "")), ...rest(node) };
  }

  /** The form of a union that a value has. */
  optionOf(options: Option[], value: unknown): Option | null {
    const fits = options.filter(({ schema }) => this.fits(schema, value));
    return fits[0] ?? null;
  }

  /** A value to begin with: what is required, each as simple as may be. */
  fresh(node: Schema, key = ""): unknown {
    const schema = this.resolve(node);
    if (schema["default"] !== undefined && schema["default"] !== null) return schema["default"];
    if (schema["const"] !== undefined) return schema["const"];
    const [example] = (schema["examples"] ?? []) as unknown[];
    if (example !== undefined) return example;
    const kind = this.kind(key, this.forms(schema).main, schema);
    if (kind.is === "number") return Math.max(kind.least === null ? 0 : kind.least, 0) || 1;
    if (kind.is === "numbers") return kind.parts.map(() => (key === "at" ? 0 : 1));
    if (kind.is === "choice") return kind.options[0];
    if (kind.is === "switch") return false;
    if (kind.is === "color") return "#8a8f98";
    if (kind.is === "union") return kind.options[0] ? this.fresh(kind.options[0].schema) : null;
    if (kind.is === "list") return [];
    if (kind.is === "map") return {};
    if (kind.is === "object" || kind.is === "module") return this.freshObject(kind.schema);
    return key;
  }

  /** What may be put into a list of an item: a word for each form, and a value to begin with, by the names of forms. */
  offers(type: string, list: string): Map<string, { title: string; value: unknown }> {
    const properties = (this.definition(type)?.["properties"] ?? {}) as Record<string, Schema>;
    const kind = this.field(list, (properties[list]?.["items"] ?? {}) as Schema, true).kind;
    const options = kind.is === "union" ? kind.options : [];
    const nameOf = (schema: Schema): string => String(this.resolve(schema)["title"] ?? "").toLowerCase();
    return new Map(options.map(({ title, schema }) => [nameOf(schema), { title, value: this.fresh(schema) }]));
  }

  private freshObject(schema: Schema): Values {
    const required = (schema["required"] ?? []) as string[];
    const properties = (schema["properties"] ?? {}) as Record<string, Schema>;
    return Object.fromEntries(required.map((key) => [key, this.fresh(properties[key] ?? {}, key)]));
  }

  private fits(node: Schema, value: unknown): boolean {
    const schema = this.resolve(node);
    if (schema["type"] === "boolean" || schema["type"] === "string" || schema["type"] === "number")
      return typeof value === schema["type"];
    if (schema["type"] !== "object" || typeof value !== "object" || value === null) return false;
    const properties = (schema["properties"] ?? {}) as Record<string, Schema>;
    const has = value as Values;
    const constants = Object.entries(properties).filter(([, part]) => part["const"] !== undefined);
    if (constants.some(([key, part]) => part["default"] === undefined && has[key] !== part["const"])) return false;
    return ((schema["required"] ?? []) as string[]).every((key) => key in has);
  }

  /** The forms of a node without null and arithmetic. */
  private forms(node: Schema): { main: Schema[]; nullable: boolean } {
    const all = ((node["anyOf"] ?? node["oneOf"]) as Schema[] | undefined) ?? [node];
    const nullable = all.some((form) => form["type"] === "null");
    const main = all.filter((form) => form["type"] !== "null" && form["$ref"] !== "#/$defs/Expression");
    return { main: main.map((form) => (form === node ? this.resolve(node) : form)), nullable };
  }

  private kind(key: string, forms: Schema[], node: Schema): Kind {
    const [first] = forms;
    const module = forms.map((form) => this.resolve(form)).find(isModule);
    if (module) return { is: "module", schema: module, switchable: forms.length > 1 };
    if (forms.length > 1) return { is: "union", options: forms.map((form) => this.option(form)) };
    if (!first) return { is: "data" };
    const schema = this.resolve(first);
    if (schema["oneOf"] || schema["anyOf"]) return this.kind(key, this.forms(schema).main, schema);
    if (Array.isArray(schema["enum"])) return { is: "choice", options: schema["enum"] as string[] };
    switch (schema["type"]) {
      case "boolean":
        return { is: "switch" };
      case "integer":
      case "number":
        return { is: "number", whole: schema["type"] === "integer", ...limits(schema) };
      case "string":
        if (String(schema["pattern"] ?? "").startsWith("^#")) return { is: "color" };
        if (PICTURES.includes(key)) return { is: "picture" };
        return { is: "text", ...(schema["pattern"] ? { pattern: new RegExp(String(schema["pattern"]), "u") } : {}) };
      case "array":
        return this.arrayKind(key, schema);
      case "object":
        return objectKind(schema, node);
      default:
        return { is: "data" };
    }
  }

  private arrayKind(key: string, schema: Schema): Kind {
    const entry = (schema["items"] ?? {}) as Schema;
    const count = schema["maxItems"];
    const { main } = this.forms(entry);
    const isNumber = main.length === 1 && ["number", "integer"].includes(String(main[0]?.["type"]));
    if (typeof count === "number" && count <= 4 && schema["minItems"] === count && isNumber) {
      const parts =
        AXES[key]?.slice(0, count).map((part) => wordFor("part", part)) ?? ["x", "y", "z", "w"].slice(0, count);
      return { is: "numbers", parts, entry };
    }
    return { is: "list", entry };
  }

  private option(form: Schema): Option {
    const schema = this.resolve(form);
    const plain: Record<string, string> = {
      boolean: word("panel.onOrOff"),
      string: word("panel.text"),
      number: word("panel.number"),
      array: word("panel.several"),
    };
    const title =
      schema["type"] === "object"
        ? wordFor("form", String(schema["title"] ?? "more"))
        : (plain[String(schema["type"])] ?? word("panel.value"));
    return { title, schema };
  }
}

/** The key that names what a schema describes: the only one that it requires, such as `camera` of a camera. */
export function namingKey(schema: Schema): string | null {
  const required = (schema["required"] ?? []) as string[];
  return required.length === 1 ? (required[0] ?? null) : null;
}

function objectKind(schema: Schema, node: Schema): Kind {
  if (schema["properties"]) return { is: "object", schema };
  const patterns = Object.values(
    (schema["patternProperties"] ?? node["patternProperties"] ?? {}) as Record<string, Schema>,
  );
  const names = ((schema["propertyNames"] as Schema | undefined)?.["enum"] ?? []) as string[];
  const most = typeof schema["maxProperties"] === "number" ? schema["maxProperties"] : Infinity;
  if (patterns[0]) return { is: "map", entry: patterns[0], names, most };
  // Each of its values means what the whole does.
  const entry = schema["additionalProperties"];
  const { description, unit } = node;
  if (typeof entry !== "object" || entry === null) return { is: "data" };
  return { is: "map", entry: { description, unit, ...entry }, names, most };
}

/** Whether a schema is that of a module; a drive of somebody's own, which has a `use` too, is a form of a drive. */
function isModule(schema: Schema): boolean {
  return schema["title"] === "Use" || schema["title"] === "Control";
}

function limits(schema: Schema): { least: number | null; most: number | null } {
  const number = (key: string): number | null => (typeof schema[key] === "number" ? schema[key] : null);
  return {
    least: number("minimum") ?? number("exclusiveMinimum"),
    most: number("maximum") ?? number("exclusiveMaximum"),
  };
}

function rest(node: Schema): Schema {
  const { $ref: _, ...others } = node;
  return others;
}

function pretty(unit: string): string {
  return unit.replaceAll("^2", "²").replaceAll("^3", "³").replace(/^deg/, "°");
}

/** The unit that a description names, or a key ends in. */
function unitOf(key: string, said: string): string {
  const named = /\[([^[\],]*)\]\s*[.;]?/.exec(said.replace(/\[[^\]]*,[^\]]*\]/g, ""))?.[1];
  if (named) return pretty(named);
  if (key.endsWith("_deg")) return "°";
  return key.endsWith("_hz") ? "Hz" : "";
}

function rank(key: string): number {
  return ["name", "at", "heading_deg"].indexOf(key) + 1 || 4;
}

export function labelOf(key: string): string {
  return wordFor("field", key.replace(/_(deg|hz)$/, ""));
}
