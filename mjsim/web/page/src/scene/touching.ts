/** Where bodies touch each other, as the last news of their places have it. */

import type { Group, Points } from "three";
import { color } from "../shell/theme";
import { points } from "./marks";
import { dots } from "./strokes";
import { forget } from "./thoughts";

/** Numbers of a contact: x, y, z [m], and whether it is with the floor. */
const ROW = 4;
/** Across a contact [m]; at least, and at least across one with the floor, of half the height of the view. */
const SIZE = 0.03;
const LARGE = 0.035;
const SMALL = 0.02;

/** Draw contacts in a group in the place of what was there: those with the floor small. */
export function drawContacts(group: Group, contacts: Float32Array): void {
  forget(group);
  const [others, floor]: [number[], number[]] = [[], []];
  for (let k = 0; k + ROW <= contacts.length; k += ROW)
    (contacts[k + 3] ? floor : others).push(...contacts.subarray(k, k + 3));
  if (floor.length) group.add(mark(floor, "--muted", SMALL));
  if (others.length) group.add(mark(others, "--error", LARGE));
}

function mark(numbers: number[], token: string, least: number): Points {
  const made = dots(points(numbers), SIZE, { color: color(token), through: true }, least);
  made.renderOrder = 4;
  return made;
}
