/** What an estimator believes, in the scene: where robots and landmarks are, and how surely; and the paths until now. */

import { DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, type Object3D } from "three";
import type { Point } from "../api";
import type { TrailPoint } from "../run/history";
import type { Shown, Trails } from "../run/overlay";
import type { LandmarkRow, PlanarPose, RobotFacts, RobotTick } from "../run/protocol";
import { decayOf, sizeOf } from "../ui/displays";
import { color } from "../ui/theme";
import { columns, ellipsoid } from "./bodies";
import { points } from "./marks";
import { ribbon } from "./ribbons";

/** So high above the floor flat things lie, and what sensors of the plane measure is drawn [m]. */
export const ABOVE_FLOOR = 0.01;
export const EYE = 0.25;
/** 95 % of a normal distribution lies within so many standard deviations: squared in the plane (chi-square, 2); of one number. */
const CHI_SQUARE_95 = 5.991;
const SIGMAS_95 = 1.96;
/** So high a body of where a robot may be stands for each radian of heading that it may be turned [m], and at least [m]. */
const METRES_A_RADIAN = 1;
const FLATTEST = 0.02;
/** Columns of where landmarks may be reach from the floor so high [m]. */
const COLUMN = 2 * EYE;
/** Of an ellipse, and of each one when there are very many. */
const CORNERS = 48;
const FEW_CORNERS = 16;
const MANY = 100;
/** Widths of paths, the lowest first, and of an outline [px]. */
const TRAILS = { odometry: 2, truth: 4.5, estimate: 2 };
const OUTLINE = 1.75;
/** Half the length of the strokes of a cross, and the least length of a stroke ahead [m]. */
const CROSS = 0.06;
const NOSE = 0.3;

/** The paths of a robot until now, as long as they stay: each a little above the one before, so that they do not mix. */
export function trailsOf(trails: Trails, shown: Shown, now: number): Object3D[] {
  if (!shown.trails) return [];
  const kinds = (Object.keys(TRAILS) as (keyof typeof TRAILS)[]).filter((kind) => shown[kind]);
  const from = now - (decayOf("trails") ?? Number.POSITIVE_INFINITY);
  return kinds.flatMap((kind, k) =>
    trails[kind]
      .since(from)
      .filter((piece) => piece.length > 1)
      .map((piece) =>
        ribbon(level(piece, (k + 2) * ABOVE_FLOOR), TRAILS[kind] * sizeOf("trails"), {
          color: color(`--${kind}`),
          through: false,
        }),
      ),
  );
}

/** Where a robot is believed to be and by its wheels, seen through everything; 95 % of where it may be, and look. */
export function poseOf(tick: RobotTick, robot: RobotFacts | undefined, shown: Shown): Object3D[] {
  const made: Object3D[] = [];
  if (robot && shown.odometry) made.push(...outline(robot, tick.odometry, color("--odometry")));
  if (!shown.estimate) return made;
  const estimate = color("--estimate");
  if (robot) made.push(...outline(robot, tick.estimate, estimate));
  if (!shown.ellipses) return made;
  const [xx, xy, , , yy, , , , turn] = tick.covariance;
  const corners = ellipse([tick.estimate[0], tick.estimate[1], xx ?? 0, xy ?? 0, yy ?? 0], CORNERS);
  if (!corners) return made;
  made.push(veil([corners], 2 * ABOVE_FLOOR, estimate), loop(corners, estimate), ...body(tick, estimate));
  return [...made, ...sector(tick.estimate, SIGMAS_95 * Math.sqrt(turn ?? 0), 3 * (robot?.radius ?? NOSE), estimate)];
}

/**
 * The three states as a body: from above it is the 95 % ellipse of the place, as high as the 95 % of the heading are wide,
 * and it leans where heading and place go together.
 */
function body({ estimate: [x, y], covariance: P }: RobotTick, rgb: string): Object3D[] {
  const at = (row: number, column: number): number => P[3 * row + column] ?? Number.NaN;
  const sigma = [0, 1, 2].map((k) => Math.sqrt(Math.max(at(k, k), 0)));
  const [u = 0, v = 0, turn = 0] = sigma;
  const half = Math.min(Math.max(SIGMAS_95 * turn * METRES_A_RADIAN, FLATTEST), Math.PI * METRES_A_RADIAN);
  const reach = [Math.sqrt(CHI_SQUARE_95) * u, Math.sqrt(CHI_SQUARE_95) * v, half];
  const related = (row: number, column: number): number =>
    sigma[row] && sigma[column] ? at(row, column) / (sigma[row] * sigma[column]) : 0;
  // It rests on the floor where it is higher than what is seen stands.
  return ellipsoid([x, y, Math.max(EYE, half)], reach, [related(0, 1), related(0, 2), related(1, 2)], rgb);
}

/** Landmarks as they are believed to be: a cross as high as sightings are drawn, and a column, for 95 % of where each may be. */
export function landmarksOf(tick: RobotTick, shown: Shown): Object3D[] {
  const rows = shown.landmarks ? Object.values(tick.landmarks).filter((row) => row.every(Number.isFinite)) : [];
  if (!rows.length) return [];
  const crosses = rows.flatMap(([x, y]) => [
    x - CROSS,
    y,
    EYE,
    x + CROSS,
    y,
    EYE,
    x,
    y - CROSS,
    EYE,
    x,
    y + CROSS,
    EYE,
  ]);
  const seen = color("--seen");
  const count = rows.length > MANY ? FEW_CORNERS : CORNERS;
  const ellipses = shown.ellipses ? rows.flatMap((row) => known(ellipse(row, count))) : [];
  const edges = ellipses.flatMap((corners) =>
    [ABOVE_FLOOR, COLUMN].flatMap((z) =>
      corners.flatMap(([x, y], k) => [x, y, z, ...(corners[(k + 1) % count] ?? [x, y]), z]),
    ),
  );
  const ink = new LineBasicMaterial({ color: seen, depthTest: false, transparent: true });
  return [new LineSegments(points([...crosses, ...edges]), ink), ...columns(ellipses, [ABOVE_FLOOR, COLUMN], seen)];
}

/** The 95 % ellipse of mean x, y [m] and covariance xx, xy, yy [m^2]; null where it is not known. */
function ellipse([x, y, xx, xy, yy]: LandmarkRow, count: number): Point[] | null {
  // The lower triangle of Cholesky turns a circle into the ellipse.
  const a = Math.sqrt(CHI_SQUARE_95 * Math.max(xx, 1e-12));
  const b = (CHI_SQUARE_95 * xy) / a;
  const c = Math.sqrt(Math.max(CHI_SQUARE_95 * yy - b * b, 0));
  if (![x, y, a, b, c].every(Number.isFinite)) return null;
  return Array.from({ length: count }, (_, k): Point => {
    const [u, v] = [Math.cos((2 * Math.PI * k) / count), Math.sin((2 * Math.PI * k) / count)];
    return [x + a * u, y + b * u + c * v];
  });
}

function known(corners: Point[] | null): Point[][] {
  return corners ? [corners] : [];
}

/** Between which headings it looks, as two rays and what lies between them. */
function sector([x, y, heading]: PlanarPose, half: number, length: number, rgb: string): Object3D[] {
  const spread = Math.min(half, Math.PI);
  if (!Number.isFinite(spread + x + y + heading)) return [];
  const arc = Array.from({ length: FEW_CORNERS + 1 }, (_, k): Point => {
    const angle = heading + spread * ((2 * k) / FEW_CORNERS - 1);
    return [x + length * Math.cos(angle), y + length * Math.sin(angle)];
  });
  const corners: Point[] = [[x, y], ...arc];
  return [veil([corners], 2 * ABOVE_FLOOR, rgb), loop(corners, rgb)];
}

/** The footprint of a robot, and a stroke to where it looks. */
function outline(robot: RobotFacts, pose: PlanarPose, rgb: string): Object3D[] {
  const [x, y, heading] = pose;
  if (!pose.every(Number.isFinite)) return [];
  const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
  const around = Array.from({ length: CORNERS }, (_, k): Point => {
    const angle = (2 * Math.PI * k) / CORNERS;
    return [robot.radius * Math.cos(angle), robot.radius * Math.sin(angle)];
  });
  const corners = (robot.outline?.length ? robot.outline : around).map(
    ([u, v]): Point => [x + cos * u - sin * v, y + sin * u + cos * v],
  );
  const ahead = Math.max(1.35 * robot.radius, NOSE);
  const nose: Point[] = [
    [x, y],
    [x + ahead * cos, y + ahead * sin],
  ];
  return [loop(corners, rgb), loop(nose, rgb)];
}

/** A closed line that is seen through everything. */
function loop(corners: Point[], rgb: string): Object3D {
  return ribbon(level([...corners, ...corners.slice(0, 1)], 2 * ABOVE_FLOOR), OUTLINE, { color: rgb, through: true });
}

/** What lies within convex outlines, as a veil that hides nothing. */
function veil(outlines: Point[][], height: number, rgb: string): Object3D {
  const triangles = outlines.flatMap((corners) =>
    corners
      .slice(2)
      .flatMap((corner, k) => [corners[0], corners[k + 1], corner].flatMap((at) => [...(at ?? [0, 0]), height])),
  );
  if (!triangles.length) return new Group();
  const material = new MeshBasicMaterial({
    color: rgb,
    transparent: true,
    opacity: 0.22,
    side: DoubleSide,
    depthTest: false,
    depthWrite: false,
  });
  return new Mesh(points(triangles), material);
}

function level(corners: (Point | TrailPoint)[], height: number): number[] {
  return corners.flatMap(([x, y]) => [x, y, height]);
}
