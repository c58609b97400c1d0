// How large views share their place.
import assert from "node:assert/strict";
import { test } from "node:test";
import { kept, keysOf, layoutIn, layoutText, placed, placedBeside, shareOf, sideAt } from "page/ui/docking";

const TWO = { way: "row", parts: ["plan", "scene"] };

test("a view that is dropped at an edge of another splits it there", () => {
  assert.deepEqual(placed("plan", "scene", "plan", "right"), TWO);
  assert.deepEqual(placed("scene", "plan", "scene", "left"), TWO);
  assert.deepEqual(placed(TWO, "eye", "scene", "bottom"), {
    way: "row",
    parts: ["plan", { way: "column", parts: ["scene", "eye"] }],
  });
  assert.deepEqual(placed(TWO, "plan", "scene", "top"), { way: "column", parts: ["plan", "scene"] });
});

test("in the middle it takes the place of the other, and nothing changes over itself", () => {
  assert.deepEqual(placed(TWO, "eye", "plan", "middle"), { way: "row", parts: ["eye", "scene"] });
  assert.equal(placed(TWO, "plan", "scene", "middle"), "plan");
  assert.equal(placed(TWO, "plan", "plan", "left"), TWO);
});

test("of any drops no view comes twice, none but the one in the middle goes, and all is read back", () => {
  const [names, sides] = ["abcdef".split(""), ["left", "right", "top", "bottom", "middle"]];
  let [layout, seed] = ["a", 1];
  const any = (list) => list[(seed = (seed * 48271) % 2147483647) % list.length];
  for (let k = 0; k < 500; k++) {
    const [key, at, side] = [any(names), any(keysOf(layout)), any(sides)];
    const wanted = new Set([...keysOf(layout), key]);
    if (side === "middle" && key !== at) wanted.delete(at);
    layout = placed(layout, key, at, side);
    assert.deepEqual(keysOf(layout).sort(), [...wanted].sort());
    assert.deepEqual(layoutIn(layoutText(layout)), layout);
  }
});

test("what is not there leaves its place to its neighbour", () => {
  const three = placed(TWO, "eye", "scene", "bottom");
  assert.deepEqual(kept(three, (key) => key !== "scene"), { way: "row", parts: ["plan", "eye"] });
  assert.equal(kept(three, (key) => key === "eye"), "eye");
  assert.equal(kept(three, () => false), null);
});

test("what was kept before there were splits is read, and what is no layout is not", () => {
  assert.deepEqual(layoutIn("plan scene"), TWO);
  assert.equal(layoutIn("plan"), "plan");
  for (const text of [null, "", "{", '{"way":"row","parts":["a"]}', '{"way":"up","parts":["a","b"]}', '{"way":"row","parts":["a","a"]}'])
    assert.equal(layoutIn(text), null);
});

test("the nearest edge of a view counts in its outer thirds", () => {
  assert.deepEqual(
    [[0.1, 0.5], [0.9, 0.5], [0.5, 0.1], [0.5, 0.9], [0.5, 0.5], [0.2, 0.1]].map(([x, y]) => sideAt(x, y)),
    ["left", "right", "top", "bottom", "middle", "top"],
  );
});

test("a view that is put to a side of all others has the share of one", () => {
  let layout = "plan";
  for (const key of ["noise", "events", "plot"]) layout = placedBeside(layout, key, "left");
  assert.deepEqual(keysOf(layout), ["plot", "events", "noise", "plan"]);
  assert.equal(shareOf(layout), 25);
  const wide = placedBeside(layout, "charts", "bottom");
  assert.deepEqual([wide.way, shareOf(wide)], ["column", 50]);
  assert.equal(shareOf(placedBeside(wide, "noise", "right")), 75); // three of four columns
  assert.equal(placedBeside("plan", "plan", "top"), "plan");
});
