/** What is selected, marked in the scene: its outline from the plan, as high as it is. */

import {
  BufferGeometry,
  DoubleSide,
  Float32BufferAttribute,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  type Object3D,
  Vector3,
} from "three";
import type { Bounds, Item, Point } from "../api";
import { heightOf } from "../edit/lift";
import { boundsOf, distanceTo } from "../plan/geometry";
import { color } from "../ui/theme";
import { thingsOf } from "./solids";

/** What lies so near to an outline belongs to it [m]. */
const NEAR = 0.02;
/** How far a mark stands off what it marks [m]. */
const OFF = 0.01;
/** So many are marked. */
const MOST = 100;

/** An item as a drag has it meanwhile. */
export type AsDragged = (item: Item) => Item;

/** The item that a point of a geom belongs to; null for the floor and what the plan does not show. */
export function itemAt(items: Item[], thing: string, at: Vector3): Item | null {
  const named = items.filter((item) => isOf(thing, item));
  if (named.length) return smallest(named);
  if (thing === "floor") return null;
  const place: Point = [at.x, at.y];
  const close = items.filter((item) => isNear(item, place));
  const kind = thing.split("/")[0];
  const alike = close.filter((item) => item.kind === kind);
  return smallest(alike.length ? alike : close);
}

/** Whether a geom of this name is a part of an item. */
export function isOf(thing: string, item: Item): boolean {
  const [kind = "", rest = ""] = thing.replace(/^floor\/(seen:)?/, "patch/").split(/[/](.*)/s);
  if (item.kind === "robot" || item.kind === "person") return item.name === kind;
  const own = rest.split(/[/:]/)[0];
  const called = item.name ?? String(item.path.at(-1));
  return kind === item.kind && own === called;
}

/** How marks are drawn: shared by all of them, as a program that no material uses is compiled anew. */
export class MarkInk {
  readonly edges = new LineBasicMaterial({ depthTest: false });
  readonly veil = new MeshBasicMaterial({ transparent: true, opacity: 0.3, side: DoubleSide, depthWrite: false });

  constructor() {
    this.recolor();
  }

  recolor(): void {
    for (const each of [this.edges, this.veil]) each.color.set(color("--accent"));
  }
}

/** Mark items in a scene, the first ones of very many, where a drag has them meanwhile. */
export function markOf(items: Item[], root: Object3D, asDragged: AsDragged, ink: MarkInk): Group {
  const group = new Group();
  for (const item of items.slice(0, MOST)) {
    const [low, high] = heights(item, root);
    const now = asDragged(item);
    const rise = heightOf(now) - heightOf(item);
    for (const polygon of now.polygons)
      if (polygon.length > 1) group.add(...prism(polygon, low + rise - OFF, high + rise + OFF, ink));
  }
  return group;
}

/** From where to where an item reaches [m]: by its own triangles, or by those that stand on its outline. */
export function heights(item: Item, root: Object3D): [number, number] {
  const own: number[] = [];
  const around: number[] = [];
  const box = boundsOf(item.polygons.flat());
  root.updateMatrixWorld();
  root.traverse((object) => {
    if (!(object instanceof Mesh)) return;
    let first = 0;
    for (const [thing, count] of thingsOf(object)) {
      const mine = isOf(thing, item);
      for (const at of mine || thing.startsWith(`${item.kind}/`) ? corners(object, first, count) : [])
        if (mine) own.push(at.z);
        else if (within(at, box) && isNear(item, [at.x, at.y])) around.push(at.z);
      first += count;
    }
  });
  const found = own.length ? own : around;
  return found.reduce<[number, number]>(
    ([low, high], z) => [Math.min(low, z), Math.max(high, z)],
    [found[0] ?? 0, found[0] ?? 0],
  );
}

/** The corners of triangles of a mesh, in the world; one vector is used for all. */
function* corners(mesh: Mesh, first: number, count: number): Generator<Vector3> {
  const geometry = mesh.geometry as BufferGeometry;
  const [places, indices] = [geometry.getAttribute("position"), geometry.getIndex()];
  const at = new Vector3();
  for (let k = 3 * first; indices && k < 3 * (first + count); k++)
    yield at.fromBufferAttribute(places, indices.getX(k)).applyMatrix4(mesh.matrixWorld);
}

function within({ x, y }: Vector3, [x0, y0, x1, y1]: Bounds): boolean {
  return x > x0 - NEAR && x < x1 + NEAR && y > y0 - NEAR && y < y1 + NEAR;
}

function isNear(item: Item, at: Point): boolean {
  return item.polygons.some((polygon) => distanceTo(at, polygon) < NEAR);
}

function smallest(items: Item[]): Item | null {
  const size = (item: Item): number => item.polygons.reduce((sum, polygon) => sum + Math.abs(areaOf(polygon)), 0);
  return [...items].sort((a, b) => size(a) - size(b))[0] ?? null;
}

function areaOf(polygon: Point[]): number {
  return polygon.reduce((sum, [x, y], k) => {
    const [u, v] = polygon[(k + 1) % polygon.length] ?? [x, y];
    return sum + 0.5 * (x * v - u * y);
  }, 0);
}

/** The sides of an upright prism as a veil, and its edges, which are seen through everything. */
function prism(polygon: Point[], low: number, high: number, ink: MarkInk): Object3D[] {
  const lines: number[] = [];
  const sides: number[] = [];
  polygon.forEach(([x, y], k) => {
    const [u, v] = polygon[(k + 1) % polygon.length] ?? [x, y];
    lines.push(x, y, low, u, v, low, x, y, high, u, v, high, x, y, low, x, y, high);
    sides.push(x, y, low, u, v, low, u, v, high, x, y, low, u, v, high, x, y, high);
  });
  const edges = new LineSegments(points(lines), ink.edges);
  edges.renderOrder = 2;
  return [new Mesh(points(sides), ink.veil), edges];
}

/** Take all marks out of a group, and give back what the graphics card holds of their shapes. */
export function clearMarks(group: Group): void {
  group.traverse((part) => (part as Partial<Mesh>).geometry?.dispose());
  group.clear();
}

export function points(numbers: number[]): BufferGeometry {
  return new BufferGeometry().setAttribute("position", new Float32BufferAttribute(numbers, 3));
}
