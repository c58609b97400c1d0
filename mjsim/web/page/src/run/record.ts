/** What has come of a run so far: the paths and figures of each of its robots. */

import { History, Trail } from "./history";
import { LiveNumbers } from "./numbers";
import type { Trails } from "./overlay";
import type { RobotTick, TickNews, TrackHistory } from "./protocol";

export interface RobotRecord {
  history: History;
  trails: Trails;
}

export class RunRecord {
  readonly robots = new Map<string, RobotRecord>();
  /** All that the ticks had, for plots. */
  readonly numbers = new LiveNumbers();
  private last = Number.NEGATIVE_INFINITY;

  clear(): void {
    this.robots.clear();
    this.numbers.clear();
    this.last = Number.NEGATIVE_INFINITY;
  }

  of(robot: string): RobotRecord {
    const found = this.robots.get(robot);
    if (found) return found;
    const trails = { truth: new Trail(), estimate: new Trail(), odometry: new Trail() };
    const made = { history: new History(), trails };
    this.robots.set(robot, made);
    return made;
  }

  /** Note a tick; one from before the last begins anew, for then the run was restarted. */
  add(news: TickNews): void {
    if (news.time < this.last) this.clear();
    this.last = news.time;
    this.numbers.add(news);
    for (const [name, tick] of Object.entries(news.robots)) this.addTick(name, news.time, tick);
  }

  fill(tracks: Record<string, TrackHistory>): void {
    this.clear();
    for (const [name, track] of Object.entries(tracks)) {
      const { history, trails } = this.of(name);
      history.fill(track);
      trails.truth.fill(track.truth, track.time);
      trails.estimate.fill(track.estimate, track.time);
      trails.odometry.fill(track.odometry, track.time);
      this.last = Math.max(this.last, track.time[track.time.length - 1] ?? this.last);
    }
  }

  private addTick(name: string, time: number, tick: RobotTick): void {
    const { history, trails } = this.of(name);
    history.add(time, tick);
    trails.truth.add(tick.truth, time);
    trails.estimate.add(tick.estimate, time);
    trails.odometry.add(tick.odometry, time);
  }
}
