/** What a run has been so far, thinned so that it always fits on a screen. */

import type { PlanarPose, RobotTick, TrackHistory } from "./protocol";

/** Most rows that are kept; then every other one goes. */
const MOST = 3000;
/** A trail goes on when the robot has moved so far [m]. */
const STRIDE = 0.02;
/** A step longer than this was not driven: the robot was put down elsewhere [m]. */
const LIFTED = 0.5;

/** Difference of two headings, in [-pi, pi). */
export function wrapped(angle: number): number {
  return angle - 2 * Math.PI * Math.floor((angle + Math.PI) / (2 * Math.PI));
}

/** Values over time; null where they are not known. */
type Column = (number | null)[];

/** A pose as it was told: what is not known of it is null in JSON, and NaN here. */
export function known(pose: PlanarPose | null[] | undefined): PlanarPose {
  const [x, y, heading] = pose ?? [];
  return [x ?? Number.NaN, y ?? Number.NaN, heading ?? Number.NaN];
}

function orNull(value: number): number | null {
  return Number.isFinite(value) ? value : null;
}

/** Rows of one robot's run, column by column. */
export class History {
  readonly time: number[] = [];
  /** Estimate minus truth: x, y [m], heading [deg]. */
  readonly errors: [Column, Column, Column] = [[], [], []];
  /** Standard deviations that the estimator claims, in the same units. */
  readonly sigmas: [Column, Column, Column] = [[], [], []];
  /** Distance of estimate and of dead reckoning from the truth [m]. */
  readonly distance: [Column, Column] = [[], []];
  readonly nees: Column = [];
  /** Whether an estimator gave the estimates; null before the first. */
  estimated: boolean | null = null;
  /** [ms] */
  readonly timing = new Map<string, Column>();
  /** Counts every change, so that who draws knows whether there is news. */
  version = 0;
  private every = 1;
  private passed = 0;

  clear(): void {
    for (const column of this.columns()) column.length = 0;
    this.timing.clear();
    this.estimated = null;
    this.every = 1;
    this.passed = 0;
    this.version += 1;
  }

  /** Note a tick; one that does not come after the last is not noted. */
  add(time: number, tick: RobotTick): void {
    if (++this.passed % this.every) return;
    this.estimated = tick.estimated;
    const variance = [tick.covariance[0], tick.covariance[4], tick.covariance[8]];
    const sigma = variance.map((each) => Math.sqrt(each ?? Number.NaN));
    this.append(time, known(tick.truth), known(tick.estimate), known(tick.odometry), sigma, tick.nees, tick.timing);
  }

  /** Begin with a whole track. */
  fill(track: TrackHistory): void {
    this.clear();
    this.estimated = track.estimated;
    const modules = Object.keys(track.timing ?? {});
    track.time.forEach((time, k) => {
      const [truth, estimate, odometry] = [known(track.truth[k]), known(track.estimate[k]), known(track.odometry[k])];
      const timing = Object.fromEntries(modules.map((name) => [name, track.timing[name]?.[k] ?? null]));
      this.append(time, truth, estimate, odometry, track.sigma?.[k] ?? [], track.nees[k] ?? null, timing);
    });
  }

  private append(
    time: number,
    truth: PlanarPose,
    estimate: PlanarPose,
    odometry: PlanarPose,
    sigma: (number | null)[],
    nees: number | null,
    timing: Record<string, number | null>,
  ): void {
    const last = this.time[this.time.length - 1];
    if (last !== undefined && time <= last) return;
    const degrees = 180 / Math.PI;
    const error = [estimate[0] - truth[0], estimate[1] - truth[1], wrapped(estimate[2] - truth[2]) * degrees];
    this.time.push(time);
    for (const k of [0, 1, 2] as const) {
      this.errors[k].push(orNull(error[k] ?? Number.NaN));
      this.sigmas[k].push(orNull((sigma[k] ?? Number.NaN) * (k === 2 ? degrees : 1)));
    }
    this.distance[0].push(orNull(Math.hypot(estimate[0] - truth[0], estimate[1] - truth[1])));
    this.distance[1].push(orNull(Math.hypot(odometry[0] - truth[0], odometry[1] - truth[1])));
    this.nees.push(nees);
    this.appendTiming(timing);
    this.version += 1;
    if (this.time.length > MOST) this.thin();
  }

  private appendTiming(timing: Record<string, number | null>): void {
    const rows = this.time.length;
    for (const name of Object.keys(timing)) {
      if (!this.timing.has(name)) this.timing.set(name, Array<null>(rows - 1).fill(null));
    }
    for (const [name, column] of this.timing) column.push(timing[name] ?? null);
  }

  private columns(): Column[] {
    return [this.time, ...this.errors, ...this.sigmas, ...this.distance, this.nees, ...this.timing.values()];
  }

  private thin(): void {
    for (const column of this.columns()) {
      const kept = column.filter((_, k) => k % 2 === 0);
      column.splice(0, column.length, ...kept);
    }
    this.every *= 2;
  }
}

/** x, y [m], and when that was [s]. */
export type TrailPoint = [x: number, y: number, time: number];

/** A path on the floor, in pieces where the robot was put down elsewhere. */
export class Trail {
  pieces: TrailPoint[][] = [];
  private count = 0;
  private stride = STRIDE;
  /** The path of which rows are shown, and how many of them. */
  private source: PlanarPose[] | null = null;
  private rows = 0;

  clear(): void {
    this.pieces = [];
    this.count = 0;
    this.stride = STRIDE;
    this.source = null;
    this.rows = 0;
  }

  /** The pieces from a time on. */
  since(time: number): TrailPoint[][] {
    const since = this.pieces.map((piece) => piece.filter((point) => point[2] >= time));
    return since.filter((piece) => piece.length > 0);
  }

  add(pose: PlanarPose, time: number): void {
    if (!Number.isFinite(pose[0] ?? Number.NaN)) return;
    const piece = this.pieces[this.pieces.length - 1];
    const last = piece?.[piece.length - 1];
    const moved = last ? Math.hypot(pose[0] - last[0], pose[1] - last[1]) : Number.POSITIVE_INFINITY;
    if (moved < this.stride) return;
    if (!piece || moved > Math.max(LIFTED, 3 * this.stride)) this.pieces.push([[pose[0], pose[1], time]]);
    else piece.push([pose[0], pose[1], time]);
    if (++this.count > MOST) this.thin();
  }

  fill(poses: PlanarPose[], times: number[]): void {
    this.clear();
    this.until(poses, times, poses.length);
    this.count = poses.length;
  }

  /** Show the first rows of a path; where it goes on, only the new ones are added. */
  until(poses: PlanarPose[], times: number[], rows: number): void {
    if (poses !== this.source || rows < this.rows) this.clear();
    const gap = poses.length > 500 ? 2 * LIFTED : LIFTED;
    for (const [k, pose] of poses.slice(this.rows, rows).entries()) {
      if (!Number.isFinite(pose[0] ?? Number.NaN)) continue;
      const piece = this.pieces[this.pieces.length - 1];
      const last = piece?.[piece.length - 1];
      if (!piece || (last && Math.hypot(pose[0] - last[0], pose[1] - last[1]) > gap)) this.pieces.push([]);
      this.pieces[this.pieces.length - 1]?.push([pose[0], pose[1], times[this.rows + k] ?? 0]);
    }
    this.source = poses;
    this.rows = rows;
  }

  private thin(): void {
    this.pieces = this.pieces.map((piece) => piece.filter((_, k) => k % 2 === 0 || k === piece.length - 1));
    this.count = this.pieces.reduce((sum, piece) => sum + piece.length, 0);
    this.stride *= 2;
  }
}
