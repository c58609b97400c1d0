/** Every number of a run since the page watches it, thinned so that memory stays as it is. */

import { titleOf } from "../charts/layouts";
import type { Column, Field, Message, Source, Topic } from "../charts/plotter";
import type { TickNews } from "./protocol";

type Values = (number | null)[];

/** Most rows that are kept; then every other one goes. And most numbers: of more the first ones. */
const MOST_ROWS = 3000;
const MOST_FIELDS = 600;
/** Longer lists are pictures of something. */
const LONGEST = 64;
/** What is drawn on the plan and changes its places from tick to tick. */
const LEFT_OUT = new Set(["show", "scans", "sightings", "recognised", "bump"]);
/** What the entries of some lists are. */
const PARTS: Record<string, string[]> = {
  truth: ["x", "y", "heading"],
  estimate: ["x", "y", "heading"],
  odometry: ["x", "y", "heading"],
  command: ["forward", "left", "turn"],
};
/** Units of the numbers of a robot, of joints, and of the run. */
const PLACE = { x: "m", y: "m", heading: "rad" };
const UNITS: Record<string, string> = {
  ...Object.fromEntries(
    ["truth", "estimate", "odometry"].flatMap((pose) =>
      Object.entries(PLACE).map(([key, unit]) => [`${pose}.${key}`, unit]),
    ),
  ),
  "command.forward": "m/s",
  "command.left": "m/s",
  "command.turn": "rad/s",
  error: "m",
  heading_error: "rad",
  proximity: "m",
  timing: "ms",
  bump: "rad",
  time: "s",
};
const TYPES: [RegExp, Topic][] = [
  [/^\/run$/, { type: "mjsim.Run", about: "", units: UNITS }],
  [/^\/things$/, { type: "mjsim.Things", about: "", units: {} }],
  [/\/joints$/, { type: "mjsim.Joints", about: "", units: {} }],
  [/./, { type: "mjsim.RobotTick", about: "", units: UNITS }],
];
const JOINT = ["position", "velocity", "torque"];
const POSE = ["x", "y", "heading"];

export class LiveNumbers implements Source {
  private time: number[] = [];
  private readonly columns = new Map<string, { field: Field; values: Values }>();
  private every = 1;
  private passed = 0;
  private newest: TickNews | null = null;

  clear(): void {
    this.time = [];
    this.columns.clear();
    this.every = 1;
    this.passed = 0;
    this.newest = null;
  }

  /** Note a tick; one that does not come after the last is not noted. */
  add(news: TickNews): void {
    this.newest = news;
    if (this.passed++ % this.every || news.time <= (this.time[this.time.length - 1] ?? Number.NEGATIVE_INFINITY))
      return;
    const row = this.time.push(news.time) - 1;
    for (const [topic, name, value] of numbersOf(news)) {
      const values = this.valuesOf([topic, name]);
      if (!values) continue;
      while (values.length < row) values.push(null);
      values.push(value);
    }
    if (this.time.length > MOST_ROWS) this.thin();
  }

  fields(): ReturnType<Source["fields"]> {
    const fields = [...this.columns.values()].map(({ field }) => field);
    const topics = Object.fromEntries(fields.map(([topic]) => [topic, TYPES.find(([name]) => name.test(topic))?.[1]]));
    return Promise.resolve({ fields, topics: topics as Record<string, Topic> });
  }

  message(topic: string): Promise<Message | null> {
    const { newest } = this;
    return Promise.resolve(newest && { time: newest.time, content: contentOf(newest, topic) });
  }

  column(field: Field): Promise<Column> {
    const values = [...(this.columns.get(titleOf(field))?.values ?? [])];
    while (values.length < this.time.length) values.push(null);
    return Promise.resolve({ time: [...this.time], values });
  }

  private valuesOf(field: Field): Values | null {
    const found = this.columns.get(titleOf(field));
    if (found) return found.values;
    if (this.columns.size >= MOST_FIELDS) return null;
    const values: Values = [];
    this.columns.set(titleOf(field), { field, values });
    return values;
  }

  private thin(): void {
    const even = <T>(rows: T[]): T[] => rows.filter((_, k) => k % 2 === 0);
    this.time = even(this.time);
    for (const column of this.columns.values()) column.values = even(column.values);
    this.every *= 2;
  }
}

/** What a tick has of a topic. */
function contentOf({ robots, things, joints, time, pace }: TickNews, topic: string): unknown {
  if (topic === "/run") return { time, pace };
  if (topic === "/things") return things;
  const key = topic.slice(1).replace(/\/joints$/, "");
  return topic.endsWith("/joints") ? joints?.[key] : robots[key];
}

/** Topic, name and value of each number of a tick. */
function* numbersOf(news: TickNews): Generator<[topic: string, name: string, value: number | null]> {
  yield ["/run", "pace", news.pace];
  for (const [robot, tick] of Object.entries(news.robots))
    for (const [key, value] of Object.entries(tick))
      if (!LEFT_OUT.has(key))
        for (const [name, number] of leaves(key, value, PARTS[key])) yield [`/${robot}`, name, number];
  for (const [key, joints] of Object.entries(news.joints ?? {}))
    for (const [joint, row] of Object.entries(joints))
      for (const [k, value] of row.entries()) yield [`/${key}/joints`, `${joint}.${JOINT[k] ?? k}`, value];
  for (const [thing, pose] of Object.entries(news.things))
    for (const [name, number] of leaves(thing, pose, POSE)) yield ["/things", name, number];
}

function* leaves(name: string, value: unknown, parts?: string[]): Generator<[name: string, value: number | null]> {
  if (typeof value === "number" || value === null) yield [name, value];
  else if (Array.isArray(value)) {
    if (value.length > LONGEST) return;
    for (const [k, each] of value.entries()) yield* leaves(parts ? `${name}.${parts[k] ?? k}` : `${name}[${k}]`, each);
  } else if (typeof value === "object")
    for (const [key, each] of Object.entries(value as object)) yield* leaves(`${name}.${key}`, each);
}
