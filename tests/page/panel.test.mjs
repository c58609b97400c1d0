// What forms make of values: changes and differences, and which modules fit a robot.
import assert from "node:assert/strict";
import { test } from "node:test";
import { applied, differences } from "page/panel/changes";
import { begun, drivenParts, fits, partsNamed, readingsOf, robotAt, suggested } from "page/panel/offers";

const set = (path, value) => ({ op: "set", path, value });

test("changes put values in, with the mappings on the way, and take them out again", () => {
  assert.deepEqual(applied({}, [set(["drivers", "r", "avoidance"], true)]), { drivers: { r: { avoidance: true } } });
  assert.deepEqual(applied({ a: 1, b: 2 }, [{ op: "unset", path: ["a"] }, { op: "unset", path: ["none", "deeper"] }]), { b: 2 });
  const points = applied({ p: [[1, 2], [3, 4]] }, [{ op: "add", path: ["p"], value: [5, 6] }, { op: "remove", path: ["p", 0] }, set(["p", 1], [7, 8])]);
  assert.deepEqual(points, { p: [[3, 4], [7, 8]] });
  assert.deepEqual(applied({ b: 1, a: 2 }, [set(["b"], 3)]), { b: 3, a: 2 });
  assert.deepEqual(Object.keys(applied({ b: 1, a: 2 }, [set(["b"], 3)])), ["b", "a"]);
});

test("a value does not change by changes of its copy", () => {
  const value = Object.freeze({ drivers: Object.freeze({}) });
  applied(value, [set(["drivers", "r"], {})]);
  assert.deepEqual(value, { drivers: {} });
});

test("differences are the fewest keys, but another module is written as a whole", () => {
  const before = { seconds: 20, drivers: { r: { estimator: { use: "a:A", gate: 3 } } } };
  assert.deepEqual(differences(["run"], before, before), []);
  const gate = applied(before, [set(["drivers", "r", "estimator", "gate"], 4)]);
  assert.deepEqual(differences(["run"], before, gate), [set(["run", "drivers", "r", "estimator", "gate"], 4)]);
  const other = applied(before, [set(["drivers", "r", "estimator"], { use: "b:B" })]);
  assert.deepEqual(differences(["run"], before, other), [set(["run", "drivers", "r", "estimator"], { use: "b:B" })]);
  assert.deepEqual(differences(["run"], before, { drivers: before.drivers }), [{ op: "unset", path: ["run", "seconds"] }]);
});

test("differences applied give the other value", () => {
  const values = [{}, { a: { b: 1 } }, { a: { b: 1, c: [1] } }, { a: 2 }, { a: { use: "x", k: 1 } }, { a: { use: "y" }, z: null }];
  for (const one of values) for (const other of values) assert.deepEqual(applied(one, differences([], one, other)), other);
});

const offer = (use, needs, properties = {}, required = []) => ({ use: `mjsim.algorithms.${use}`, title: use, about: "", needs, parts: [], options: { properties, required } });
const MODULES = {
  observers: [offer("eyes:Eyes", ["cameras"], { camera: { default: "front" } })],
  estimators: [offer("ekf:Ekf", ["sightings"]), offer("scan:Scan", ["scans"])],
  navigators: [offer("explore:Explore", ["scans"]), offer("wander:Wander", [])],
  avoidances: [],
  controllers: [],
  sensors: { camera: "cameras", lidar: "scans", beacons: "sightings" },
  faults: {},
  programs: [],
};
/** Fields of options as a form has them: key, kind, fallback and whether it is required. */
const BOOK = {
  fields: ({ properties, required }) => Object.entries(properties).map(([key, node]) => ({ key, kind: { is: "text" }, fallback: node.default, required: required.includes(key) })),
  fresh: (_, key) => key,
};
const robot = (...sensors) => ({ type: "Robot", name: "r", values: { sensors } });

test("a module fits by one of the readings that it needs; a camera allows sightings", () => {
  const given = readingsOf(robot({ camera: "eye" }), MODULES);
  assert.deepEqual([...MODULES.estimators, ...MODULES.navigators].map((one) => fits(one, given)), [true, false, false, true]);
  assert.deepEqual([...readingsOf(null, MODULES)], []);
});

test("a module that refuses a robot without an arm, or a drive of a kind, fits only those that have it", () => {
  const kinds = [{ type: "mecanum" }, { type: "user", max_left: 0.3 }, { type: "user", max_left: 0 }, { type: "balancing" }, null];
  const having = kinds.map((drive) => readingsOf({ ...robot(), values: { drive } }, MODULES));
  const fitting = (part) => having.map((given) => fits({ needs: [], parts: [part] }, given));
  assert.deepEqual(fitting("max_left"), [true, true, false, false, false]);
  assert.deepEqual(fitting("balancing"), [false, false, false, true, false]);
  const armed = readingsOf({ ...robot({ camera: "eye" }), values: { arms: [{ name: "left" }] } }, MODULES);
  assert.deepEqual([fits({ needs: ["cameras"], parts: ["arms"] }, armed), fits({ needs: [], parts: ["arms"] }, armed)], [false, true]);
});

test("what fits is suggested by the sensors, and takes a camera by its name", () => {
  const uses = (values) => Object.fromEntries(Object.entries(values).map(([role, value]) => [role, value.use?.replace("mjsim.algorithms.", "") ?? value]));
  const seeing = suggested(robot({ camera: "eye" }), true, MODULES, BOOK);
  assert.deepEqual(uses(seeing), { observer: "eyes:Eyes", estimator: "ekf:Ekf", navigator: "wander:Wander", avoidance: true });
  assert.equal(seeing.observer.camera, "eye");
  const both = robot({ camera: "front" }, { lidar: "scan" });
  assert.equal(suggested(both, true, MODULES, BOOK).observer.camera, undefined);
  assert.deepEqual(uses(suggested(both, false, MODULES, BOOK)), { estimator: "scan:Scan", navigator: "explore:Explore", avoidance: true });
  assert.deepEqual(uses(suggested(robot(), true, MODULES, BOOK)), { navigator: "wander:Wander", avoidance: true });
});

test("what a module requires is begun with, by the name of a part where it is one", () => {
  const needing = offer("pick:Pick", [], { arm: {}, picture: {} }, ["arm", "picture"]);
  const armed = { ...robot(), values: { arms: [{ name: "left" }], drive: { type: "balancing" } } };
  assert.deepEqual(begun(needing, armed, BOOK), { use: needing.use, arm: "left", picture: "picture" });
  assert.deepEqual(partsNamed(robot({ camera: "eye" }, { lidar: "scan" }), "camera"), ["eye"]);
  assert.deepEqual(drivenParts(armed), ["drive", "left"]);
});

test("a driver belongs to the robot of its name", () => {
  const one = robot();
  assert.equal(robotAt(["run", "drivers", "r", "observer"], [one]), one);
  assert.equal(robotAt(["run", "drivers", "s", "observer"], [one]), null);
  assert.equal(robotAt(["mechanisms", 0], [one]), null);
});
