// From how far a view in 3-D shows all of a box, and where its axes point.
import assert from "node:assert/strict";
import { test } from "node:test";
import { distanceToSee, endsOf } from "page/scene/frame";

const near = (one, other) => one.forEach((value, k) => assert.ok(Math.abs(value - other[k]) < 1e-9, `${one} is not ${other}`));

test("from above, the longer side of a box fits into the width, above its top", () => {
  // Half of 8 m at a slope of 0.5 is 8 m from the top, which is 1 m above the middle; 6 % are spare.
  assert.ok(Math.abs(distanceToSee([8, 2, 2], [0, -1e-4, 1], 0.5, 0.5) - (1.06 * 8 + 1)) < 1e-3);
  assert.ok(Math.abs(distanceToSee([8, 2, 2], [0, 0, 1], 2, 0.1) - (1.06 * 10 + 1)) < 1e-9);
});

test("from the front, the side towards the eye is what must fit", () => {
  assert.ok(Math.abs(distanceToSee([2, 6, 1], [0, -1, 0], 0.5, 0.5) - (1.06 * 2 + 3)) < 1e-9);
});

test("from a corner, all corners are in the picture and one is at its border", () => {
  const [size, from, across, up] = [[5, 3, 2], [-0.55, -0.75, 0.7], 0.8, 0.45];
  const long = Math.hypot(...from);
  const back = from.map((part) => part / long);
  const level = Math.hypot(back[0], back[1]);
  const right = [-back[1] / level, back[0] / level, 0];
  const above = [-back[2] * right[1], back[2] * right[0], level];
  const distance = distanceToSee(size, from, across, up);
  const dot = (a, b) => a.reduce((sum, part, k) => sum + part * b[k], 0);
  const shares = [...Array(8).keys()].map((k) => {
    const corner = size.map((side, axis) => ((k >> axis) & 1 ? 0.5 : -0.5) * side);
    const depth = distance - dot(corner, back);
    return Math.max(Math.abs(dot(corner, right)) / across, Math.abs(dot(corner, above)) / up) / depth;
  });
  assert.ok(Math.abs(Math.max(...shares) - 1 / 1.06) < 1e-9);
});

test("axes point as they are seen: from above x to the right and y up, from the front z up and y away", () => {
  const half = Math.SQRT1_2;
  const above = endsOf([1, 0, 0, 0]);
  [[1, 0, 0], [0, -1, 0], [0, 0, 1]].forEach((end, k) => near(above[k], end));
  const front = endsOf([half, half, 0, 0]);
  [[1, 0, 0], [0, 0, -1], [0, -1, 0]].forEach((end, k) => near(front[k], end));
});
