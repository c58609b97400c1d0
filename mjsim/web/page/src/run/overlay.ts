/** What moves on the plan: robots, paths, ellipses, sightings; drawn in world metres on a plain canvas. */

import { decayOf, sizeOf } from "../ui/displays";
import { faded, readTokens } from "../ui/ink";
import type { Trail, TrailPoint } from "./history";
import type { Sensed } from "./past";
import type { LandmarkRow, PlanarPose, RobotFacts, RobotTick } from "./protocol";

/** Where the world is on the canvas: px = x + scale * east, py = y - scale * north. */
export interface View {
  x: number;
  y: number;
  scale: number;
}

/** What is shown of a run. */
export interface Shown {
  truth: boolean;
  estimate: boolean;
  odometry: boolean;
  trails: boolean;
  ellipses: boolean;
  landmarks: boolean;
  sightings: boolean;
  scans: boolean;
  ring: boolean;
  contacts: boolean;
  /** What modules show. */
  show: boolean;
}

export interface Trails {
  truth: Trail;
  estimate: Trail;
  odometry: Trail;
}

/** 95 % of a normal distribution in the plane lies within so many standard deviations, squared (chi-square, 2). */
const CHI_SQUARE_95 = 5.991;

/** Draws one moment of a run. */
export class Overlay {
  private readonly colors = readTokens();

  constructor(
    private readonly context: CanvasRenderingContext2D,
    private readonly view: View,
    private readonly shown: Shown,
    /** Names that the plan has written beside beacons. */
    private readonly written: ReadonlySet<string>,
  ) {
    context.lineJoin = "round";
    context.lineCap = "round";
  }

  /** Draw paths below everything else, as long as they stay until now. */
  trails(trails: Trails, now: number): void {
    if (!this.shown.trails) return;
    const { truth, estimate, odometry } = this.colors;
    const from = now - (decayOf("trails") ?? Number.POSITIVE_INFINITY);
    if (this.shown.odometry) this.trail(trails.odometry.since(from), odometry, 1.5);
    if (this.shown.truth) this.trail(trails.truth.since(from), faded(truth, 0.55), 4.5);
    if (this.shown.estimate) this.trail(trails.estimate.since(from), estimate, 1.5);
  }

  robot(robot: RobotFacts, tick: RobotTick, { named }: { named: boolean }): void {
    const { truth, estimate, odometry, seen } = this.colors;
    if (this.shown.landmarks) {
      for (const [name, landmark] of Object.entries(tick.landmarks)) this.landmark(name, landmark, seen);
    }
    if (this.shown.odometry) this.outline(robot, tick.odometry, odometry, 1.75 * sizeOf("odometry"), [4, 3]);
    if (this.shown.truth) this.body(robot, tick.truth, truth);
    if (this.shown.estimate) {
      const [cxx, cxy, , , cyy] = tick.covariance;
      if (this.shown.ellipses) this.ellipse(tick.estimate, [cxx ?? 0, cxy ?? 0, cyy ?? 0], estimate);
      this.outline(robot, tick.estimate, estimate, 1.75 * sizeOf("estimate"), []);
    }
    if (named) {
      const [px, py] = this.point(tick.truth[0], tick.truth[1]);
      this.letters(robot.name, px + robot.radius * this.view.scale + 6, py + 4);
    }
  }

  /** The links of an arm as they truly are, from above. */
  arm(links: [number, number][][]): void {
    this.context.lineWidth = 1.25;
    for (const link of links) {
      this.context.beginPath();
      for (const [x, y] of link) this.context.lineTo(...this.point(x, y));
      this.context.closePath();
      this.context.fillStyle = faded(this.colors.truth, 0.35);
      this.context.strokeStyle = this.colors.truth;
      this.context.fill();
      this.context.stroke();
    }
  }

  private point(x: number, y: number): [number, number] {
    return [this.view.x + this.view.scale * x, this.view.y - this.view.scale * y];
  }

  private trail(pieces: TrailPoint[][], color: string, width: number): void {
    this.context.strokeStyle = color;
    this.context.lineWidth = width * sizeOf("trails");
    this.context.beginPath();
    for (const piece of pieces) {
      piece.forEach(([x, y], k) => {
        const [px, py] = this.point(x, y);
        if (k) this.context.lineTo(px, py);
        else this.context.moveTo(px, py);
      });
    }
    this.context.stroke();
  }

  /** Trace a robot's footprint; at least so large that it can be seen. */
  private trace(robot: RobotFacts, pose: PlanarPose): void {
    const least = 5 / this.view.scale;
    this.context.beginPath();
    if (robot.outline?.length && robot.radius > least) {
      const [cos, sin] = [Math.cos(pose[2]), Math.sin(pose[2])];
      for (const [x, y] of robot.outline) {
        this.context.lineTo(...this.point(pose[0] + cos * x - sin * y, pose[1] + sin * x + cos * y));
      }
      this.context.closePath();
      return;
    }
    const [px, py] = this.point(pose[0], pose[1]);
    this.context.arc(px, py, Math.max(robot.radius, least) * this.view.scale, 0, 2 * Math.PI);
  }

  private body(robot: RobotFacts, pose: PlanarPose, color: string): void {
    if (!isKnown(pose)) return;
    this.trace(robot, pose);
    this.context.fillStyle = faded(color, 0.3);
    this.context.fill();
    this.context.strokeStyle = color;
    this.context.lineWidth = 3.5 * sizeOf("truth");
    this.context.stroke();
    this.nose(robot, pose, color, 4 * sizeOf("truth"));
  }

  private outline(robot: RobotFacts, pose: PlanarPose, color: string, width: number, dashes: number[]): void {
    if (!isKnown(pose)) return;
    this.trace(robot, pose);
    this.context.strokeStyle = color;
    this.context.lineWidth = width;
    this.context.setLineDash(dashes);
    this.context.stroke();
    this.context.setLineDash([]);
    this.nose(robot, pose, color, width);
  }

  /** A stroke from the middle to where the robot looks. */
  private nose(robot: RobotFacts, pose: PlanarPose, color: string, width: number): void {
    const length = Math.max(robot.radius * 1.35, 8 / this.view.scale);
    this.context.strokeStyle = color;
    this.context.lineWidth = width;
    this.context.beginPath();
    this.context.moveTo(...this.point(pose[0], pose[1]));
    this.context.lineTo(...this.point(pose[0] + length * Math.cos(pose[2]), pose[1] + length * Math.sin(pose[2])));
    this.context.stroke();
  }

  /** The 95 % ellipse of a mean and a covariance (xx, xy, yy) [m^2]. */
  private ellipse(mean: ArrayLike<number>, [xx, xy, yy]: [number, number, number], color: string): void {
    const [x, y] = [mean[0] ?? Number.NaN, mean[1] ?? Number.NaN];
    const middle = (xx + yy) / 2;
    const half = Math.hypot((xx - yy) / 2, xy);
    if (![x, y, middle, half].every(Number.isFinite) || middle + half <= 0) return;
    const long = Math.sqrt(CHI_SQUARE_95 * (middle + half)) * this.view.scale;
    const short = Math.sqrt(CHI_SQUARE_95 * Math.max(middle - half, 0)) * this.view.scale;
    const [px, py] = this.point(x, y);
    this.context.beginPath();
    // The canvas has y down, so that the angle turns the other way.
    this.context.ellipse(
      px,
      py,
      Math.max(long, 1),
      Math.max(short, 1),
      -Math.atan2(2 * xy, xx - yy) / 2,
      0,
      2 * Math.PI,
    );
    this.context.fillStyle = faded(color, 0.12);
    this.context.fill();
    this.context.strokeStyle = color;
    this.context.lineWidth = 1.25 * sizeOf("ellipses");
    this.context.stroke();
  }

  private landmark(name: string, [x, y, cxx, cxy, cyy]: LandmarkRow, color: string): void {
    if (this.shown.ellipses) this.ellipse([x, y], [cxx, cxy, cyy], color);
    const [px, py] = this.point(x, y);
    const arm = 4 * sizeOf("landmarks");
    this.context.strokeStyle = color;
    this.context.lineWidth = 1.75;
    this.context.beginPath();
    this.context.moveTo(px - arm, py - arm);
    this.context.lineTo(px + arm, py + arm);
    this.context.moveTo(px - arm, py + arm);
    this.context.lineTo(px + arm, py - arm);
    this.context.stroke();
    if (this.view.scale > 70 && !this.written.has(name)) this.letters(name, px + 7, py - 7);
  }

  private letters(text: string, x: number, y: number): void {
    this.context.font = "11px system-ui, sans-serif";
    this.context.lineWidth = 3;
    this.context.strokeStyle = this.colors.paper;
    this.context.strokeText(text, x, y);
    this.context.fillStyle = this.colors.ink;
    this.context.fillText(text, x, y);
  }

  /** Rays from where the robot truly is, as long as was measured: they end beside what was seen. */
  sightings(tick: Sensed): void {
    const [x, y, heading] = tick.truth;
    this.context.strokeStyle = faded(this.colors.seen, 0.75);
    this.context.lineWidth = 1.25 * sizeOf("sightings");
    this.context.beginPath();
    for (const [, range, bearing] of tick.sightings) {
      this.context.moveTo(...this.point(x, y));
      this.context.lineTo(
        ...this.point(x + range * Math.cos(heading + bearing), y + range * Math.sin(heading + bearing)),
      );
    }
    this.context.stroke();
  }
}

/** What a module does not say is null in a message. */
function isKnown(pose: PlanarPose): boolean {
  return pose.every((each) => Number.isFinite(each ?? Number.NaN));
}
