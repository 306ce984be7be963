// Forms and the text of a scenario: numbers and units as they are shown, where a line is, and what may stand there.

import assert from "node:assert/strict";
import { pasted } from "../../../../amorsim/ui/web/editor/clipboard.js";
import { choicesAt } from "../../../../amorsim/ui/web/editor/completion.js";
import { tableAt } from "../../../../amorsim/ui/web/editor/table_at.js";
import { isChanged, limits, numberIn, shown, stateOf } from "../../../../amorsim/ui/web/shared/field.js";

Deno.test("angles are shown in degrees, and what begins like them is not", () => {
  assert.deepEqual(shown("rad"), ["°", 180 / Math.PI]);
  assert.deepEqual(shown("rad/s^2"), ["°/s²", 180 / Math.PI]);
  assert.deepEqual(shown("radio"), ["radio", 1]);
  assert.deepEqual(shown("m^2"), ["m²", 1]);
});

Deno.test("the bounds of a number are told in its unit", () => {
  const half = Math.PI / 2;
  assert.equal(limits({ low: 0, high: half, is_open: [true, false], unit: "rad" }), "> 0 and ≤ 90 °");
  assert.equal(limits({ low: 0.5, high: null, is_open: [false, false], unit: "m" }), "≥ 0.5 m");
  assert.equal(limits({ low: null, high: null, is_open: [false, false], unit: "m" }), "");
  assert.equal(limits({ low: 0, high: null, is_open: [true, false], unit: "×" }), "> 0");
});

Deno.test("a typed number may have a comma, or a minus of the typesetter's", () => {
  assert.deepEqual([" 1,5 ", "−2", "1e-3"].map(numberIn), [1.5, -2, 1e-3]);
  assert(["", "abc", "1.2.3"].map(numberIn).every(Number.isNaN));
});

Deno.test("a field is marked by where its value comes from", () => {
  const cases = [
    [{ fixed: "after the start" }, "fixed"], [{ is_given: true }, "changed"], [{ is_changed: false, drawn: true }, "drawn"],
    [{ origin: "model" }, "inherited"], [{ origin: "default" }, "default"], [{ is_changed: false, is_given: true, origin: "file" }, "own"],
  ];
  for (const [parameter, state] of cases) assert.equal(stateOf(parameter), state, JSON.stringify(parameter));
  assert.equal(isChanged({ is_changed: false, is_given: true }), false);
});

const TEXT = `[world]
map = "office"

[[robots]]
name = "a"
[robots.sensors.laser]
use = "laser"
range_max = 8
[[robots]]
name = "b"
model = "pioneer2dx"
[robots.sensors."laser"]
use = "laser"
`.split("\n");

Deno.test("a line belongs to the table whose header is above it", () => {
  const at = (line) => {
    const { path, keys } = tableAt(TEXT, line);
    return [path, ...keys];
  };
  assert.deepEqual(at(1), ["world"]);
  assert.deepEqual(at(4), ["robots.0"]);
  assert.deepEqual(at(7), ["robots.0.sensors.laser", "use"]);
  assert.deepEqual(at(9), ["robots.1", "model"]);
  assert.deepEqual(at(12), ["robots.1.sensors.laser"]);
  assert.equal(tableAt(["", "a = 1"], 0).path, "");
});

const SECTIONS = [
  { path: "robots.0.sensors.laser", title: "laser", use: { kind: "sensors", choices: ["laser", "sonar"] }, fields: [
    { path: "robots.0.sensors.laser.range_max", help: "longest range", widget: { unit: "m" } },
    { path: "robots.0.sensors.laser.traversal", help: "how", widget: { options: [{}, { choices: ["exact", "bresenham"] }] } },
    { path: "robots.0.sensors.laser.mount.x", help: "ahead", widget: {} },
  ] },
  { path: "robots.0.sensors.laser.mount", title: "where it sits", fields: [] },
];

/** An Editor whose server knows the first robot. */
function page() {
  const asked = [];
  const ask = (command) => {
    asked.push(command.path);
    return Promise.resolve(command.path === "robots.0" ? { ok: true, sections: SECTIONS } : { ok: false, error: "no such robot" });
  };
  return { asked, connection: { ask } };
}

Deno.test("keys are completed from the fields of their table, but those that it has", async () => {
  const found = await choicesAt(page(), TEXT, 7, "  tr");
  assert.equal(found.from, 2);
  assert.deepEqual(found.choices.map(({ text }) => text), ["range_max", "traversal", "mount"]);
  assert.equal(found.choices[0].help, "longest range · [m]");
});

Deno.test("values are completed where there is a choice", async () => {
  const texts = async (before) => (await choicesAt(page(), TEXT, 7, before))?.choices.map(({ text }) => text);
  assert.deepEqual(await texts('use = "la'), ['"laser"', '"sonar"']);
  assert.deepEqual(await texts('traversal = "'), ['"exact"', '"bresenham"']);
  assert.equal(await texts('range_max = "'), undefined);
  assert.equal(await texts("range_max = 8 #"), undefined);
});

Deno.test("a robot that is only being written is completed like the first one", async () => {
  const editor = page();
  const found = await choicesAt(editor, TEXT, 12, "ra");
  assert.deepEqual(editor.asked, ["robots.1", "robots.0"]);
  assert.deepEqual(found.choices.map(({ text }) => text), ["use", "range_max", "traversal", "mount"]);
});

Deno.test("headers are completed from the tables that a scenario may have", async () => {
  const found = await choicesAt(page(), TEXT, 12, "[[ro");
  assert.equal(found.from, 0);
  assert(found.choices.some(({ text }) => text === "[[robots]]") && found.choices.some(({ text }) => text === "[world]"));
});

Deno.test("copies have names of their own, and are shifted with all that belongs to them", () => {
  const thing = { kind: "robot", name: "rover", path: "robots.0", pose: [1, 2, 0.5], places: [{ path: "robots.0.motion.path" }] };
  const table = { name: "rover", pose: { x: 1, y: 2, heading_deg: 30 }, motion: { path: [[0, 0], [1, 1]] } };
  const clip = { things: [{ list: "robots", table, thing }], walls: [[0, 0, 1, 0]], count: 2, folder: "" };
  const [robot, walls] = pasted([{ kind: "robot", name: "rover" }, { kind: "robot", name: "rover2" }], clip, [0.5, -1]);
  assert.deepEqual(robot, { op: "add", path: "robots", value: { name: "rover3", pose: { x: 1.5, y: 1, heading_deg: 30 }, motion: { path: [[0.5, -1], [1.5, 0]] } } });
  assert.deepEqual(walls, { op: "walls", add: [[0.5, -1, 1.5, -1]] });
  assert.equal(table.name, "rover"); // what was copied stays
});

Deno.test("a landmark that is pasted has the next number", () => {
  const clip = { things: [{ list: "landmarks", table: { id: 3, x: 0, y: 1 }, thing: { kind: "landmark", name: "landmark 3" } }], walls: [], folder: "sub" };
  const [landmark] = pasted([{ kind: "landmark", name: "landmark 7" }], clip, [1, 1]);
  assert.deepEqual(landmark, { op: "add", path: "landmarks", value: { id: 8, x: 1, y: 2 }, folder: "sub" });
});
