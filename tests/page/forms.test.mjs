// Fields of forms: numbers as they are shown, read and stepped; sliders of noise; what has the focus after a control that goes.
import assert from "node:assert/strict";
import { test } from "node:test";
import { readNumber, shown, stepped } from "page/panel/numbers";
import { shareOf, spanOf, splitKey, valueAt } from "page/run/noise_scale";
import { heirOf } from "page/ui/heir";

test("a number that is shown is read as the same, to four decimals or digits", () => {
  for (const value of [0, 1, -2.5, 0.00002, 123456.7891, 0.05, -1e-7]) {
    assert.ok(Math.abs(readNumber(shown(value)) - value) <= Math.max(5e-5, 5e-5 * Math.abs(value)));
    if (value && Math.abs(value) < 0.1) assert.ok(Math.abs(readNumber(shown(value)) / value - 1) < 1e-3);
  }
  assert.equal(shown(1e-15), "0");
  assert.deepEqual([null, undefined, "${w / 2}"].map(shown), ["–", "–", "${w / 2}"]);
});

test("what is no number is refused, arithmetic is kept, and a true minus sign counts", () => {
  assert.deepEqual(["1,5", "abc", "", "1e999"].map(readNumber), [undefined, undefined, undefined, undefined]);
  assert.deepEqual(["${w / 2}", "−3"].map(readNumber), ["${w / 2}", -3]);
});

test("arrows step a number, with Shift a tenth of it but never a part of one", () => {
  const up = { key: "ArrowUp", shiftKey: false };
  assert.equal(stepped("0.1", up, 0.1), "0.2");
  assert.equal(stepped("0.1", { ...up, shiftKey: true }, 0.1), "0.11");
  assert.equal(stepped("3", { key: "ArrowDown", shiftKey: true }, 1), "2");
  assert.deepEqual([stepped("several", up, 1), stepped("1", { key: "a", shiftKey: false }, 1)], [null, null]);
});

test("a slider of noise stands where its value is, and small values get more room", () => {
  for (const noise of [{ initial: 0.02 }, { initial: 0, unit: "deg" }, { initial: 0.5, slider: [0, 1] }, { initial: 1, slider: [0.5, 2] }]) {
    const span = spanOf(noise);
    for (const share of [0, 0.1, 0.5, 0.9, 1]) assert.ok(Math.abs(shareOf(span, valueAt(span, share)) - share) < 5e-3);
  }
  const span = spanOf({ initial: 0.02 });
  assert.ok(valueAt(span, 0.5) < (span.low + span.high) / 2);
  assert.deepEqual([shareOf(span, -1), shareOf(span, 100)], [0, 1]);
  assert.deepEqual(splitKey("robots.scout.odometry.noise.turn"), ["scout, odometry", "turn"]);
  assert.deepEqual(splitKey("robots.scout.sensors.ring.noise.bearing_deg"), ["scout, ring", "bearing"]);
});

test("after a control that goes the focus is on what took its place, else on what is next to it", () => {
  assert.equal(heirOf(["a", "b", "c"], 1, ["a", "new", "c"]), "new");
  assert.equal(heirOf(["a", "b", "c"], 1, ["a", "c"]), "c");
  assert.equal(heirOf(["a", "b"], 1, ["a"]), "a");
  assert.equal(heirOf(["a", "b"], 0, ["new", "b"]), "new");
  assert.equal(heirOf(["a"], 0, []), undefined);
});
