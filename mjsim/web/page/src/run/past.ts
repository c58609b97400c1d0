/** What robots sensed just now, for displays that stay for some seconds. */

import { decayOf } from "../ui/displays";
import type { RobotTick } from "./protocol";

/** Displays that stay if a person wants it; without a decay there is only what was sensed last. */
export type Staying = "scans" | "sightings" | "ring";
export const STAYING: Staying[] = ["scans", "sightings", "ring"];
/** Maximum number of points, rays and beams that are kept beside the newest; the oldest are forgotten. */
const MAX_KEPT = 50_000;

/** What these displays need of a tick. */
export type Sensed = Pick<RobotTick, "truth" | "sightings" | "scans" | "proximity">;

interface Kept {
  time: number;
  robots: Record<string, Sensed>;
  /** Number of points, rays and beams. */
  size: number;
}

/** What robots sensed at the times that were shown. */
export class Past {
  /** The newest last. */
  private kept: Kept[] = [];

  clear(): void {
    this.kept = [];
  }

  /** Note what is shown at a time; what came after that is no longer there, as somebody went back. */
  add(time: number, robots: Record<string, RobotTick>): void {
    const longest = Math.max(...STAYING.map((name) => decayOf(name) ?? 0));
    const before = this.kept.filter((each) => each.time > time - longest && each.time < time);
    before.push(...before.splice(-1).map(remaining));
    let size = 0;
    const forgotten = before.findLastIndex((each) => (size += each.size) > MAX_KEPT);
    this.kept = [...before.slice(forgotten + 1), { time, robots, size: 0 }];
  }

  /** What of a robot a display has: what was sensed within the decay, the newest first. */
  of(name: Staying, robot: string): Sensed[] {
    const newest = this.kept.at(-1);
    if (!newest?.robots[robot]) return [];
    const from = newest.time - (decayOf(name) ?? 0);
    const shown = this.kept.filter((each) => each === newest || each.time > from);
    return shown.toReversed().flatMap(({ robots }) => robots[robot] ?? []);
  }
}

/** What remains of a moment when there is a newer one: the readings of displays that stay. */
function remaining({ time, robots }: Kept): Kept {
  const stays = (name: Staying) => (decayOf(name) ?? 0) > 0;
  let size = 0;
  const kept: Record<string, Sensed> = {};
  for (const [name, tick] of Object.entries(robots)) {
    const sightings = stays("sightings") ? tick.sightings : [];
    const scans = (stays("scans") && tick.scans) || {};
    const proximity = (stays("ring") && tick.proximity) || [];
    size += sightings.length + Object.values(scans).flat().length / 3 + proximity.length;
    kept[name] = { truth: tick.truth, sightings, scans, proximity };
  }
  return { time, robots: kept, size };
}
