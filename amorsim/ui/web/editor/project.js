// The project: other scenarios, the world as a file or from a generator, pictures, and all of it as a zip.

import { askName, open, tell } from "../shared/dialogs.js";
import { download } from "../shared/capture.js";
import { h, say } from "../shared/dom.js";
import { numberIn } from "../shared/field.js";
import { askUnderlay } from "./underlay.js";
import { saveAs } from "./files.js";
import { showGallery } from "./gallery.js";

/** What the menu offers. */
export const MENU = [
  { name: "open", words: "open or begin another…", does: openOther },
  { name: "saveAs", words: "save as…", does: saveAs },
  { name: "world", words: "take another world…", does: askWorld },
  { name: "writeWorld", words: "save the world as…", does: askFormat },
  { name: "makeLines", words: "make the walls a file to draw in…", does: (/** @type {import("./editor.js").EditorPage} */ page) => askLines(page) },
  { name: "underlay", words: "a picture to trace from…", does: askUnderlay },
  { name: "png", words: "the world as a picture (PNG)", does: (/** @type {import("./editor.js").EditorPage} */ page) => picture(page, "png") },
  { name: "svg", words: "the world as lines (SVG)", does: (/** @type {import("./editor.js").EditorPage} */ page) => picture(page, "svg") },
  { name: "zip", words: "the scenario with its files (zip)", does: zip },
];

const bytesOf = (/** @type {string} */ text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
const stem = (/** @type {import("./editor.js").EditorPage} */ page) => page.state.name.replace(/\.toml$/, "");

/** Open another scenario, on a page of its own.
 * @param {import("./editor.js").EditorPage} page */
async function openOther(page) {
  const said = await page.connection.ask({ do: "others" });
  if (!said.ok) return;
  const go = async (/** @type {string} */ name) => {
    const opened = await page.connection.ask({ do: "open", name });
    if (opened.ok) location.assign(opened.path);
    else tell("It cannot be opened", h("p", { class: "error" }, opened.error));
  };
  const entries = (/** @type {string[]} */ names) => names.map((name) => ({ name, of: /** @type {[string, string]} */ (["scenario", name]), does: () => go(name) }));
  showGallery(page, "Open", [
    { title: "New", entries: [{ name: "an empty page", sentence: "Draw a world, place robots.", does: () => go("") }] },
    { title: "Last", entries: entries(said.recent) },
    { title: "In this folder", entries: entries(said.files) },
    { title: "Bundled: a copy", entries: entries(said.bundled) },
  ]);
}

/** Take a random world of a generator in place of this one.
 * @param {import("./editor.js").EditorPage} page
 * @param {string} name
 * @param {number} seed */
export async function takeGenerated(page, name, seed) {
  const done = await page.edit(`take ${name} as the world`, [{ op: "set", path: "world", value: { map: { generate: name, seed } } }]);
  if (!done.ok) return done;
  page.choose(["world"]);
  page.fitsNext = true;
  return done;
}

/** Another world: a file of the project, a random one of a generator, or an empty one.
 * @param {import("./editor.js").EditorPage} page */
async function askWorld(page) {
  const said = await page.connection.ask({ do: "worlds" });
  const menu = await page.connection.ask({ do: "menu" });
  if (!said.ok || !menu.ok) return;
  const problem = h("p", { class: "error", role: "alert" });
  const choice = h("select", {},
    h("optgroup", { label: "random, of a generator" }, menu.world_generator.map((/** @type {string} */ name) => h("option", { value: `generate ${name}` }, name))),
    h("optgroup", { label: "a file of this folder" }, said.files.map((/** @type {string} */ name) => h("option", { value: `file ${name}` }, name))));
  const seed = h("input", { type: "text", inputmode: "numeric", autocomplete: "off", value: "1" });
  const seedRow = h("label", { class: "asked" }, h("span", {}, "seed: another number is another world"), seed);
  choice.addEventListener("change", () => (seedRow.hidden = choice.value.startsWith("file ")));
  const take = async () => {
    const [kind, ...rest] = choice.value.split(" ");
    const name = rest.join(" ");
    const number = numberIn(seed.value);
    if (kind === "generate" && !(Number.isInteger(number) && number >= 0)) {
      say(problem, "Expected a whole number as seed.");
      return;
    }
    const done = await (kind === "generate" ? takeGenerated(page, name, number) : page.edit(`take ${name} as the world`, [{ op: "set", path: "world", value: { map: name } }]));
    if (!done.ok) {
      say(problem, done.error);
      return;
    }
    dialog.close();
    page.choose(["world"]);
    page.fitsNext = true;
  };
  const dialog = open(
    "Another world",
    h("div", {}, h("label", { class: "asked" }, h("span", {}, "world"), choice), seedRow, h("p", { class: "note" }, "The generator's parameters are then in the inspector of “world”. Things with a fixed place keep it."), problem),
    [h("button", { onclick: () => dialog.close() }, "cancel"), h("button", { class: "main", onclick: take }, "take")],
  );
}

/** Save the world in a format, after saying what is lost.
 * @param {import("./editor.js").EditorPage} page */
export async function askFormat(page) {
  const menu = await page.connection.ask({ do: "menu" });
  const ending = page.wallsFixed ? "wld" : "png";
  askName("Save the world as", "file", `${stem(page)}-world.${ending}`, `the ending tells the format: ${(menu.writers ?? []).join(", ")}`, async (name) => {
    const tried = await page.connection.ask({ do: "write_world", name, is_trial: true });
    if (tried.ok) confirmWorld(page, name, tried);
    return tried;
  });
}

/** @param {import("./editor.js").EditorPage} page
 * @param {string} name
 * @param {any} tried */
function confirmWorld(page, name, { words }) {
  const problem = h("p", { class: "error", role: "alert" });
  const write = async (/** @type {any} */ use) => {
    const said = await page.connection.ask({ do: "write_world", name, is_trial: false, use });
    if (!said.ok) {
      say(problem, said.error);
      return;
    }
    page.hint(`saved ${said.file}`);
    dialog.close();
  };
  const dialog = open(`${name}: what the format keeps`, h("div", {}, h("ul", {}, words.map((/** @type {string} */ one) => h("li", {}, one))), problem), [
    h("button", { onclick: () => dialog.close() }, "cancel"),
    h("button", { onclick: () => write(false) }, "save it"),
    h("button", { class: "main", onclick: () => write(true) }, "save it and take it as the world"),
  ]);
}

/** Make the walls of a world of any kind a file that can be drawn in, after saying what is lost; then take a tool.
 * @param {import("./editor.js").EditorPage} page
 * @param {string} tool */
export async function askLines(page, tool = "line") {
  const body = h("div", {}, h("p", { role: "status" }, "Reading the walls …"));
  const cancel = h("button", { onclick: () => dialog.close() }, "cancel");
  const make = h("button", { class: "main", disabled: true }, "make the walls a file");
  const dialog = open("Draw in these walls", body, [cancel, make]);
  const tried = await page.connection.ask({ do: "make_lines", is_trial: true });
  if (!dialog.open) return; // the user did not wait
  const problem = h("p", { class: "error", role: "alert" });
  if (!tried.ok) {
    body.replaceChildren(problem);
    say(problem, tried.error);
    return;
  }
  body.replaceChildren(
    h("p", {}, `${page.wallsFixed[0].toUpperCase()}${page.wallsFixed.slice(1)}.`),
    h("p", {}, `Its walls as they are now become ${tried.file}, the world of this scenario. Undo takes that back.`),
    h("ul", {}, tried.words.map((/** @type {string} */ one) => h("li", {}, one))), problem);
  make.disabled = false;
  make.addEventListener("click", async () => {
    const said = await page.connection.ask({ do: "make_lines", is_trial: false });
    if (!said.ok) {
      say(problem, said.error);
      return;
    }
    dialog.close();
    page.wantedTool = tool;
    page.hint(`the walls are in ${said.file} now, which is written when you save`);
  });
}

/** @param {import("./editor.js").EditorPage} page
 * @param {string} kind */
async function picture(page, kind) {
  const said = await page.connection.ask({ do: "picture", kind });
  if (said.ok) download(new Blob([bytesOf(said.data)], { type: kind === "png" ? "image/png" : "image/svg+xml" }), `${stem(page)}.${kind}`);
  else page.hint(said.error);
}

/** @param {import("./editor.js").EditorPage} page */
async function zip(page) {
  const said = await page.connection.ask({ do: "zip" });
  if (said.ok) download(new Blob([bytesOf(said.zip)], { type: "application/zip" }), `${stem(page)}.zip`);
  else page.hint(said.error);
}

/** Save a robot as a model, or a sensor of it as a device.
 * @param {import("./editor.js").EditorPage} page
 * @param {string} path of the robot
 * @param {string} sensor */
export function askModel(page, path, sensor = "") {
  const what = sensor || page.stage.things.find((thing) => thing.path === path)?.name || "robot";
  askName(sensor ? "Save as a device" : "Save as a model", "file", `${what}-${sensor ? "device" : "model"}.toml`, "the file holds only what differs from the parent model", async (name) => {
    const said = await page.connection.ask({ do: "save_model", path, sensor, name });
    if (said.ok) tell(`saved ${said.file}`, h("pre", { class: "difference", tabindex: "0" }, said.text), h("p", { class: "note" }, `Take it with model = "${said.file}".`));
    return said;
  });
}
