/** What a run begins with: its length, seed and file, and which modules drive each robot. */

import { el, fill } from "../dom";
import type { Module, Modules } from "../api";
import { choice } from "./controls";
import { meaningOf, word } from "../words/words";

/** A module and the arguments that it is made with. */
interface Use {
  use: string;
  [key: string]: unknown;
}

/** Modules that are to replace those of the world; a key that is not there stays as the world has it. */
interface Driver {
  observer?: Use | null;
  estimator?: Use | null;
  navigator?: Use | null;
  avoidance?: Use | boolean;
  [key: string]: unknown;
}

type Part = "observer" | "estimator" | "navigator" | "avoidance";

const PARTS: { part: Part; list: keyof Modules; label: string; none: string }[] = [
  { part: "observer", list: "observers", label: word("run.observer"), none: word("run.none") },
  { part: "estimator", list: "estimators", label: word("run.estimator"), none: word("run.noneDeadReckoning") },
  { part: "navigator", list: "navigators", label: word("run.navigator"), none: word("run.noneStandsStill") },
  { part: "avoidance", list: "avoidances", label: word("run.avoidance"), none: word("run.off") },
];
const OWN = "own";
const NONE = "none";
/** The avoidance that mjsim brings along. */
const BUILT_IN = "built-in";

export interface Key {
  name: string;
  default?: unknown;
  about?: string;
}

interface Pick {
  use: string;
  values: Record<string, string>;
}

/** What a world says of one robot's drivers. */
export type OwnDrivers = Record<string, Record<string, unknown>>;

export class Setup {
  readonly element = el("div", { class: "run-setup" });
  private readonly seed = el("input", { type: "number", min: 0, step: 1, "aria-label": word("run.seed") });
  private readonly seconds = el("input", { type: "number", min: 0, step: "any", "aria-label": word("run.lengthInSeconds") });
  private readonly record = el("input", { type: "checkbox" });
  private readonly file = el("input", { type: "text", "aria-label": word("run.fileToRecordTo"), spellcheck: "false" });
  private readonly robots = el("div", {});
  private readonly note = el("p", { class: "hint" }, word("run.changesTakeEffectWithThe"));
  private readonly picks = new Map<string, Pick>();
  private modules: Modules = { observers: [], estimators: [], navigators: [], avoidances: [] };
  private names: string[] = [];
  private own: OwnDrivers = {};

  constructor() {
    const field = (label: string, input: HTMLElement, unit = ""): HTMLElement =>
      el("label", { class: "run-field" }, el("span", {}, label), input, el("span", { class: "run-unit" }, unit));
    this.file.disabled = true;
    this.record.addEventListener("change", () => (this.file.disabled = !this.record.checked));
    this.element.append(
      this.note,
      el("h2", {}, word("run.run")),
      field(word("run.length"), this.seconds, "s"),
      field(word("run.seed"), this.seed),
      el("label", { class: "run-check" }, this.record, word("run.recordToAFile")),
      field(word("run.file"), this.file),
      this.robots,
    );
  }

  /** Take up a world: its robots and what it says of its run. */
  world(name: string, robots: string[], run: Record<string, unknown>): void {
    this.seed.placeholder = String(run["seed"] ?? "");
    this.seconds.placeholder = String(run["seconds"] ?? "");
    this.file.placeholder = `out/${name || "world"}/run.mcap`;
    this.own = (run["drivers"] ?? {}) as OwnDrivers;
    this.names = robots;
    this.build();
  }

  offer(modules: Modules): void {
    this.modules = modules;
    this.build();
  }

  /** What the order to start says of all this. */
  settings(): { seed?: number; seconds?: number; record?: string; drivers?: Record<string, Driver> } {
    const drivers = Object.fromEntries(
      this.names.map((name) => [name, this.driver(name)]).filter(([, driver]) => Object.keys(driver as Driver).length),
    );
    return {
      ...(this.seed.value === "" ? {} : { seed: Number(this.seed.value) }),
      ...(this.seconds.value === "" ? {} : { seconds: Number(this.seconds.value) }),
      ...(this.record.checked ? { record: this.file.value.trim() || this.file.placeholder } : {}),
      ...(Object.keys(drivers).length ? { drivers: drivers as Record<string, Driver> } : {}),
    };
  }

  private driver(robot: string): Driver {
    const driver: Record<string, unknown> = {};
    for (const { part, list } of PARTS) {
      const pick = this.picks.get(`${robot}/${part}`);
      if (!pick || pick.use === OWN) continue;
      if (pick.use === NONE) driver[part] = part === "avoidance" ? false : null;
      else if (pick.use === BUILT_IN) driver[part] = true;
      else driver[part] = useOf(pick, this.modules[list]);
    }
    return driver as Driver;
  }

  private build(): void {
    fill(
      this.robots,
      ...this.names.flatMap((name) => [el("h2", {}, name), ...PARTS.map((each) => this.row(name, each))]),
    );
  }

  private row(robot: string, { part, list, label, none }: (typeof PARTS)[number]): HTMLElement {
    const key = `${robot}/${part}`;
    const pick = this.picks.get(key) ?? { use: OWN, values: {} };
    this.picks.set(key, pick);
    const modules = this.modules[list];
    const options: [string, string][] = [
      [OWN, word("run.world", { modules: this.ownTitle(robot, part, modules) })],
      [NONE, none],
    ];
    if (part === "avoidance") options.push([BUILT_IN, word("run.builtIn")]);
    options.push(...modules.map((module): [string, string] => [module.use, module.title]));
    const keys = el("div", { class: "run-keys" });
    const select = choice({ "aria-label": word("run.partOf", { part: label, robot }), "data-part": key }, options, pick.use, (use) => {
      this.picks.set(key, { use, values: {} });
      this.showKeys(keys, key, modules);
    });
    this.showKeys(keys, key, modules);
    return el("div", {}, el("label", { class: "run-field" }, el("span", {}, label), select), keys);
  }

  private ownTitle(robot: string, part: Part, modules: Module[]): string {
    const own = this.own[robot]?.[part] as { use?: string } | boolean | null | undefined;
    if (own === true) return word("run.builtIn");
    const use = typeof own === "object" && own ? own.use : null;
    if (!use) return part === "avoidance" ? word("run.off") : word("run.none");
    return modules.find((module) => module.use === use)?.title ?? use.split(":").pop() ?? use;
  }

  private showKeys(place: HTMLElement, key: string, modules: Module[]): void {
    const pick = this.picks.get(key);
    const module = modules.find((each) => each.use === pick?.use);
    if (!pick || !module) return fill(place);
    const fields = keysOf(module).map((each) => {
      const input = el("input", {
        type: "text",
        spellcheck: "false",
        placeholder: each.default === undefined ? word("run.needed") : written(each.default),
      });
      input.value = pick.values[each.name] ?? "";
      input.addEventListener("change", () => (pick.values[each.name] = input.value.trim()));
      return el(
        "label",
        { class: "run-field", title: each.about ? meaningOf(each.about) : null },
        el("span", {}, each.name.replaceAll("_", " ")),
        input,
      );
    });
    fill(place, module.about ? el("p", { class: "hint" }, meaningOf(module.about)) : null, ...fields);
  }
}

function keysOf(module: Module): Key[] {
  return Array.isArray(module.keys) ? (module.keys as Key[]) : [];
}

function written(value: unknown): string {
  if (value === null) return "";
  return typeof value === "string" ? value : JSON.stringify(value);
}

/** The module with the arguments that were typed; numbers, lists and true or false as JSON has them. */
function useOf(pick: Pick, modules: Module[]): Use {
  const module = modules.find((each) => each.use === pick.use);
  const use: Use = { use: pick.use };
  for (const { name } of module ? keysOf(module) : []) {
    const text = pick.values[name];
    if (text) use[name] = meant(text);
  }
  return use;
}

function meant(text: string): unknown {
  try {
    return JSON.parse(text);
  } catch {
    return text;
  }
}
