// What is looked at in Review: the recording, its time and the part of it that is marked; and the list of recordings.
import assert from "node:assert/strict";
import { test } from "node:test";
import { isFound, newestFirst } from "page/review/facts";
import { Looked, UNMARKED } from "page/review/looked";

const RECORDING = { path: "out/run.mcap", seconds: 9, dt: 0.5, events: [{ time: 2 }, { time: 5.5 }] };

function looked(time, part = UNMARKED) {
  const made = Object.assign(new Looked(), { recording: RECORDING, part });
  made.player.load(RECORDING.seconds, RECORDING.dt, time);
  return made;
}

test("a part begins or ends now, and an end that lies on the wrong side goes", () => {
  assert.deepEqual(looked(3).fromNow(), { from: 3, to: null });
  assert.deepEqual(looked(3, { from: 1, to: 4 }).fromNow(), { from: 3, to: 4 });
  assert.deepEqual(looked(3, { from: 1, to: 3 }).fromNow(), { from: 3, to: null });
  assert.deepEqual(looked(3, { from: 1, to: 8 }).untilNow(), { from: 1, to: 3 });
  assert.deepEqual(looked(3, { from: 4, to: 8 }).untilNow(), { from: null, to: 3 });
});

test("what is not marked reaches to the ends of the recording, and without one there is nothing", () => {
  assert.deepEqual(looked(3).ends, [0, 9]);
  assert.deepEqual(looked(3, { from: 2, to: null }).ends, [2, 9]);
  assert.deepEqual([looked(3).isWhole, looked(3, { from: null, to: 1 }).isWhole], [true, false]);
  assert.deepEqual(looked(0).events, [2, 5.5]);
  assert.deepEqual([new Looked().ends, new Looked().events, new Looked().time], [[0, 0], [], 0]);
});

test("the time has one owner, and stays within the recording", () => {
  const one = looked(3);
  one.player.step(1);
  assert.equal(one.time, 3.5);
  one.player.seek(100);
  assert.equal(one.time, 9);
});

test("recordings stand in the order of their cards, those without one behind, and those that are gone nowhere", () => {
  const cards = ["c", "gone", "a"].map((path) => ({ path }));
  assert.deepEqual(newestFirst(cards, ["a", "b", "c"]), ["c", "a", "b"]);
});

test("a search finds recordings that have all its words", () => {
  const facts = ["2026-11-29 07:05", "hall", "ann, bob"];
  assert.deepEqual(["", "OUT hall", "bob run", "hall carl"].map((wish) => isFound(wish, "out/run.mcap", facts)), [true, true, true, false]);
});
