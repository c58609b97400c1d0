/** The form of a robot's modules, as Edit and the setup of a run show it. */

import type { Item, Values } from "../api";
import { type Child, el } from "../ui/dom";
import { icon } from "../ui/icons";
import { word } from "../words/words";
import { moduleTitle } from "./controls";
import type { ModuleShelf } from "./modules";
import { suggested } from "./offers";
import { objectRows, type Sheet } from "./rows";

/** What a run says of its drivers, with its defaults and as it is written. */
export interface RunValues {
  values: Values;
  raw: Values;
}

/** A field for each module of a robot. */
export function driverRows(sheet: Sheet, robot: Item, { values, raw }: RunValues): Child[] {
  const schema = sheet.book.definition("Modules");
  if (!schema || robot.name === null) return [];
  const subject = {
    path: pathOf(robot),
    values: driverOf(robot, values),
    raw: driverOf(robot, raw),
    fixed: false,
    within: robot.name,
  };
  return objectRows(sheet, schema, subject);
}

/** Puts in modules that fit a robot; nothing where it has some. */
export function suggestion(sheet: Sheet, shelf: ModuleShelf, robot: Item, run: RunValues, items: Item[]): Child {
  const [path, values] = [pathOf(robot), driverOf(robot, run.values)];
  const isDriven = ["observer", "estimator", "navigator"].some((role) => values[role]);
  if (!shelf.all || isDriven || robot.name === null || robot.values["base"] === "fixed") return null;
  const hasBeacons = items.some((item) => item.type === "Beacon");
  const chosen = Object.entries(suggested(robot, hasBeacons, shelf.all, sheet.book));
  const titles = chosen.flatMap(([role, value]) => (role === "avoidance" ? [] : moduleTitle(value, sheet.tools)));
  const put = (): void => sheet.change(chosen.map(([role, value]) => ({ op: "set", path: [...path, role], value })));
  const button = el(
    "button",
    { type: "button", "data-id": `${JSON.stringify(path)} suggest`, onclick: put },
    icon("plus"),
    word("panel.useWhatFits"),
  );
  return el("div", { class: "suggestion" }, button, el("span", { class: "hint" }, titles.join(", ")));
}

function pathOf({ name }: Item): string[] {
  return ["run", "drivers", name ?? ""];
}

function driverOf({ name }: Item, run: Values): Values {
  return ((run["drivers"] ?? {}) as Record<string, Values>)[name ?? ""] ?? {};
}
