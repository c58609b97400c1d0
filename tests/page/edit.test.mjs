// What edits make of things: names, copies, links, common fields, heights, texts and paths.
import assert from "node:assert/strict";
import { test } from "node:test";
import { sideOf } from "page/edit/sides";
import { LOGARITHMIC, decade } from "page/charts/decades";
import { isWindow } from "page/plan/geometry";
import { withoutList, written } from "page/edit/clipboard";
import { copied, freshMarker, freshName, nextUnused, remarked } from "page/edit/copies";
import { following } from "page/edit/follow";
import { canLift, lifted } from "page/edit/lift";
import { relinked, unlinked } from "page/edit/links";
import { SEVERAL, common, retold } from "page/panel/several";
import { beside, seenFrom } from "page/shell/paths";
import { newestWins } from "page/ui/signal";
import { difference } from "page/text/difference";

const thing = (values, more = {}) => ({ type: "Obstacle", path: ["obstacles", 0], name: values.name ?? null, at: null, fixed: null, values, written: Object.keys(values), ...more });

test("a fresh name is the wish, else one with the least number that is free, of at most 64 letters", () => {
  assert.equal(freshName("crate", new Set()), "crate");
  assert.equal(freshName("crate", new Set(["crate", "crate-2"])), "crate-3");
  assert.equal(freshName("crate-2", new Set(["crate-2"])), "crate-3");
  assert.equal(freshName("a".repeat(70), new Set(["a".repeat(64)])), `${"a".repeat(62)}-2`);
  assert.equal(freshName("post", new Set(["post-1"]), "-1"), "post-2"); // its first repetition would have that name
  assert.equal(freshName(" a b!", new Set()), "a-b-");
  assert.equal(freshName("Ka\u0308se", new Set()), "K\u00e4se");
  assert.equal(freshName("!", new Set()), "thing");
});

test("a fresh marker is the first that nothing has, of a dictionary that has so many", () => {
  const beacon = (id) => thing({ marker: { dictionary: "4x4_50", id } });
  assert.deepEqual(freshMarker([]).marker, { dictionary: "4x4_50", id: 0 });
  assert.deepEqual(freshMarker([beacon(0), beacon(2)]), { name: "tag1", marker: { dictionary: "4x4_50", id: 1 } });
  assert.deepEqual(freshMarker(Array.from({ length: 50 }, (_, k) => beacon(k))).marker, { dictionary: "4x4_100", id: 50 });
  assert.deepEqual(remarked(beacon(2).values, [beacon(2)]).marker, { dictionary: "4x4_50", id: 0 });
  assert.deepEqual(remarked(beacon(3).values, [beacon(2)]), beacon(3).values);
});

test("after a picture the next unused one is offered, from there on and around; the same where all are used", () => {
  const [own, all] = [["me", "you"], ["lion", "cat", "owl"]];
  const next = (current, ...used) => nextUnused(current, [own, all], new Set(used));
  assert.equal(next("lion"), "lion");
  assert.equal(next("lion", "lion", "cat"), "owl");
  assert.equal(next("owl", "owl"), "lion");
  assert.equal(next("gone", "me", "gone"), "you");
  assert.equal(next("owl", ...all), "me");
  assert.equal(next("owl", ...own, ...all), "owl");
  assert.equal(next("you", "you"), "me"); // one's own come before others
  assert.equal(next("you", ...own), "lion");
});

test("copies lie beside their originals, and what hangs on one of them hangs on its copy at the same place", () => {
  const desk = { name: "desk", at: [2, 2, 0.5] };
  const mirror = { name: "mirror", at: [-0.41, 0], on: "desk" };
  const other = { name: "lion", at: [0.3, 0], on: "shelf" };
  const [one, two, three] = copied([desk, mirror, other], [0.2, 0.1], new Set(["desk", "mirror", "lion"]));
  assert.deepEqual(one, { name: "desk-2", at: [2.2, 2.1, 0.5] });
  assert.deepEqual(two, { name: "mirror-2", at: [-0.41, 0], on: "desk-2" });
  assert.deepEqual([three.name, three.on], ["lion-2", "shelf"]);
  assert.deepEqual(desk.at, [2, 2, 0.5]);
});

const OLD_NEW = new Map([["desk", "table"]]);

test("references follow new names of things, also to parts of them, and end with what they name", () => {
  const person = thing({ seat: "chair", gaze: "desk.screen", hands: { left: "desk.keys", right: "chair.arm" } }, { path: ["people", 0], at: [1, 2] });
  assert.deepEqual(relinked(person, OLD_NEW).map(({ path, value }) => [path.slice(2).join("."), value]), [["gaze", "table.screen"], ["hands.left", "table.keys"]]);
  const changes = unlinked(person, new Set(["chair"]));
  assert.deepEqual(changes.map(({ op, path }) => `${op} ${path.slice(2).join(".")}`), ["set at", "set heading_deg", "unset seat", "unset hands.right"]);
  assert.deepEqual(changes[0].value, [1, 2]);
});

test("a new name of a robot is that of its driver, of events and of plants too", () => {
  const robot = thing({ name: "scout" }, { type: "Robot", path: ["robots", 0] });
  const run = { drivers: { scout: {} }, events: [{ move: "scout" }, { noise: "robots.scout.odometry.scale" }, { move: "other" }] };
  const plants = [{ name: "motor", of: "scout" }, { name: "elbow", of: "scout/arm" }];
  const world = { raw: { run, plants }, values: { plants } };
  const document = { items: [robot], parsed: { world, run }, itemAt: (path) => (path.join() === "robots,0" ? robot : null) };
  const changes = following({ op: "set", path: ["robots", 0, "name"], value: "rover" }, document);
  assert.deepEqual(changes.map(({ op, path, value }) => [op, path.join("."), value]), [
    ["rename", "run.drivers.scout", "rover"],
    ["set", "run.events.0.move", "rover"],
    ["set", "run.events.1.noise", "robots.rover.odometry.scale"],
    ["set", "plants.0.of", "rover"],
    ["set", "plants.1.of", "rover/arm"],
  ]);
  assert.deepEqual(following({ op: "set", path: ["robots", 0, "at"], value: [1, 1] }, document), []);
});

test("fields of several things say what differs, and a change leaves that as it is", () => {
  const [desk, stool] = [thing({ box: [0.8, 0.4, 0.7], friction: 1 }), thing({ box: [0.4, 0.3, 0.7], friction: 1 }, { path: ["obstacles", 1] })];
  assert.deepEqual(common([desk, stool]).values, { box: [SEVERAL, SEVERAL, 0.7], friction: 1 });
  const change = { op: "set", path: ["obstacles", 0, "box"], value: [SEVERAL, SEVERAL, 0.6] };
  assert.deepEqual(retold(change, desk, stool), { op: "set", path: ["obstacles", 1, "box"], value: [0.4, 0.3, 0.6] });
  assert.deepEqual(retold(change, desk, desk).value, [0.8, 0.4, 0.6]);
});

test("things are lifted to multiples of a step, not below the floor; a mechanism may go there", () => {
  const beacon = thing({ center: 1.2 }, { type: "Beacon" });
  assert.deepEqual(lifted(beacon, 0.33, 0.1).changes, [{ op: "set", path: ["obstacles", 0, "center"], value: 1.5 }]);
  assert.equal(lifted(beacon, -5, 0.1).changes[0].value, 0);
  assert.equal(lifted(thing({ height: 2 }, { type: "Lamp" }), -5, 0.1).changes[0].value, 0.01);
  assert.equal(lifted(thing({ elevation: 1 }, { type: "Mechanism" }), -3, 0.5).changes[0].value, -2);
  assert.ok(!canLift(thing({ points: [] })));
});

test("pieces of a world are written below the keys of their lists, and words that are no text have quotes", () => {
  const text = written([{ list: "obstacles", value: { name: "yes", box: [1, 2, 3] } }, { list: "beacons", value: { image: "posters/lion.jpg", name: "a b" } }, { list: "floor", value: { at: [0, 0] } }]);
  assert.equal(text, 'obstacles:\n  - {name: "yes", box: [1, 2, 3]}\nbeacons:\n  - {image: posters/lion.jpg, name: "a b"}\nfloor:\n  patches:\n    - {at: [0, 0]}\n');
});

test("items that are put below the list of their kind come without its key", () => {
  const text = "obstacles:\n  - {name: crate}\n";
  assert.equal(withoutList(text, ["mjsim: 1", "obstacles:", "  - {name: bin}"]), "  - {name: crate}\n");
  assert.equal(withoutList(text, ["mjsim: 1", "beacons:"]), text);
  assert.equal(withoutList("hello", ["obstacles:"]), "hello");
});

test("the difference of two texts leads from one to the other and parts no letter", () => {
  const letters = ["a", "b", "\u{1f916}", "\u{1f917}", "\n"];
  let state = 7;
  const pick = (most) => (state = (48271 * state) % 2147483647) % most;
  const text = () => Array.from({ length: pick(6) }, () => letters[pick(5)]).join("");
  for (let k = 0; k < 2000; k++) {
    const [old, fresh] = [text(), text()];
    const { from, to, insert } = difference(old, fresh);
    assert.equal(old.slice(0, from) + insert + old.slice(to), fresh);
    for (const part of [old.slice(0, from), old.slice(from, to), insert]) assert.ok(part.isWellFormed(), `${old} ${fresh}`);
  }
});

test("a path of the folder is found again by how a world names it", () => {
  for (const world of [null, "room.yaml", "a/b/room.yaml", "a/c/d/room.yaml"])
    for (const file of ["lion.png", "a/lion.png", "a/b/c/lion.png", "z/lion.png"]) assert.equal(beside(world, seenFrom(world, file)), file);
  assert.equal(beside("shipped:room.yaml", "lion.png"), "shipped:lion.png");
  assert.equal(beside("room.yaml", "../lion.png"), "../lion.png");
});

test("a logarithmic axis has at most five lines, each a power of ten, and as short names as can be", () => {
  for (const high of [0.5, 7, 950, 1e6, 3e12]) {
    const lines = LOGARITHMIC.splits(null, 0, 0, high);
    assert.ok(lines.length <= 5 && lines.every((each) => each === 0 || Number.isInteger(Math.log10(each))));
    assert.ok(lines.at(-1) <= Math.max(high, 1));
  }
  assert.deepEqual([decade(1000), decade(1e5)], ["1000", "1e5"]);
});

test("of what is wanted while one piece of work goes on only the newest is done", async () => {
  const [done, ends] = [[], []];
  const want = newestWins((wanted) => new Promise((end) => { done.push(wanted); ends.push(end); }));
  const all = [1, 2, 3].map(want);
  while (ends.length) { ends.shift()(); await new Promise(setImmediate); }
  await Promise.all(all);
  assert.deepEqual(done, [1, 3]);
});

test("an opening that begins at the floor is a doorway, above it a window", () => {
  assert.ok(isWindow({ kind: "opening", values: { sill: 0.9 } }));
  for (const values of [{ sill: 0 }, {}]) assert.ok(!isWindow({ kind: "opening", values }));
  assert.ok(!isWindow({ kind: "wall", values: { sill: 1 } }));
});

test("text goes to the right or below, panels to the left or right, whichever side is nearer", () => {
  assert.deepEqual([sideOf("text", 0.9, 0.3), sideOf("text", 0.4, 0.9)], ["right", "bottom"]);
  assert.deepEqual([sideOf("column", 0.1, 0.9), sideOf("column", 0.8, 0.1)], ["left", "right"]);
});
