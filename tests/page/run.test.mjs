// What is done to a run by hand, and what is shown of it.
import assert from "node:assert/strict";
import { test } from "node:test";
import { goalEvent, measured } from "page/run/aim";
import { cellsOf, unitOf } from "page/charts/message";
import { holdsUp } from "page/run/hold_up";
import { goesOn, letGoOf } from "page/run/joint_grips";

const LOOP = { grip: { toward: [1, 0, 0] } };

test("a joint of a loop that was let go goes on for a hundred ticks, however slowly they come", (context) => {
  const letGo = letGoOf(LOOP, 0.7);
  const now = performance.now();
  context.mock.method(performance, "now", () => now + 60_000);
  for (let tick = 1; tick < 100; tick++) assert.ok(goesOn(LOOP, 0.7, letGo), `it stops at tick ${tick}`);
  assert.ok(!goesOn(LOOP, 0.7, letGo));
});

test("it is there once it has rested for some ticks, not when it swings past", () => {
  const letGo = letGoOf(LOOP, 0.7);
  for (const by of [0.4, 0.005, -0.1, 0.002]) assert.ok(goesOn(LOOP, by, letGo));
  const rests = Array.from({ length: 20 }, () => goesOn(LOOP, 0.001, letGo));
  assert.deepEqual([rests[0], rests.at(-1)], [true, false]);
});

test("what is there already, or is no joint of a loop, does not go on", () => {
  assert.equal(letGoOf(LOOP, 0.001), null);
  assert.equal(letGoOf({ grip: {} }, 0.7), null);
});

test("a press is a goal, a drag from it the heading there", () => {
  assert.deepEqual(goalEvent("scout", [1.23456, -2], [1.23456, -1], 0.1), { goal: "scout", to: [1.235, -2], heading_deg: 90 });
  assert.deepEqual(goalEvent("scout", [0, 0], [-1, -1], 0.1), { goal: "scout", to: [0, 0], heading_deg: -135 });
  assert.deepEqual(goalEvent("scout", [-0.0001, 0], [0.05, 0], 0.1), { goal: "scout", to: [0, 0] });
});

test("a distance is measured with its direction", () => {
  assert.deepEqual(measured([1, 1], [-2, 5]), { metres: "5.000", degrees: "126.9" });
  assert.deepEqual(measured([0, 0], [2, -1e-9]), { metres: "2.000", degrees: "0.0" });
});

test("what holds a robot up is told with its reason for ten seconds, of that robot alone", () => {
  const blocked = { kind: "event", time: 4, robot: "scout", event: "blocked", text: "scout is blocked: no way to [5, 2]" };
  assert.ok(holdsUp(blocked, "scout", 13.9));
  for (const [event, robot, time] of [[blocked, "scout", 14], [blocked, "scout", 3], [blocked, "other", 5]])
    assert.ok(!holdsUp(event, robot, time));
});

test("a message is rows of paths and values: lists of plain values are one, things with names are known by them", () => {
  const message = { time: 0.1, parts: [{ part: "sense", seconds: 1 / 3 }, { x: null }], scan: Array.from({ length: 180 }, (_, k) => k), on: true, empty: [] };
  assert.deepEqual([...cellsOf(message)], [
    ["time", "0.1"], ["parts[sense].part", "sense"], ["parts[sense].seconds", "0.333333"], ["parts[1].x", "\u2013"],
    ["scan", "[0, 1, 2, 3, 4, 5, 6, 7, \u2026] (180)"], ["on", "true"], ["empty", "[]"],
  ]);
  assert.deepEqual([...cellsOf(null)], []);
});

test("a number has its unit, or that of what it is part of", () => {
  const units = { "pose.position": "m", heading: "rad" };
  assert.deepEqual(["pose.position.x", "heading", "poses[2].position.x", "pose"].map((name) => unitOf(name, units)), ["m", "rad", "", ""]);
  assert.equal(unitOf("proximity[3]", { proximity: "m" }), "m");
});
