/** What robots measure and believe and what their modules show, in the scene: scans, sightings, ellipses, lines, grids. */

import {
  BufferGeometry,
  CanvasTexture,
  DoubleSide,
  Group,
  Line,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  NearestFilter,
  PlaneGeometry,
  Points,
  PointsMaterial,
  Sprite,
  SpriteMaterial,
  Vector3,
  type Material,
  type Object3D,
} from "three";
import { frameOf } from "../run/evidence";
import type { Grids } from "../run/grids";
import type { Shown } from "../run/overlay";
import type { PlanarPose, RobotTick, ShownNews } from "../run/protocol";
import { color } from "../shell/theme";
import { points } from "./marks";

/** One moment of a run, and what of it is to be seen. */
export interface Thoughts {
  robots: Record<string, RobotTick>;
  shown: Shown;
  /** Names of what the person does not want to see. */
  hidden: ReadonlySet<string>;
}

/** So high above the floor flat things lie, and sightings are drawn [m]. */
const ABOVE_FLOOR = 0.01;
const EYE = 0.25;
/** Across a point at least [m]. */
const LEAST = 0.03;
/** 95 % of a normal distribution in the plane lies within so many standard deviations, squared (chi-square, 2). */
const CHI_SQUARE_95 = 5.991;
const CORNERS = 48;
/** Height of a text [m]. */
const LETTERS = 0.15;

/** Draw a moment. */
export function thoughtsOf({ robots, shown, hidden }: Thoughts, grids: Grids): Group {
  const group = new Group();
  for (const tick of Object.values(robots)) {
    if (shown.scans) for (const scan of Object.values(tick.scans ?? {})) group.add(dots(scan, color("--scanned"), 0));
    if (shown.sightings) group.add(rays(tick));
    if (shown.estimate && shown.ellipses) group.add(ellipse(tick));
    for (const item of shown.show ? (tick.show ?? []) : []) {
      const made = hidden.has(item.name) ? null : drawn(item, grids);
      if (made) group.add(placed(made, frameOf(item, tick)));
    }
  }
  return group;
}

/** Give back what the graphics card holds of it. */
export function forget(group: Group): void {
  group.traverse((object) => {
    const { geometry, material } = object as Partial<Mesh>;
    // All sprites share one geometry.
    if (!(object instanceof Sprite)) geometry?.dispose();
    const map = (material as MeshBasicMaterial | undefined)?.map;
    map?.dispose();
    (material as Material | undefined)?.dispose();
  });
  group.clear();
}

function drawn(item: ShownNews, grids: Grids): Object3D | null {
  if (item.png !== undefined) return plate(item, grids);
  if (item.text !== undefined) return letters(item.text, item.color, item.points ?? []);
  if (item.lines) {
    const material = new LineBasicMaterial({ color: item.color });
    return item.joined ? new Line(lifted(item.lines), material) : new LineSegments(lifted(item.lines), material);
  }
  return item.points ? dots(item.points, item.color, item.size ?? 0) : null;
}

function placed(object: Object3D, [x, y, heading]: PlanarPose): Object3D {
  const holder = new Group();
  holder.position.set(x, y, 0);
  holder.rotation.z = heading;
  holder.add(object);
  return holder;
}

/** Points; those on the floor a little above it, so that they are seen. */
function lifted(numbers: number[]): BufferGeometry {
  return points(numbers.map((each, k) => (k % 3 === 2 ? Math.max(each, ABOVE_FLOOR) : each)));
}

function dots(numbers: number[], rgb: string, size: number): Points {
  return new Points(lifted(numbers), new PointsMaterial({ color: rgb, size: Math.max(size, LEAST) }));
}

/** Rays from where the robot truly is, as long as was measured. */
function rays(tick: RobotTick): LineSegments {
  const [x, y, heading] = tick.truth;
  const ends = tick.sightings.flatMap(([, range, bearing]) => [
    ...[x, y, EYE],
    ...[x + range * Math.cos(heading + bearing), y + range * Math.sin(heading + bearing), EYE],
  ]);
  return new LineSegments(points(ends), new LineBasicMaterial({ color: color("--seen") }));
}

/** The 95 % ellipse of the estimate, on the floor. */
function ellipse({ estimate, covariance }: RobotTick): Line {
  const [xx, xy, yy] = [covariance[0] ?? 0, covariance[1] ?? 0, covariance[4] ?? 0];
  // The lower triangle of Cholesky turns a circle into the ellipse.
  const a = Math.sqrt(CHI_SQUARE_95 * Math.max(xx, 1e-12));
  const b = (CHI_SQUARE_95 * xy) / a;
  const c = Math.sqrt(Math.max(CHI_SQUARE_95 * yy - b * b, 0));
  const corners: number[] = [];
  for (let k = 0; k <= CORNERS; k++) {
    const [u, v] = [Math.cos((2 * Math.PI * k) / CORNERS), Math.sin((2 * Math.PI * k) / CORNERS)];
    corners.push(estimate[0] + a * u, estimate[1] + b * u + c * v, 2 * ABOVE_FLOOR);
  }
  return new Line(points(corners.every(Number.isFinite) ? corners : []), new LineBasicMaterial({ color: color("--estimate") }));
}

function plate(item: ShownNews, grids: Grids): Object3D | null {
  const picture = grids.of(item);
  if (!picture) return null;
  const [columns, rows] = item.cells ?? [0, 0];
  const [width, height] = [columns * (item.size ?? 0), rows * (item.size ?? 0)];
  const map = new CanvasTexture(picture);
  map.magFilter = map.minFilter = NearestFilter;
  map.generateMipmaps = false;
  const material = new MeshBasicMaterial({ map, transparent: true, side: DoubleSide, depthWrite: false });
  const mesh = new Mesh(new PlaneGeometry(width, height).translate(width / 2, height / 2, ABOVE_FLOOR / 2), material);
  const [x, y, heading] = item.origin ?? [0, 0, 0];
  mesh.applyMatrix4(new Matrix4().makeRotationZ(heading).setPosition(new Vector3(x, y, 0)));
  return mesh;
}

function letters(text: string, rgb: string, [x = 0, y = 0, z = 0]: number[]): Sprite {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d");
  const font = "48px system-ui, sans-serif";
  if (context) context.font = font;
  canvas.width = Math.min(2048, Math.ceil(context?.measureText(text).width ?? 0) + 8);
  canvas.height = 60;
  if (context) {
    context.font = font;
    context.fillStyle = rgb;
    context.fillText(text, 4, 46);
  }
  const sprite = new Sprite(new SpriteMaterial({ map: new CanvasTexture(canvas), depthTest: false }));
  sprite.position.set(x, y, z + LETTERS);
  sprite.scale.set((LETTERS * canvas.width) / canvas.height, LETTERS, 1);
  return sprite;
}
