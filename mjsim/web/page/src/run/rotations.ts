/** Rotations in three dimensions: rotation vectors (axis times angle [rad]) and quaternions [w, x, y, z]. */

import type { Place } from "../scene/grip";

export type Quaternion = [number, number, number, number];

/** Below this, a vector has no direction. */
const TINY = 1e-9;

export function ofVector(vector: Place): Quaternion {
  const angle = Math.hypot(...vector);
  const share = angle > TINY ? Math.sin(angle / 2) / angle : 0.5;
  return [Math.cos(angle / 2), vector[0] * share, vector[1] * share, vector[2] * share];
}

/** The rotation vector of at most half a turn. */
export function toVector([w, x, y, z]: Quaternion): Place {
  const sine = Math.hypot(x, y, z);
  const share = (sine > TINY ? (2 * Math.atan2(sine, Math.abs(w))) / sine : 2) * (w < 0 ? -1 : 1);
  return [x * share, y * share, z * share];
}

/** First the second rotation, then the first one. */
export function product([a, b, c, d]: Quaternion, [w, x, y, z]: Quaternion): Quaternion {
  return [
    a * w - b * x - c * y - d * z,
    a * x + b * w + c * z - d * y,
    a * y - b * z + c * w + d * x,
    a * z + b * y - c * x + d * w,
  ];
}

export function inverse([w, x, y, z]: Quaternion): Quaternion {
  return [w, -x, -y, -z];
}

/** A point rotated about the origin by a rotation vector. */
export function rotated(point: Place, vector: Place): Place {
  const by = ofVector(vector);
  const [, x, y, z] = product(product(by, [0, ...point]), inverse(by));
  return [x, y, z];
}

/** The shortest rotation that takes one direction to another, as a rotation vector. */
export function between(from: Place, to: Place): Place {
  const across = crossed(from, to);
  const [sine, cosine] = [Math.hypot(...across), dot(from, to)];
  if (sine > TINY * Math.hypot(...from) * Math.hypot(...to)) return times(across, Math.atan2(sine, cosine) / sine);
  return cosine > 0 ? [0, 0, 0] : times(aside(from), Math.PI);
}

/** A unit vector perpendicular to a vector. */
export function aside(vector: Place): Place {
  const [x, y, z] = vector.map(Math.abs) as Place;
  const axis: Place = x <= y && x <= z ? [1, 0, 0] : y <= z ? [0, 1, 0] : [0, 0, 1];
  const found = crossed(vector, axis);
  return times(found, 1 / Math.max(Math.hypot(...found), TINY));
}

export function crossed([a, b, c]: Place, [x, y, z]: Place): Place {
  return [b * z - c * y, c * x - a * z, a * y - b * x];
}

export function dot([a, b, c]: Place, [x, y, z]: Place): number {
  return a * x + b * y + c * z;
}

export function times([x, y, z]: Place, factor: number): Place {
  return [x * factor, y * factor, z * factor];
}

export function plus([a, b, c]: Place, [x, y, z]: Place): Place {
  return [a + x, b + y, c + z];
}

export function minus([a, b, c]: Place, [x, y, z]: Place): Place {
  return [a - x, b - y, c - z];
}
