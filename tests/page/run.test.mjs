// What is done to a run by hand, and what is shown of it.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Current } from "page/run/current";
import { goalEvent, measured } from "page/run/aim";
import { cellsOf, unitOf } from "page/charts/message";
import { holdsUp } from "page/run/hold_up";
import { changeTo, goesOn, jointEvent, letGoOf } from "page/run/joint_grips";

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

test("a joint goes to where its handle is dragged, also through half a turn, and no farther than its range", () => {
  const above = ([x, y]) => [x, y];
  const slide = { grip: { slides: true, at: [0, 0, 0], axis: [1, 0, 0], grip: [1, 1, 0] }, facts: { lower: -0.5, upper: 0.5 }, value: 0.1 };
  assert.ok(Math.abs(changeTo(slide, above, [1.3, 1.2]) - 0.3) < 1e-9);
  assert.ok(Math.abs(changeTo(slide, above, [3, 1.2]) - 0.4) < 1e-9);
  const swing = { grip: { slides: false, at: [2, 2, 0], axis: [0, 0, 1], grip: [3, 2, 0] }, facts: {}, value: 0 };
  for (const angle of [1.2, -2.5, 3.1]) {
    const by = changeTo(swing, above, [2 + Math.cos(angle), 2 + Math.sin(angle)]);
    assert.ok(Math.abs(by - angle) < 1e-6, `${by} is not ${angle}`);
  }
});

test("of an arm one joint is led, and no other turns", () => {
  const own = ["a", "b", "c"].map((name) => ({ name, slides: false }));
  const robots = { r: { arms: { arm: { goal: [0, Math.PI / 4, -Math.PI / 6] } } } };
  const held = { grip: { of: "r/arm", joint: "a" }, facts: own[0], value: Math.PI / 2 };
  assert.deepEqual(jointEvent(held, { "r/arm": own }, robots), { reach: "r", arm: "arm", joints_deg: [90, 45, -30] });
  assert.deepEqual(jointEvent({ ...held, grip: { of: "gate", joint: "a" } }, {}, robots), { lead: "gate", joint: "a", to_deg: 90 });
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
  const blocked = { kind: "event", time: 4, robot: "scout", event: "blocked", text: "scout is blocked: no path to [5, 2]" };
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

const RUN = { state: "running", number: 1, path: "room.yaml", robots: [{ name: "a", can_drive: true }], controllable: true };

test("a run of another world that is over is not shown as that of the world that is open", () => {
  const opened = { path: "room.yaml", isOpen: true, hasFile: true };
  const current = new Current(false, opened);
  current.run = current.own(RUN);
  current.chosen = "a";
  assert.ok(current.isOn && current.canDrive);
  opened.path = "hall.yaml";
  current.leave();
  assert.equal(current.own({ ...RUN, state: "ended" }).state, "idle");
  assert.equal(current.own(RUN).state, "running"); // it goes on, and is seen
  assert.equal(current.own({ ...RUN, number: 2, state: "ended" }).state, "ended"); // begun since
});

test("a page of one run alone shows that, and who drives is asked again with each run", () => {
  const current = new Current(true, { path: null, isOpen: false, hasFile: false });
  current.run = current.own({ ...RUN, state: "ended" });
  assert.deepEqual([current.run.state, current.isOn, current.canDrive, current.robot], ["ended", false, false, null]);
  current.driven = true;
  current.own({ ...RUN, state: "loading" });
  assert.equal(current.driven, false);
});
