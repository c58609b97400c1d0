/** Bodies of what is believed: they are shaded, seen through everything, and hide nothing. */

import {
  BufferGeometry,
  Float32BufferAttribute,
  Matrix4,
  Mesh,
  MeshLambertMaterial,
  type Object3D,
  SphereGeometry,
} from "three";
import type { Point } from "../api";

/** Parts of a ball around and from pole to pole. */
const AROUND = 32;
const DOWN = 20;
/** How much of what is behind a body is hidden. */
const OPACITY = 0.4;
/** Thinner, or leaning more, a body would have no sides to be shaded [m]. */
const THINNEST = 1e-3;

/**
 * The ellipsoid of three numbers that go together.
 *
 * `middle` [m]; `reach`: how far it reaches to each side along x, y, z [m]; `related`: correlations of x and y, x and z,
 * y and z. Nothing where one of them is not known.
 */
export function ellipsoid(middle: number[], reach: number[], related: number[], rgb: string): Object3D[] {
  const [a = 0, b = 0, c = 0] = reach.map((each) => Math.max(each, THINNEST));
  const [xy = 0, xz = 0, yz = 0] = related;
  // The lower triangle of Cholesky turns a ball into the ellipsoid.
  const across = Math.sqrt(Math.max(1 - xy * xy, THINNEST));
  const leaning = (yz - xy * xz) / across;
  const up = Math.sqrt(Math.max(1 - xz * xz - leaning * leaning, THINNEST));
  const [x = 0, y = 0, z = 0] = middle;
  const shape = [a, 0, 0, x, b * xy, b * across, 0, y, c * xz, c * leaning, c * up, z] as const;
  if (!shape.every(Number.isFinite)) return [];
  const made = new SphereGeometry(1, AROUND, DOWN).rotateX(Math.PI / 2);
  return [seenThrough(made.applyMatrix4(new Matrix4().set(...shape, 0, 0, 0, 1)), rgb)];
}

/** Upright columns on convex outlines, counter-clockwise, all in one mesh. */
export function columns(outlines: Point[][], [low, high]: [number, number], rgb: string): Object3D[] {
  const places: number[] = [];
  for (const corners of outlines) {
    const [first = [0, 0]] = corners;
    corners.forEach((corner, k) => {
      const next = corners[(k + 1) % corners.length] ?? corner;
      places.push(...corner, low, ...next, low, ...next, high, ...corner, low, ...next, high, ...corner, high);
      places.push(...first, high, ...corner, high, ...next, high);
    });
  }
  if (!places.length) return [];
  const made = new BufferGeometry().setAttribute("position", new Float32BufferAttribute(places, 3));
  made.computeVertexNormals();
  return [seenThrough(made, rgb)];
}

function seenThrough(geometry: BufferGeometry, rgb: string): Mesh {
  const material = new MeshLambertMaterial({
    color: rgb,
    transparent: true,
    opacity: OPACITY,
    depthTest: false,
    depthWrite: false,
  });
  return new Mesh(geometry, material);
}
