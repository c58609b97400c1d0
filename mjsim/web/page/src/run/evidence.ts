/** What robots measure and what their modules show, on the plan: scans, the ring, points, lines, grids and texts. */

import { sizeOf } from "../ui/displays";
import { faded, readTokens } from "../ui/ink";
import type { Grids } from "./grids";
import type { View } from "./overlay";
import type { Sensed } from "./past";
import type { PlanarPose, RobotFacts, RobotTick, ShownNews } from "./protocol";

/** Least size of a point, and least width of a line, on the page [px]. */
const LEAST = 2.5;
const THIN = 1.5;

/** Where what is shown in a frame lies: the pose of that frame in the world. */
export function frameOf(item: ShownNews, tick: RobotTick): PlanarPose {
  if (item.frame === "world") return [0, 0, 0];
  return item.frame === "base" ? tick.truth : tick.estimate;
}

/** Draws below the robots of one moment. */
export class Evidence {
  constructor(
    private readonly context: CanvasRenderingContext2D,
    private readonly view: View,
    private readonly grids: Grids,
    /** Names of what the person does not want to see. */
    private readonly hidden: ReadonlySet<string>,
  ) {}

  /** Draw what the modules of a robot show: what is flat first. */
  shown(tick: RobotTick): void {
    const items = (tick.show ?? []).filter((item) => !this.hidden.has(item.name));
    for (const item of items) if (item.png !== undefined) this.grid(item, frameOf(item, tick));
    for (const item of items) {
      const pose = frameOf(item, tick);
      if (item.text !== undefined) this.text(item, pose);
      else if (item.lines) this.lines(item, item.lines, pose);
      else if (item.points) this.points(item.points, pose, item.color, item.size ?? 0);
    }
  }

  /** Where the beams of lidars ended. */
  scans(tick: Sensed): void {
    const { scanned } = readTokens();
    for (const points of Object.values(tick.scans ?? {})) this.points(points, [0, 0, 0], scanned, 0, sizeOf("scans"));
  }

  /** The rays of the ring that met something, from the rim. */
  ring(robot: RobotFacts, tick: Sensed): void {
    const { context } = this;
    const [x, y, heading] = tick.truth;
    const ranges = tick.proximity ?? [];
    context.strokeStyle = context.fillStyle = faded(readTokens().ranged, 0.55);
    context.lineWidth = sizeOf("ring");
    ranges.forEach((range, k) => {
      if (range === null) return;
      const angle = heading + (2 * Math.PI * k) / ranges.length;
      const rim = robot.rims[k] ?? robot.radius;
      const ends = [rim, rim + range].map((way) => this.point(x + way * Math.cos(angle), y + way * Math.sin(angle)));
      const [from, to] = ends as [[number, number], [number, number]];
      context.beginPath();
      context.moveTo(...from);
      context.lineTo(...to);
      context.stroke();
      context.beginPath();
      context.arc(...to, 2.5 * sizeOf("ring"), 0, 2 * Math.PI);
      context.fill();
    });
  }

  /** Where something touches the robot, at its rim. */
  contacts(robot: RobotFacts, tick: RobotTick): void {
    const [x, y, heading] = tick.truth;
    this.context.fillStyle = readTokens().touched;
    for (const bearing of tick.bump ?? []) {
      const turn = bearing / (2 * Math.PI);
      const rim =
        robot.rims[Math.round((turn - Math.floor(turn)) * robot.rims.length) % robot.rims.length] ?? robot.radius;
      this.context.beginPath();
      this.context.arc(
        ...this.point(x + rim * Math.cos(heading + bearing), y + rim * Math.sin(heading + bearing)),
        4 * sizeOf("contacts"),
        0,
        2 * Math.PI,
      );
      this.context.fill();
    }
  }

  private point(x: number, y: number): [number, number] {
    return [this.view.x + this.view.scale * x, this.view.y - this.view.scale * y];
  }

  private *places(numbers: number[], [x, y, heading]: PlanarPose): Generator<[number, number]> {
    const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
    for (let k = 0; k + 2 < numbers.length; k += 3) {
      const [u, v] = [numbers[k] ?? 0, numbers[k + 1] ?? 0];
      yield this.point(x + cos * u - sin * v, y + sin * u + cos * v);
    }
  }

  private points(numbers: number[], pose: PlanarPose, color: string, size: number, factor = 1): void {
    const side = factor * Math.max(size * this.view.scale, LEAST);
    this.context.fillStyle = faded(color, 0.75);
    for (const [px, py] of this.places(numbers, pose)) this.context.fillRect(px - side / 2, py - side / 2, side, side);
  }

  private lines(item: ShownNews, numbers: number[], pose: PlanarPose): void {
    const { context } = this;
    context.strokeStyle = item.color;
    context.lineWidth = Math.max((item.size ?? 0) * this.view.scale, THIN);
    context.beginPath();
    let k = 0;
    for (const place of this.places(numbers, pose)) {
      if (k === 0 || (!item.joined && k % 2 === 0)) context.moveTo(...place);
      else context.lineTo(...place);
      k += 1;
    }
    context.stroke();
  }

  private text(item: ShownNews, pose: PlanarPose): void {
    const { context } = this;
    const [place] = this.places(item.points ?? [], pose);
    if (!place) return;
    context.font = "12px system-ui, sans-serif";
    context.lineWidth = 3;
    context.strokeStyle = readTokens().paper;
    context.strokeText(item.text ?? "", ...place);
    context.fillStyle = item.color;
    context.fillText(item.text ?? "", ...place);
  }

  private grid(item: ShownNews, [x, y, heading]: PlanarPose): void {
    const picture = this.grids.of(item);
    const [u, v, turn] = item.origin ?? [0, 0, 0];
    const [columns, rows] = item.cells ?? [0, 0];
    if (!picture) return;
    const { context } = this;
    const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
    context.save();
    context.translate(...this.point(x + cos * u - sin * v, y + sin * u + cos * v));
    // The canvas has y down, as the picture has: it hangs from its upper edge.
    context.rotate(-heading - turn);
    context.scale((item.size ?? 0) * this.view.scale, (item.size ?? 0) * this.view.scale);
    context.imageSmoothingEnabled = false;
    context.drawImage(picture, 0, -rows, columns, rows);
    context.restore();
  }
}
