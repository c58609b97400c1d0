// Sentences of the server in another language, by template and values.
import assert from "node:assert/strict";
import { test } from "node:test";
import { filled, learn, spoken } from "page/words/sentences";

const ANSWER = {
  error: "no robot 'r3'; did you mean 'r2'?",
  sentences: {
    "no robot 'r3'; did you mean 'r2'?": ["no robot '{robot}'{meant}", { robot: "r3", meant: "; did you mean 'r2'?" }],
    "; did you mean 'r2'?": ["; did you mean '{word}'?", { word: "r2" }],
    "write {at: [x, y]} for 3": ["write {{at: [x, y]}} for {count}", { count: "3" }],
  },
};
const GERMAN = {
  "no robot '{robot}'{meant}": "kein Roboter „{robot}“{meant}",
  "; did you mean '{word}'?": "; etwa „{word}“?",
  "write {{at: [x, y]}} for {count}": "für {count} {{at: [x, y]}} schreiben",
  "the run is over; start it again": "der Lauf ist vorbei; noch einmal starten",
};
const lookup = (template) => GERMAN[template];

test("a sentence is looked up by its template, and so are the sentences in it", () => {
  const known = new Map();
  learn(known, ANSWER);
  assert.equal(spoken(ANSWER.error, known, lookup), "kein Roboter „r3“; etwa „r2“?");
  assert.equal(spoken("write {at: [x, y]} for 3", known, lookup), "für 3 {at: [x, y]} schreiben");
  assert.equal(spoken("the run is over; start it again", known, lookup), GERMAN["the run is over; start it again"]);
  assert.equal(spoken("something new", known, lookup), "something new");
});

test("what a value holds is taken for no template, name, brace or pattern", () => {
  const hostile = ["{robot}", "{{x}}", "}}{{", "$&", "$1", "%s", "<b>x</b>", "a\nb", "\u202eb", "__proto__", "constructor"];
  for (const robot of [...hostile, "x".repeat(10_000)]) {
    const known = new Map();
    const english = `no robot '${robot}'`;
    learn(known, JSON.parse(JSON.stringify({ sentences: { [english]: ["no robot '{robot}'{meant}", { robot, meant: "" }] } })));
    assert.equal(spoken(english, known, lookup), `kein Roboter „${robot}“`);
  }
});

test("sentences that came longest ago are forgotten, an answer without any is none", () => {
  const known = new Map();
  const answer = (k) => ({ sentences: { [`a ${k}`]: ["a {k}", { k: String(k) }] } });
  for (let k = 0; k < 6000; k += 1) {
    learn(known, answer(0));
    learn(known, answer(k));
  }
  assert.equal(known.size, 5000);
  assert.ok(known.has("a 0") && known.has("a 5999") && !known.has("a 1"));
  for (const answer of [null, undefined, "text", [1], {}]) learn(known, answer);
  assert.equal(known.size, 5000);
});

test("a name without a value stays as it is", () => {
  assert.equal(filled("{a} and {b}", { a: 0, b: null }), "0 and {b}");
});
