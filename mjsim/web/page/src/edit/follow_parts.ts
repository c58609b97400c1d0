/** What goes with a new name of a part: of an arm, a sensor, or a body or joint of a mechanism. */

import type { Change, Item, Path, Values } from "../api";
import type { WorldDocument } from "../shell/document";
import { GIVING } from "../text/names";
import { type Own, ownDrivers, ownEvents, ownPlants } from "./own";

/** Texts under these keys are not names of parts. */
const OTHER = new Set(["name", "use", "signal", "controller", "color", "model"]);

/** Changes of a world that follow when the name of a part at a path is set. */
export function followingPart(path: Path, name: string, document: WorldDocument): Change[] {
  const [thing, [list, index, key, ...deeper]] = [document.itemAt(path.slice(0, 2)), path.slice(2)];
  const part = ((thing?.raw ?? thing?.values)?.[String(list)] as Values[] | undefined)?.[Number(index)];
  if (!thing?.name || thing.raw?.["repeat"] !== undefined || !part || typeof key !== "string" || deeper.length)
    return [];
  const old = part[key] ?? (list === "arms" && key === "name" ? "arm" : undefined);
  // The name of a sensor or a joint is the value of the key of its kind.
  const isName = list === "arms" || list === "bodies" ? key === "name" : GIVING[String(list)]?.includes(key);
  if (typeof old !== "string" || !isName || old.includes("${")) return [];
  if (list === "arms") return ofArm(thing, old, name, document);
  if (list === "sensors" && thing.type === "Robot") return ofSensor(thing, key, old, name, document);
  return list === "bodies" || list === "joints" ? inMechanism(thing, String(list), old, name, document) : [];
}

function ofArm(robot: Item, old: string, name: string, document: WorldDocument): Change[] {
  const { controllers = {}, ...roles } = ownDrivers(document)[String(robot.name)] ?? {};
  const loops: Change[] =
    old in (controllers as Values)
      ? [{ op: "rename", path: ["run", "drivers", String(robot.name), "controllers", old], value: name }]
      : [];
  const isIts = ([, event]: Own): boolean =>
    [event["reach"], event["release"]].includes(robot.name) && !("hand" in event) && (event["arm"] ?? "arm") === old;
  const events = ownEvents(document)
    .filter(isIts)
    .map(([place]): Change => ({ op: "set", path: [...place, "arm"], value: name }));
  const sensors = ((robot.raw ?? robot.values)["sensors"] ?? []) as Values[];
  const mounted = sensors.flatMap(({ on }, k): Change[] =>
    String(on).startsWith(`${old}/`)
      ? [{ op: "set", path: [...robot.path, "sensors", k, "on"], value: name + String(on).slice(old.length) }]
      : [],
  );
  return [...options(robot, roles, "arm", old, name), ...loops, ...events, ...mounted];
}

function ofSensor(robot: Item, kind: string, old: string, name: string, document: WorldDocument): Change[] {
  const begins = [robot.name, robot.path[1]].map((step) => `robots.${step}.sensors.${old}.`);
  const noise = ownEvents(document).flatMap(([place, event]): Change[] => {
    const found = begins.find((start) => String(event["noise"]).startsWith(start));
    const fresh = found && found.slice(0, -old.length - 1) + name + String(event["noise"]).slice(found.length - 1);
    return fresh ? [{ op: "set", path: [...place, "noise"], value: fresh }] : [];
  });
  return [...options(robot, ownDrivers(document)[String(robot.name)] ?? {}, kind, old, name), ...noise];
}

/** Options of a robot's modules with the name of a part. */
function options(robot: Item, roles: Values, key: string, old: string, name: string): Change[] {
  const named = Object.entries(roles).filter(([, module]) => (module as Values | null)?.[key] === old);
  return named.map(
    ([role]): Change => ({ op: "set", path: ["run", "drivers", String(robot.name), role, key], value: name }),
  );
}

/** Joints, constraints, actuators and sensors name bodies and joints; `BODY.END` is one of its ends, `JOINT.VALUE` a value. */
function inMechanism(
  { path, name: of, raw, values }: Item,
  list: string,
  old: string,
  name: string,
  document: WorldDocument,
): Change[] {
  const whole = raw ?? values;
  const other = ((whole[list === "bodies" ? "joints" : "bodies"] ?? []) as Values[]).flatMap((each) =>
    Object.values(each),
  );
  // Nobody knows which of two parts of one name is meant.
  if (other.includes(old)) return [];
  const isIt = (text: unknown): text is string => text === old || String(text).startsWith(`${old}.`);
  const within = ["joints", "constraints", "actuators", "sensors"].flatMap((key) => [
    ...texts(whole[key], [...path, key]),
  ]);
  const renamed = within
    .filter(([, text]) => isIt(text))
    .map(([place, text]): Change => ({ op: "set", path: place, value: name + text.slice(old.length) }));
  const events = ownEvents(document).flatMap(([place, event]): Change[] =>
    [event["lead"], event["release"]].includes(of) && list === "joints" && isIt(event["joint"])
      ? [{ op: "set", path: [...place, "joint"], value: name + event["joint"].slice(old.length) }]
      : [],
  );
  return [...renamed, ...events, ...(list === "joints" ? inPlants(String(of), old, name, document) : [])];
}

/** Plants name joints of their mechanism: as outputs, and as keys of the values about which they are made linear. */
function inPlants(mechanism: string, old: string, name: string, document: WorldDocument): Change[] {
  return ownPlants(document).flatMap(([place, plant]): Change[] => {
    if (plant["of"] !== mechanism) return [];
    const outputs = [...texts(plant["outputs"], [...place, "outputs"])].filter(([, text]) => text === old);
    const keys = Object.keys((plant["around"] ?? {}) as Values).filter((key) => key.replace(/_deg$/, "") === old);
    return [
      ...outputs.map(([path]): Change => ({ op: "set", path, value: name })),
      ...keys.map(
        (key): Change => ({ op: "rename", path: [...place, "around", key], value: name + key.slice(old.length) }),
      ),
    ];
  });
}

function* texts(value: unknown, path: Path): Generator<[Path, string]> {
  if (typeof value === "string") yield [path, value];
  else if (Array.isArray(value)) for (const [k, each] of value.entries()) yield* texts(each, [...path, k]);
  else if (typeof value === "object" && value !== null)
    for (const [key, each] of Object.entries(value)) if (!OTHER.has(key)) yield* texts(each, [...path, key]);
}
