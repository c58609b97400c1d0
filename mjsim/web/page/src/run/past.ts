/** What robots sensed just now, for displays that stay for some seconds. */

import { decayOf } from "../ui/displays";
import type { RobotTick } from "./protocol";

/** Displays that stay if a person wants it; without a decay there is only what was sensed last. */
export type Staying = "scans" | "sightings" | "ring";
export const STAYING: Staying[] = ["scans", "sightings", "ring"];
/** So many points, rays and beams are kept for a display of a robot, the newest first. */
const MOST = 50_000;

/** Ticks of robots as they were shown, the newest last. */
export class Past {
  private kept: { time: number; robots: Record<string, RobotTick> }[] = [];

  clear(): void {
    this.kept = [];
  }

  /** Note what is shown at a time; what came after that is no longer there, as somebody went back. */
  add(time: number, robots: Record<string, RobotTick>): void {
    const longest = Math.max(...STAYING.map((name) => decayOf(name) ?? 0));
    this.kept = this.kept.filter((each) => each.time > time - longest && each.time < time);
    this.kept.push({ time, robots });
  }

  /** What of a robot a display has: its ticks within the decay, the newest first. */
  of(name: Staying, robot: string): RobotTick[] {
    const [newest, ...before] = this.kept.toReversed();
    const last = newest?.robots[robot];
    if (!newest || !last) return [];
    const found = [last];
    let count = countOf(name, last);
    for (const { time, robots } of before) {
      const tick = robots[robot];
      if (time <= newest.time - (decayOf(name) ?? 0) || count > MOST) break;
      if (!tick) continue;
      found.push(tick);
      count += countOf(name, tick);
    }
    return found;
  }
}

function countOf(name: Staying, tick: RobotTick): number {
  if (name === "sightings") return tick.sightings.length;
  if (name === "ring") return tick.proximity?.length ?? 0;
  return Object.values(tick.scans ?? {}).reduce((sum, numbers) => sum + numbers.length / 3, 0);
}
