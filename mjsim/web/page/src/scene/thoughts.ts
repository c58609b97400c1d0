/** What robots measure and believe and what their modules show, in the scene: scans, sightings, ellipses, lines, grids. */

import {
  type BufferGeometry,
  CanvasTexture,
  DoubleSide,
  Group,
  Line,
  LineBasicMaterial,
  LineSegments,
  type Material,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  NearestFilter,
  type Object3D,
  PlaneGeometry,
  Sprite,
  SpriteMaterial,
  Vector3,
} from "three";
import { frameOf } from "../run/evidence";
import type { Grids } from "../run/grids";
import type { Shown, Trails } from "../run/overlay";
import type { Sensed, Staying } from "../run/past";
import type { PlanarPose, RobotFacts, RobotTick, ShownNews } from "../run/protocol";
import { sizeOf } from "../ui/displays";
import { color } from "../ui/theme";
import { ABOVE_FLOOR, EYE, landmarksOf, poseOf, trailsOf } from "./beliefs";
import { points } from "./marks";
import { dots, LEAST } from "./strokes";

/** One moment of a run, and what of it is to be seen. */
export interface Thoughts {
  /** [s] */
  time: number;
  robots: Record<string, RobotTick>;
  /** What does not change of them. */
  facts: RobotFacts[];
  /** Their paths until now. */
  trails: (robot: string) => Trails;
  /** What of a robot a display has that stays for some time. */
  past: (name: Staying, robot: string) => Sensed[];
  shown: Shown;
  /** Names of what the person does not want to see. */
  hidden: ReadonlySet<string>;
}

/** Height of a text [m]. */
const LETTERS = 0.15;

/** Draw a moment. */
export function thoughtsOf(thoughts: Thoughts, grids: Grids): Group {
  const group = new Group();
  for (const name of Object.keys(thoughts.robots)) group.add(...robotOf(name, thoughts, grids));
  return group;
}

function* robotOf(name: string, thoughts: Thoughts, grids: Grids): Generator<Object3D> {
  const { time, robots, facts, trails, past, shown, hidden } = thoughts;
  const tick = robots[name];
  if (!tick) return;
  const robot = facts.find((each) => each.name === name);
  yield* trailsOf(trails(name), shown, time);
  if (shown.scans) {
    const scans = past("scans", name).flatMap((each) => Object.values(each.scans ?? {}).flat());
    yield dots(lifted(scans), 0, { color: color("--scanned") }, LEAST * sizeOf("scans"));
  }
  if (shown.ring && robot)
    yield lines(
      past("ring", name).flatMap((each) => ring(each, robot)),
      "--ranged",
    );
  if (shown.sightings) yield lines(past("sightings", name).flatMap(rays), "--seen");
  yield* landmarksOf(tick, shown);
  yield* poseOf(tick, robot, shown);
  for (const item of shown.show ? (tick.show ?? []) : []) {
    const made = hidden.has(item.name) ? null : drawn(item, grids);
    if (made) yield placed(made, frameOf(item, tick));
  }
}

/** So many materials outlive their things: a program that no material uses is compiled anew, which takes longest of all. */
const KEPT = 400;

/** Give back what the graphics card holds of it; `retired` has the materials that are kept for a while. */
export function forget(group: Group, retired: Material[]): void {
  group.traverse((object) => {
    const { geometry, material } = object as Partial<Mesh>;
    // All sprites share one geometry.
    if (!(object instanceof Sprite)) geometry?.dispose();
    const map = (material as MeshBasicMaterial | undefined)?.map;
    map?.dispose();
    if (material) retired.push(material as Material);
  });
  for (const each of retired.splice(0, Math.max(retired.length - KEPT, 0))) each.dispose();
  group.clear();
}

function drawn(item: ShownNews, grids: Grids): Object3D | null {
  if (item.png !== undefined) return plate(item, grids);
  if (item.text !== undefined) return letters(item.text, item.color, item.points ?? []);
  if (item.lines) {
    const material = new LineBasicMaterial({ color: item.color });
    return item.joined ? new Line(lifted(item.lines), material) : new LineSegments(lifted(item.lines), material);
  }
  return item.points ? dots(lifted(item.points), item.size ?? 0, { color: item.color }) : null;
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

/** Rays from where the robot truly is, as long as was measured. */
function rays(tick: Sensed): number[] {
  const [x, y, heading] = tick.truth;
  return tick.sightings.flatMap(([, range, bearing]) => [
    ...[x, y, EYE],
    ...[x + range * Math.cos(heading + bearing), y + range * Math.sin(heading + bearing), EYE],
  ]);
}

function lines(ends: number[], token: string): LineSegments {
  return new LineSegments(points(ends), new LineBasicMaterial({ color: color(token) }));
}

/** The rays of the ring that met something, from the rim. */
function ring({ truth: [x, y, heading], proximity = [] }: Sensed, robot: RobotFacts): number[] {
  return proximity.flatMap((range, k) => {
    if (range === null) return [];
    const angle = heading + (2 * Math.PI * k) / proximity.length;
    const rim = robot.rims[k] ?? robot.radius;
    return [rim, rim + range].flatMap((way) => [x + way * Math.cos(angle), y + way * Math.sin(angle), EYE]);
  });
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
