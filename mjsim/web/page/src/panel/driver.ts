/** The form of a robot's modules, as Edit and the setup of a run show it. */

import type { Item, Values } from "../api";
import { sign } from "../ui/icons";
import { html, type View } from "../ui/view";
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
export function driverRows(sheet: Sheet, robot: Item, { values, raw }: RunValues): View {
  const schema = sheet.book.definition("Modules");
  if (!schema || robot.name === null) return null;
  const [own, written] = [driverOf(robot, values), driverOf(robot, raw)];
  return objectRows(sheet, schema, {
    path: pathOf(robot),
    values: own,
    raw: written,
    fixed: false,
    within: robot.name,
  });
}

/** Puts in modules that fit a robot; nothing where it has some. */
export function suggestion(sheet: Sheet, shelf: ModuleShelf, robot: Item, run: RunValues, items: Item[]): View {
  const [path, values] = [pathOf(robot), driverOf(robot, run.values)];
  const isDriven = ["observer", "estimator", "navigator"].some((role) => values[role]);
  if (!shelf.all || isDriven || robot.name === null || robot.values["base"] === "fixed") return null;
  const hasBeacons = items.some((item) => item.type === "Beacon");
  const chosen = Object.entries(suggested(robot, hasBeacons, shelf.all, sheet.book));
  const titles = chosen.flatMap(([role, value]) => (role === "avoidance" ? [] : moduleTitle(value, sheet.tools)));
  const put = (): void => sheet.change(chosen.map(([role, value]) => ({ op: "set", path: [...path, role], value })));
  return html`<div class="suggestion"><button type="button" @click=${put}>${sign("plus")}${word("panel.useWhatFits")}</button>
    <span class="hint">${titles.join(", ")}</span></div>`;
}

function pathOf({ name }: Item): string[] {
  return ["run", "drivers", name ?? ""];
}

function driverOf({ name }: Item, run: Values): Values {
  return ((run["drivers"] ?? {}) as Record<string, Values>)[name ?? ""] ?? {};
}
