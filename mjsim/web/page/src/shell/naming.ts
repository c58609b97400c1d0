/** What a step of undo is called, from the changes that it made. */

import type { Change, Item, Path, Values } from "../api";
import { type Key, word } from "../words/words";

/** Keys of an item and what changing them does; of several, the first one tells. */
const VERBS: [Key, string[]][] = [
  ["step.rename", ["name"]],
  ["step.resize", ["box", "cylinder", "sphere", "ramp", "steps", "size", "width"]],
  ["step.turn", ["heading_deg"]],
  ["step.move", ["at", "points", "path", "route"]],
  ["step.group", ["group"]],
  ["step.pose", ["start", "start_deg", "joints_deg", "targets"]],
];

/** The innermost item at or around a path; null when it belongs to none. */
type ItemAt = (path: Path) => Item | null;

/** What changes do, in two or three words: "Move crate", "Delete 3 things", "Set floor.friction". */
export function named(changes: Change[], itemAt: ItemAt): string {
  const [first] = changes;
  if (!first) return word("step.change");
  // What goes along with these, such as the driver of a robot, is not told.
  if (first.op === "add" || first.op === "rename")
    return withThings(
      first.op === "add" ? "step.add" : "step.rename",
      changes.filter(({ op }) => op === first.op).map(newName),
    );
  const removed = changes.filter(({ op, path }) => op === "remove" && typeof path.at(-1) === "number");
  // Events that go along with things are not told.
  const ofThings = removed.filter(({ path }) => itemAt(path));
  const deleted = ofThings.length ? ofThings : removed;
  if (deleted.length)
    return withThings(
      "step.delete",
      deleted.map(({ path }) => itemAt(path)?.label ?? shown(path)),
    );
  if (first.op === "single" || first.op === "apart")
    return withThings(
      "step.single",
      changes.map(({ path }) => itemAt(path)?.label ?? shown(path)),
    );
  const things = [...new Set(changes.map(({ path }) => itemAt(path)?.label ?? ""))];
  if (things[0] === "") return word(first.op === "set" ? "step.set" : "step.reset", { key: shown(first.path) });
  const keys = changes.map(({ path }) => String(path[itemAt(path)?.path.length ?? 0]));
  const [verb] = VERBS.find(([, of]) => keys.some((key) => of.includes(key))) ?? [];
  if (verb === "step.group" && first.op === "unset") return withThings("step.ungroup", things);
  if (verb === "step.rename") return word(verb, { things: things[0] });
  if (verb) return withThings(verb, things);
  const key = new Set(keys).size === 1 ? keys[0] : word("step.fields");
  return withThings(first.op === "set" ? "step.setOf" : "step.resetOf", things, { key });
}

function withThings(verb: Key, things: string[], values: { key?: string | undefined } = {}): string {
  const named = things.length === 1 ? things[0] : word("step.things", { count: things.length });
  return word(verb, { ...values, things: named });
}

/** What an item that is added will be called: by its name, else by its shape or its list. */
function newName({ path, ...change }: Change): string {
  const value = "value" in change ? change.value : null;
  const keys: Values = typeof value === "object" ? { ...value } : { name: value };
  if (typeof keys["name"] === "string") return keys["name"];
  const list = String(path.findLast((step) => typeof step === "string"));
  if (list === "obstacles") return Object.keys(keys)[0] ?? "obstacle";
  return { people: "person", patches: "patch" }[list] ?? list.replace(/s$/, "");
}

function shown(path: Path): string {
  return path.join(".");
}
