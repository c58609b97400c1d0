/** The names that a text gives to things and to their parts, and which of them a value means. */

import type { syntaxTree } from "@codemirror/language";
import { SENSOR_KINDS } from "../run/protocol";
import { ancestor, nameOf, type Read, type SyntaxNode, textOf } from "./tree";

/** Keys that give a name, by the list in which they stand; `name` does everywhere. */
export const GIVING: Record<string, string[]> = {
  joints: [
    ...["revolute", "prismatic", "cylindrical", "spherical", "planar", "universal", "gimbal", "bushing", "bearing"],
    ...["weld", "six_dof", "telescoping", "custom", "screw", "in_plane"],
  ],
  sensors: SENSOR_KINDS,
  targets: ["grip", "pedal", "sight", "display"],
};

/** What an arm without a name is called. */
const ARM = "arm";

/** Which parts of things the values of keys name, by the lists in which these stand. */
const PARTS: Record<string, string[]> = {
  ...each(["of", "body", "spring", "distance", "curve"], ["bodies"]),
  ...each(["joint", "angle", "velocity", "gear", "reaction", "torque", "force", "position", "outputs"], ["joints"]),
  ...each(["actuator", "input"], ["actuators"]),
  arm: ["arms"],
  camera: ["sensors"],
  on: ["arms"],
  ...each(["left", "right", "gaze"], ["targets"]),
};

/** A name, the list in which it is given, where that stands in the text, and the thing of the world that has it. */
export interface Name {
  name: string;
  key: string;
  list: string;
  from: number;
  /** Where the thing begins, and what it is called. */
  thing: { from: number; name: string };
}

type Tree = ReturnType<typeof syntaxTree>;

/** All names that a text gives. */
export function namesIn(tree: Tree, read: Read): Name[] {
  const found: Name[] = [];
  tree.iterate({
    enter: ({ name, node }) => {
      if (name === "Pair") found.push(...givenBy(node, read));
      if (name === "Item" && listOf(node, read) === "arms" && !pairOf(node, "name", read))
        found.push({ name: ARM, key: "name", list: "arms", from: node.from, thing: thingOf(node, read) });
    },
  });
  return found;
}

function givenBy(pair: SyntaxNode, read: Read): Name[] {
  const [key, name] = [nameOf(pair, read), textOf(pair, read)];
  const item = ancestor(pair.parent, "Item");
  const list = item ? listOf(item, read) : "";
  // What stands deeper in an item of a list gives none of its names.
  const own =
    item &&
    ancestor(pair.parent?.parent ?? null, "Item") === item &&
    ancestor(pair.parent, "Pair") === ancestor(item, "Pair");
  if (!item || !own || name === null || (key !== "name" && !GIVING[list]?.includes(key))) return [];
  return [{ name, key, list, from: pair.from, thing: thingOf(item, read) }];
}

/** What a value or a key of the text means: things first, and parts of those that are named beside it. */
export function meant(word: string, at: SyntaxNode, names: Name[], read: Read): Name | null {
  const around = contextOf(at, read);
  const others = names.filter(({ from }) => from !== (ancestor(at, "Pair")?.from ?? -1));
  const whole = nearest(word, others, around) ?? nearest(word.replace(/_deg$/, ""), others, around);
  if (whole) return whole;
  let found = null as Name | null;
  for (const part of word.split(/[/.]/)) {
    const from: number | null = found === null ? null : found.thing.from;
    const within: Name[] = others.filter(({ thing }) => from === null || thing.from === from);
    found = nearest(part, within, around) ?? found;
  }
  return found;
}

/** The names that may stand as the value of a key: those of parts of the thing it is in, or of those named beside it. */
export function partsFor(key: string, at: SyntaxNode, names: Name[], read: Read): string[] {
  const lists = PARTS[key];
  if (!lists) return [];
  const around = contextOf(at, read);
  const parts = names.filter(
    ({ list, ...name }) => lists.includes(list) && (key !== "camera" || name.key === "camera"),
  );
  const near = parts.filter((name) => rank(name, around) > 0);
  const own = near.length ? near : parts;
  const targets = lists.includes("targets")
    ? own.map(({ name, thing }) => `${thing.name}.${name}`)
    : own.map(({ name }) => name);
  return [...new Set(lists.includes("bodies") && own.length ? ["ground", ...targets] : targets)];
}

interface Context {
  thing: number;
  words: Set<string>;
}

/** The thing that a place of the text is in, and all words that stand beside it and around it. */
function contextOf(at: SyntaxNode, read: Read): Context {
  const words = new Set<string>();
  for (let now: SyntaxNode | null = at; now; now = now.parent) {
    if (now.name !== "Pair") continue;
    words.add(nameOf(now, read));
    const beside = now.parent?.parent?.name === "Document" ? [] : (now.parent?.getChildren("Pair") ?? []);
    for (const pair of beside) words.add(textOf(pair, read) ?? "");
  }
  return { thing: thingOf(at, read).from, words };
}

function rank({ thing }: Name, around: Context): number {
  return thing.from === around.thing || around.words.has(thing.name) ? 1 : 0;
}

function nearest(word: string, names: Name[], around: Context): Name | null {
  const same = names.filter(({ name }) => name === word);
  // Things of the world come before parts of other things.
  const order = (name: Name): number =>
    2 * rank(name, around) + (name.key === "name" && name.name === name.thing.name ? 1 : 0);
  return same.sort((a, b) => order(b) - order(a))[0] ?? null;
}

function thingOf(at: SyntaxNode, read: Read): { from: number; name: string } {
  let item: SyntaxNode | null = null;
  for (let now: SyntaxNode | null = at; now; now = now.parent) if (now.name === "Item") item = now;
  const pair = item && pairOf(item, "name", read);
  return { from: item?.from ?? -1, name: (pair && textOf(pair, read)) ?? "" };
}

/** The key of the list that an item stands in. */
function listOf(item: SyntaxNode, read: Read): string {
  const pair = ancestor(item.parent, "Pair");
  return pair ? nameOf(pair, read) : "";
}

/** The pair of a key in an item of a list. */
function pairOf(item: SyntaxNode, key: string, read: Read): SyntaxNode | null {
  const pairs = [...item.getChildren("BlockMapping"), ...item.getChildren("FlowMapping")].flatMap((map) =>
    map.getChildren("Pair"),
  );
  return pairs.find((pair) => nameOf(pair, read) === key) ?? null;
}

function each(keys: string[], lists: string[]): Record<string, string[]> {
  return Object.fromEntries(keys.map((key) => [key, lists]));
}
