// Points, angles, views and snapping of the plan, and rotations in three dimensions.
import assert from "node:assert/strict";
import { test } from "node:test";
import { snapCorner } from "page/edit/snap";
import { inkOf, outlines, placed } from "page/plan/shapes";
import { boundsOf, distanceTo, heading, inside, nearestOn, rotate, short, turned } from "page/plan/geometry";
import { LARGEST, PlanView, SMALLEST, metres, roundStep } from "page/plan/view";
import { between, inverse, ofVector, product, rotated, toVector } from "page/run/rotations";

const SQUARE = [[0, 0], [2, 0], [2, 2], [0, 2]];
const random = seeded(1);

/** Numbers from 0 to 1 that are the same each time: a linear congruential generator. */
function seeded(seed) {
  let state = seed;
  return () => (state = (1664525 * state + 1013904223) % 2 ** 32) / 2 ** 32;
}

function near(found, wanted, within = 1e-9) {
  assert.equal(found.length, wanted.length);
  found.forEach((value, k) => assert.ok(Math.abs(value - wanted[k]) <= within, `${found} is not ${wanted}`));
}

test("headings are counter-clockwise from x, above -180 degrees and at most 180", () => {
  for (const [vector, degrees] of [[[1, 0], 0], [[0, 2], 90], [[-1, 0], 180], [[-1, -0], 180], [[0, -1], -90]])
    assert.equal(heading(vector), degrees);
  for (const [degrees, same] of [[-180, 180], [540, 180], [-450, -90], [359, -1], [720, 0]]) assert.equal(turned(degrees), same);
});

test("a rotation turns headings by its angle and keeps lengths", () => {
  for (let k = 0; k < 50; k++) {
    const [vector, by] = [[random() - 0.5, random() - 0.5], 720 * random() - 360];
    const after = rotate(vector, by);
    near([Math.hypot(...after), turned(heading(after) - heading(vector) - by)], [Math.hypot(...vector), 0]);
  }
});

test("the nearest point of a segment is nearer than any other of it", () => {
  for (let k = 0; k < 50; k++) {
    const [point, a, b] = Array.from({ length: 3 }, () => [random(), random()]);
    const { at, along } = nearestOn(point, a, b);
    near(at, [a[0] + along * (b[0] - a[0]), a[1] + along * (b[1] - a[1])]);
    for (let share = 0; share <= 1; share += 0.05) {
      const other = [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])];
      assert.ok(Math.hypot(at[0] - point[0], at[1] - point[1]) <= Math.hypot(other[0] - point[0], other[1] - point[1]) + 1e-12);
    }
  }
  near(nearestOn([1, 1], [0, 0], [0, 0]).at, [0, 0]);
});

test("a point in a polygon has no distance, one beside it that to its edge or corner", () => {
  for (const [point, far] of [[[1, 1], 0], [[3, 1], 1], [[3, 3], Math.SQRT2], [[1, -2], 2]]) {
    assert.equal(distanceTo(point, SQUARE), far);
    assert.equal(inside(point, SQUARE), far === 0);
  }
  assert.deepEqual(boundsOf(SQUARE), [0, 0, 2, 2]);
});

test("numbers are written with four decimals at most, and zero has no sign", () => {
  assert.equal(short(0.1 + 0.2), 0.3);
  assert.ok(Object.is(short(-0.00001), 0));
});

test("a view leads from the world to pixels and back, y up in one and down in the other", () => {
  const view = new PlanView();
  near(view.toWorld(view.toScreen([3.25, -1.5])), [3.25, -1.5]);
  assert.ok(view.toScreen([0, 1])[1] < view.toScreen([0, 0])[1]);
});

test("zooming keeps what is at the pointer there, within the limits of the scale", () => {
  const view = new PlanView();
  for (const factor of [2, 0.3, 1e9, 1e-12]) {
    const before = view.toWorld([123, 77]);
    view.zoom(factor, [123, 77]);
    near(view.toWorld([123, 77]), before, 1e-6);
    assert.ok(SMALLEST <= view.scale && view.scale <= LARGEST);
  }
});

test("all of a world is in sight in a window of any size", () => {
  for (const [width, height] of [[1280, 720], [390, 844], [640, 360]])
    for (const bounds of [[0, 0, 6, 4], [500, 500, 1500, 1500], [-0.2, 0, 0.2, 30]]) {
      const view = Object.assign(new PlanView(), { width, height });
      view.fit(bounds, 40);
      const [left, below, right, above] = view.bounds;
      assert.ok(left <= bounds[0] && below <= bounds[1] && right >= bounds[2] && above >= bounds[3]);
      near(view.toScreen([(bounds[0] + bounds[2]) / 2, (bounds[1] + bounds[3]) / 2]), [width / 2, height / 2], 1e-6);
    }
});

test("steps of a ruler are 1, 2 or 5 times a power of ten and their numbers have the decimals that they need", () => {
  for (const scale of [0.1, 3, 60, 333, 4000]) {
    const step = roundStep(scale, 50);
    assert.ok(step * scale >= 49.9 && step * scale <= 126);
    assert.match(step.toExponential(), /^[125]e/);
  }
  assert.deepEqual([metres(2.5, 0.5), metres(-1, 0.01), metres(-1e-9, 1), metres(40, 20)], ["2.5", "−1.00", "0", "40"]);
});

const wall = (points, closed = false) => ({ type: "Wall", path: ["walls", 0], values: { points, closed, thickness: 0.12 } });
const snapping = (from = [], walls = []) => ({ step: 0.1, reach: 0.2, walls, from });

test("a corner goes to the end of a wall, else onto a wall, to a right angle, or to the grid", () => {
  const walls = [wall([[0, 0], [4, 0]])];
  assert.deepEqual(snapCorner([3.9, 0.1], snapping([], walls)), { at: [4, 0], to: "end" });
  assert.deepEqual(snapCorner([2.03, 0.08], snapping([], walls)), { at: [2.03, 0], to: "wall" });
  assert.deepEqual(snapCorner([2.03, 1.08], snapping([], walls)), { at: [2, 1.1], to: "grid" });
  assert.deepEqual(snapCorner([3.02, 2.97], snapping([[1, 3]])), { at: [3, 3], to: "angle" });
  assert.deepEqual(snapCorner([2.97, 2], snapping([[1, 3], [3, 3]])), { at: [3, 2], to: "angle" });
  assert.equal(snapCorner([1.05, 3.02], snapping([[1, 3], [3, 3]])).to, "end"); // which closes the wall
});

test("a right angle is taken from the segment before as well, however that lies", () => {
  const { at, to } = snapCorner([1.1, 2.85], snapping([[0, 0], [2, 1]]));
  assert.equal(to, "angle");
  near([2 * (at[0] - 2) + (at[1] - 1)], [0], 1e-3);
});

const axes = () => Array.from({ length: 3 }, () => 4 * random() - 2);

test("rotation vectors and quaternions are the same rotations, at most half a turn", () => {
  for (let k = 0; k < 50; k++) {
    const vector = axes();
    const point = axes();
    const angle = Math.hypot(...vector);
    // Rodrigues' formula.
    const unit = vector.map((each) => each / angle);
    const [x, y, z] = unit;
    const across = [y * point[2] - z * point[1], z * point[0] - x * point[2], x * point[1] - y * point[0]];
    const along = unit.reduce((sum, each, i) => sum + each * point[i], 0) * (1 - Math.cos(angle));
    near(rotated(point, vector), point.map((each, i) => each * Math.cos(angle) + across[i] * Math.sin(angle) + unit[i] * along));
    const back = toVector(ofVector(vector));
    assert.ok(Math.hypot(...back) <= Math.PI + 1e-9);
    near(rotated(point, back), rotated(point, vector));
  }
  near(toVector(ofVector([0, 0, 0])), [0, 0, 0]);
});

test("a product applies the second rotation first, and an inverse undoes one", () => {
  const [a, b, point] = [axes(), axes(), axes()];
  near(rotated(point, toVector(product(ofVector(a), ofVector(b)))), rotated(rotated(point, b), a));
  near(product(ofVector(a), inverse(ofVector(a))), [1, 0, 0, 0]);
});

test("the shortest rotation takes one direction to another, also to the opposite one", () => {
  for (const [from, to] of [[axes(), axes()], [[1, 0, 0], [-2, 0, 0]], [[0, 3, 0], [0, 1, 0]]]) {
    const after = rotated(from, between(from, to));
    near(after.map((each) => each / Math.hypot(...from)), to.map((each) => each / Math.hypot(...to)));
    assert.ok(Math.hypot(...between(from, to)) <= Math.PI + 1e-9);
  }
});

const DOOR = {
  at: [1.5, 0],
  heading_deg: 0,
  polygons: [[[1, -0.1], [2, -0.1], [2, 0.1], [1, 0.1]], [[1, 0], [2, 0], [2, 0.04]]],
  shapes: [{ role: "gap", fixed: true, count: 1 }, { role: "leaf", carrier: [1, 0, 0], count: 1 }],
};

test("a leaf turns about its hinge, and its gap stays", () => {
  const [gap, leaf] = outlines(DOOR, { at: [1, 0], heading_deg: 90 });
  assert.deepEqual(gap, DOOR.polygons[0]);
  leaf.forEach((point, k) => near(point, [[1, 0], [1, 1], [0.96, 1]][k]));
});

test("of an outline in more pieces than before all are there", () => {
  const corners = [[0, 0], [1, 0], [1, 1]];
  const wall = { at: null, polygons: [corners, corners, corners], shapes: [{ role: "low wall", count: 1 }, { role: "wall", count: 1 }] };
  assert.equal(outlines(wall, { at: [0, 0], heading_deg: 0 }).length, 3);
});

test("a symbol has the same size at each scale, a line that of the world, and both go with their item", () => {
  const robot = { at: [1, 2], heading_deg: 90, polygons: [] };
  const nose = { role: "heading", anchor: [0.2, 0, 0], parts: [[[0, 0], [1, 0]]] };
  const shaft = { role: "heading", parts: [[[0, 0], [0.2, 0]]] };
  for (const scale of [10, 200]) {
    const view = Object.assign(new PlanView(), { scale });
    for (const [stand, at, ahead] of [[undefined, [1, 2], [0, 1]], [{ at: [3, 3], heading_deg: 180 }, [3, 3], [-1, 0]]]) {
      const tip = view.toScreen([at[0] + 0.2 * ahead[0], at[1] + 0.2 * ahead[1]]);
      const [symbol, line] = [placed(robot, nose, view, stand)[0], placed(robot, shaft, view, stand)[0]];
      near(symbol[0], tip);
      near(symbol[1], [tip[0] + 5 * ahead[0], tip[1] - 5 * ahead[1]]);
      near([...line[0], ...line[1]], [...view.toScreen(at), ...tip]);
    }
  }
});

test("colours are mixed as in films, and what is selected has the colour of the selection", () => {
  const palette = { ground: "#ffffff", ink: "#000000", wall: "#404040", accent: "#0000ff", muted: "#808080" };
  const box = { role: "obstacle", tint: "#204060", count: 1 };
  assert.deepEqual(inkOf(box, true, palette, {}), { fill: "#90a0b0", line: "#122335", width: 1, dash: 0 });
  assert.equal(inkOf({ ...box, level: 0.5 }, true, palette, {}).fill, "#c8d0d8");
  assert.deepEqual(inkOf(box, true, palette, { selected: true }), { fill: "#90a0b0", line: "#0000ff", width: 2, dash: 0 });
  assert.equal(inkOf({ role: "wall", count: 1 }, true, palette, { selected: true }).fill, "#0000ff");
  assert.equal(inkOf({ role: "tool", anchor: [0, 0, 0], parts: [], closed: true }, true, palette, {}).line, null);
});
