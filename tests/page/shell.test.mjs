// The address of the page, charts that nobody chose, and what recordings are of.
import assert from "node:assert/strict";
import { test } from "node:test";
import { ApiError, tellUnhandled } from "page/failures";
import { factsOf } from "page/review/facts";
import { suggested } from "page/charts/suggested";
import { addressOf, isSamePlace, placeAt } from "page/shell/address";

const PLACE = { view: "review", world: "rooms/küche & co.yaml", recording: "out/run-2.mcap", time: 12.3456 };

test("an address names view, world, recording and time, and is read back", () => {
  assert.equal(addressOf({ ...PLACE, world: "shipped:classic/slam" }), "#review?world=shipped:classic/slam&recording=out/run-2.mcap&time=12.35");
  assert.deepEqual(placeAt(addressOf(PLACE)), { ...PLACE, time: 12.35 });
  const bare = { view: "run", world: null, recording: null, time: 0 };
  assert.equal(addressOf(bare), "#run");
  assert.deepEqual(placeAt("#run"), bare);
});

test("what is no place of an address is left out", () => {
  assert.deepEqual(placeAt("#review?time=soon&token=secret&world="), { view: "review", world: null, recording: null, time: 0 });
  assert.deepEqual(placeAt("").view, "");
});

test("another time is the same place, another recording is not", () => {
  assert.ok(isSamePlace(PLACE, { ...PLACE, time: 3 }));
  assert.ok(!isSamePlace(PLACE, { ...PLACE, recording: "out/run.mcap" }));
});

test("the positions of joints are suggested, a chart for each topic", () => {
  const joint = (topic, name) => [`/${topic}/joints`, name];
  const fields = [["/run", "pace"], joint("crank", "q2.position"), joint("crank", "q2.velocity"), joint("arm", "joints[1].position"), joint("crank", "q3.position")];
  assert.deepEqual(suggested(fields, { fields: 6, charts: 8 }), [
    { kind: "time", fields: [fields[1], fields[4]] },
    { kind: "time", fields: [fields[3]] },
  ]);
  assert.deepEqual(suggested(fields, { fields: 1, charts: 1 }).map((chart) => chart.fields), [[fields[1]]]);
  assert.deepEqual(suggested([["/run", "pace"]], { fields: 6, charts: 8 }), []);
});

test("a recording has date, length, world and robots, as far as they are known", () => {
  const when = new Date(2026, 10, 29, 7, 5).getTime() / 1000;
  const card = { path: "run.mcap", when, bytes: 1, world: "hall", robots: ["ann", "bob"], seconds: 125.6 };
  assert.deepEqual(factsOf(card), ["2026-11-29 07:05", "2:06", "hall", "ann, bob"]);
  assert.equal(factsOf({ ...card, seconds: 59.4 })[1], "59 s");
  assert.equal(factsOf({ ...card, seconds: 0.96 })[1], "1.0 s");
  assert.deepEqual(factsOf({ ...card, seconds: null, world: "", robots: [] }), ["2026-11-29 07:05"]);
});

test("of a request that fails and that nobody waits for the person is told, an error of the page stays unhandled", () => {
  const [page, told] = [new EventTarget(), []];
  tellUnhandled(page, (error) => told.push(error.message));
  const isHandled = (reason) => !page.dispatchEvent(Object.assign(new Event("unhandledrejection", { cancelable: true }), { reason }));
  assert.ok(isHandled(new ApiError(0, "the studio does not answer")));
  assert.ok(!isHandled(new TypeError("undefined is not a function")));
  assert.deepEqual(told, ["the studio does not answer"]);
});
