/** What may be written where the cursor stands: keys that the schema knows there, values, and names that the world has. */

import {
  autocompletion,
  type Completion,
  type CompletionContext,
  type CompletionResult,
  completionKeymap,
} from "@codemirror/autocomplete";
import { yamlLanguage } from "@codemirror/lang-yaml";
import { type Extension, Prec } from "@codemirror/state";
import { keymap } from "@codemirror/view";
import type { Field, Level, SchemaBook } from "../panel/schema";
import { seenFrom } from "../shell/paths";
import type { Studio } from "../shell/view";
import { word } from "../words/words";
import { hint } from "./hover";
import { namesIn, partsFor } from "./names";
import { modulesOf, ownKeys } from "./own_keys";
import { ancestor, beside, levelsOf, type Read } from "./tree";

/** Keys whose value is the name of a thing of the world. */
const NAMING = [
  ...["on", "robot", "move", "open", "close", "lamp", "remove", "restore", "shove", "push", "reach", "release", "lead"],
  ...["seat", "goal"],
];
/** What stands for the word that is not yet whole, so that the text around it can be read. */
const STAND_IN = "x__";

/** What a text of YAML has quotes for, also within brackets: names of files may have anything. */
const SIGNS = /[\s,#{}[\]\x22\x27&*!|>%@\x60]/;

/** Where a cursor stands: the keys that lead to a mapping, and either its keys so far or the key of the value. */
interface Place {
  above: Level[];
  has: string[];
  levelOfValue: Level | null;
  /** Whether the key that is written has its colon already. */
  hasColon: boolean;
  /** The module of the mapping, when it names one. */
  use: string | null;
  /** Names of parts of things that the value may be. */
  parts: string[];
}

/** Offers keys with unit, meaning and default, and values; asked for by typing or Ctrl+Space. */
export function completion(book: SchemaBook, studio: Studio): Extension {
  const source = async (context: CompletionContext): Promise<CompletionResult | null> => {
    const word = context.matchBefore(/[\p{L}\p{N}_./-]*/u);
    if (!word || (word.from === word.to && !context.explicit)) return null;
    const place = placeOf(context, word.from);
    const options = place ? await offered(place, book, studio) : [];
    const whole = options.some(({ label }) => label === word.text);
    if (!options.length || (whole && !context.explicit)) return null;
    return { from: word.from, options, validFor: /^[\p{L}\p{N}_./-]*$/u };
  };
  return [
    autocompletion({ override: [source], icons: false, defaultKeymap: false }),
    // Escape shuts the list first, then leaves the text.
    Prec.high(keymap.of([...completionKeymap])),
  ];
}

async function offered(place: Place, book: SchemaBook, studio: Studio): Promise<Completion[]> {
  const { above, has, levelOfValue, hasColon, parts, use } = place;
  const values = async (levels: Level[]): Promise<Completion[]> => {
    const field = book.along(levels);
    const found = [...parts, ...(field ? await valuesOf(field, levels, studio) : [])];
    return [...new Set(found)].map((label) => ({
      label,
      apply: SIGNS.test(label) ? JSON.stringify(label) : label,
      type: "constant",
    }));
  };
  if (levelOfValue) return values([...above, levelOfValue]);
  const known = above.at(-1)?.key === "drivers" ? driven(has, studio) : book.missing(above, has).map(keyOption);
  const own =
    use === null ? [] : (await ownKeys(studio, book, use)).filter(({ key }) => !has.includes(key)).map(keyOption);
  const options = [...known, ...own];
  // What begins like a key may be an entry of a list of names.
  if (!options.length) return values(above);
  return hasColon ? options.map(({ apply: _, ...option }) => option) : options;
}

/** Robots that have no modules yet. */
function driven(has: string[], studio: Studio): Completion[] {
  const robots = studio.document.items.filter(({ path }) => path[0] === "robots").flatMap(({ name }) => name ?? []);
  return robots.filter((name) => !has.includes(name)).map((label) => ({ label, apply: `${label}:` }));
}

/** What comes with mjsim for an arm, a sensor or a robot. */
function presetsAt(levels: Level[], studio: Studio): string[] {
  const { arms, sensors, presets } = studio.folder.shipped;
  const list = levels.at(-2)?.key;
  if (list === "arms") return arms;
  if (list === "sensors") return levels.at(-1)?.beside.flatMap((kind) => sensors[kind] ?? []) ?? [];
  return list === "robots" ? presets.map(({ name }) => name) : [];
}

function keyOption(field: Field, order: number): Completion {
  const { key, kind, unit, required } = field;
  const inner = ["object", "list", "map"].includes(kind.is);
  return {
    label: key,
    apply: inner ? `${key}:` : `${key}: `,
    detail: [unit ? `[${unit}]` : "", required ? word("text.required") : ""].join(" ").trim(),
    info: () => hint(field),
    boost: (required ? 50 : 0) - Math.min(order, 40),
  };
}

async function valuesOf(field: Field, levels: Level[], studio: Studio): Promise<string[]> {
  const { models, pictures } = studio.folder.shipped;
  if (field.kind.is === "choice") return field.kind.options.map(String);
  if (field.kind.is === "switch") return ["true", "false"];
  if (field.key === "include")
    return studio.folder.worlds
      .filter((path) => path !== studio.document.path)
      .map((path) => seenFrom(studio.document.path, path));
  if (field.key === "preset") return presetsAt(levels, studio);
  if (field.key === "model") return models;
  if (field.kind.is === "picture") return pictures;
  if (field.key === "use") return (await modulesOf(studio)).map(({ use }) => use);
  if (!NAMING.includes(field.key)) return [];
  // The names are those of the text as it is now.
  await studio.document.settled();
  return studio.document.items.flatMap(({ name }) => name ?? []);
}

/** Where a word begins in the text that is being written; null where no mapping is. */
function placeOf(context: CompletionContext, from: number): Place | null {
  const { state, pos } = context;
  const line = state.doc.lineAt(from);
  const before = state.sliceDoc(line.from, from);
  const isValue = /:[ \t]+$/.test(before);
  // After other words of a line there is no key, but within braces.
  if (!isValue && !/^[ \t]*(- +)*$/.test(before) && !/[[{,][ \t]*$/.test(before)) return null;
  const hasColon = !isValue && /^:(\s|$)/.test(state.sliceDoc(pos, line.to));
  const word =
    (isValue || hasColon ? STAND_IN : `${STAND_IN}: 0`) +
    (hasColon ? "" : closers(before, state.sliceDoc(pos, line.to)));
  const key = keyAt(state.sliceDoc(0, from), word, state.sliceDoc(pos));
  const levels = key?.levels ?? [];
  const last = levels.at(-1);
  if (!last) return null;
  const has = last.beside.filter((name) => name !== STAND_IN);
  const common = { above: levels.slice(0, -1), has, hasColon, use: key?.use ?? null, parts: key?.parts ?? [] };
  if (isValue) return { ...common, levelOfValue: { key: last.key, beside: last.beside } };
  return last.key === STAND_IN ? { ...common, levelOfValue: null } : null;
}

/** The brackets that a line has open before the cursor and does not shut behind it, shut. */
function closers(before: string, after: string): string {
  const open: string[] = [];
  for (const sign of before) {
    if (sign === "{") open.push("}");
    else if (sign === "[") open.push("]");
    else if (sign === open.at(-1)) open.pop();
  }
  const shut = [...after].filter((sign) => "]}".includes(sign)).length;
  return open
    .reverse()
    .slice(0, Math.max(open.length - shut, 0))
    .join("");
}

/** The keys that lead to a stand-in, read from the text with it in place of the word. */
function keyAt(
  before: string,
  standIn: string,
  after: string,
): { levels: Level[]; use: string | null; parts: string[] } | null {
  const text = before + standIn + after;
  const tree = yamlLanguage.parser.parse(text);
  const pair = ancestor(tree.resolveInner(before.length, 1), "Pair");
  const key = pair?.getChild("Key");
  if (!pair || !key) return null;
  const read: Read = (node) => text.slice(node.from, node.to);
  const levels = levelsOf(key, read);
  const named = levels.findLast((level) => level.key !== STAND_IN)?.key ?? "";
  return { levels, use: beside(pair, "use", read), parts: partsFor(named, pair, namesIn(tree, read), read) };
}
