// Displays that stay for some seconds: paths from a time on, and readings of the last seconds.
import assert from "node:assert/strict";
import { test } from "node:test";

const kept = new Map();
globalThis.window = { localStorage: { getItem: (key) => kept.get(key) ?? null, setItem: (key, text) => kept.set(key, text) } };
globalThis.localStorage = window.localStorage;
globalThis.document = { documentElement: { style: { setProperty() {}, removeProperty() {} } } };
globalThis.matchMedia = window.matchMedia = () => ({ matches: false, addEventListener() {} });
globalThis.MutationObserver = class { observe() {} };
const { chooseDecay, decayOf } = await import("page/ui/displays");
const { Past } = await import("page/run/past");
const { Trail } = await import("page/run/history");

const tick = (x) => ({ truth: [x, 0, 0], sightings: [["a", 1, 0]], scans: { scan: [x, 0, 0] }, proximity: [] });

test("a path is cut at a time, also where the robot was put down elsewhere", () => {
  const trail = new Trail();
  for (let k = 0; k < 10; k += 1) trail.add([k < 5 ? k / 10 : 7 + k / 10, 0, 0], k);
  assert.deepEqual(trail.since(Number.NEGATIVE_INFINITY), trail.pieces);
  assert.deepEqual(trail.since(0).flat().length, 10);
  assert.deepEqual(trail.since(3).map((piece) => piece.map((point) => point[2])), [[3, 4], [5, 6, 7, 8, 9]]);
  assert.deepEqual(trail.since(7.5).map((piece) => piece.map((point) => point[2])), [[8, 9]]);
  assert.deepEqual(trail.since(9.5), []);
});

test("a path of a recording has the times of its rows", () => {
  const trail = new Trail();
  const poses = [[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0], [0.3, 0, 0]];
  trail.until(poses, [0, 1, 2, 3], 2);
  trail.until(poses, [0, 1, 2, 3], 4);
  assert.deepEqual(trail.pieces, [[[0, 0, 0], [0.1, 0, 1], [0.2, 0, 2], [0.3, 0, 3]]]);
});

test("readings stay for the decay of their display, without one only the newest", () => {
  const past = new Past();
  chooseDecay("scans", 2);
  for (let k = 0; k <= 5; k += 1) past.add(k, { r: tick(k) });
  const xs = (name) => past.of(name, "r").map((each) => each.truth[0]);
  assert.deepEqual(xs("scans"), [5, 4]);
  assert.deepEqual(xs("sightings"), [5]);
  assert.deepEqual(past.of("scans", "another"), []);
  past.add(4.5, { r: tick(4.5) }); // somebody went back
  assert.deepEqual(xs("scans"), [4.5, 4]);
  chooseDecay("scans", null);
  assert.equal(decayOf("scans"), null);
  assert.deepEqual(xs("scans"), [4.5]);
});

test("only what stays is kept beside the newest: long decays of few sightings do not keep scans", () => {
  const past = new Past();
  chooseDecay("sightings", 600);
  const scan = Array(3 * 20_000).fill(0);
  for (let k = 0; k < 500; k += 1) past.add(k, { r: { ...tick(k), scans: { scan } } });
  assert.equal(past.of("sightings", "r").length, 500);
  assert.deepEqual(past.of("scans", "r").map((each) => each.truth[0]), [499]);
  const [newest, ...before] = past.of("sightings", "r");
  assert.equal(newest.scans.scan.length, scan.length);
  assert.ok(before.every((each) => Object.keys(each.scans).length === 0));
  chooseDecay("sightings", null);
});

test("many points are kept for a time only up to a bound", () => {
  const past = new Past();
  chooseDecay("scans", 100);
  const scan = Array(3 * 20_000).fill(0);
  for (let k = 0; k < 50; k += 1) past.add(k, { r: { ...tick(0), scans: { scan } } });
  assert.equal(past.of("scans", "r").length, 3); // with the newest; one more would make more than 50,000
  chooseDecay("scans", null);
});
