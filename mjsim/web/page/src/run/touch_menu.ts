/** The menu of a thing on the plan of a run: what can be done with it by hand. */

import type { Item, Point, Values } from "../api";
import { direction, times } from "../plan/geometry";
import { type Entry, openMenu } from "../ui/menu";
import { type Key, word } from "../words/words";
import { releaseEvent } from "./joint_grips";
import type { Touchable } from "./touch";

/** A push of the menu [N s]. */
const PUSH = 5;
/** A door opens so far, unless it is made to open less. */
const OPEN_DEG = 90;

export interface Touched {
  /** The robot or movable thing that lies there. */
  thing: Touchable | null;
  /** What else lies there, topmost first. */
  items: Item[];
  /** Names of what is away. */
  removed: ReadonlySet<string>;
}

/** Open the menu of what lies at a place of the page [px]; nothing where nothing can be touched. */
export function openTouchMenu({ thing, items, removed }: Touched, send: (event: Values) => void, at: Point): void {
  const names = [...new Set(items.flatMap((item) => item.name ?? []))];
  const first = names.flatMap((name) => items.find((item) => item.name === name) ?? []);
  const others = first.map((item) => ({ item, entries: ofItem(item, item.name ?? "", removed, send) }));
  const there = others.filter(({ entries }) => entries.length > 0);
  const name = thing?.name ?? there[0]?.item.name;
  const groups = [...(thing ? ofThing(thing, send) : []), ...there.map(({ entries }) => entries)];
  if (name && groups.length) openMenu(name, groups, at);
}

function ofThing(thing: Touchable, send: (event: Values) => void): Entry[][] {
  const { held } = thing;
  if (held && "person" in held) {
    const { person, side } = held;
    return [[{ text: word("run.giveBack"), act: () => send({ release: person, hand: side }) }]];
  }
  if (held && "grip" in held) {
    const moved = held.facts.held ? "run.letGo" : "run.giveBackToItsSignal";
    const text = word(held.grip.of.includes("/") ? "run.giveBackToItsNavigator" : moved);
    return [[{ text, act: () => send(releaseEvent(held.grip)) }]];
  }
  if (held)
    return [
      [{ text: word("run.giveBackToItsNavigator"), act: () => send({ release: held.robot.name, arm: held.arm }) }],
    ];
  const push = (key: Key, turn: number): Entry => {
    const way = times(direction(thing.heading_deg + turn), PUSH).map((value) => Math.round(value * 1000) / 1000);
    return { text: word(key, { push: PUSH }), act: () => send({ shove: thing.name, impulse: [...way, 0] }) };
  };
  const turn = (text: string, by: number): Entry => ({
    text,
    act: () => send({ move: thing.name, to: thing.at, heading_deg: Math.round(thing.heading_deg + by) }),
  });
  return [
    [push("run.pushAhead", 0), push("run.pushBack", 180), push("run.pushLeft", 90), push("run.pushRight", -90)],
    [turn(word("run.turnLeft"), 90), turn(word("run.turnRight"), -90)],
  ];
}

function ofItem(item: Item, name: string, removed: ReadonlySet<string>, send: (event: Values) => void): Entry[] {
  const entry = (text: string, event: Values): Entry => ({ text, act: () => send(event) });
  const away = removed.has(name);
  if (!name) return [];
  if (item.kind === "opening" && item.values["door"]) {
    const far = farthest(item);
    return [
      entry(word("run.open", { name }), { open: name, angle_deg: far }),
      entry(word("run.openToTheOtherSide", { name }), { open: name, angle_deg: -far }),
      entry(word("run.shut", { name }), { close: name }),
    ];
  }
  if (item.kind === "beacon" || item.kind === "marker")
    return [
      away
        ? entry(word("run.switchOn", { name }), { restore: name })
        : entry(word("run.switchOff", { name }), { remove: name }),
    ];
  if (item.kind === "light")
    return [
      entry(word("run.switchOff", { name }), { lamp: name, brightness: 0 }),
      entry(word("run.switchOn", { name }), { lamp: name, brightness: 1 }),
    ];
  if ((item.kind === "obstacle" || item.kind === "mover") && !away)
    return [entry(word("run.takeAway", { name }), { remove: name })];
  return [];
}

function farthest(item: Item): number {
  const door = item.values["door"] as { limit_deg?: number };
  return Math.min(OPEN_DEG, door.limit_deg ?? OPEN_DEG);
}
