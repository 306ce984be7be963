// Many things of one table: how many, on a grid or at random in a box that is drawn.

import { open } from "../shared/dialogs.js";
import { h, say } from "../shared/dom.js";
import { numberIn } from "../shared/field.js";
import { round } from "./geometry.js";
import { freeName, walking } from "./things.js";

const MOST = 10_000;

/** Ask how many there are to be in a box, and how they stand; the new table is one step.
 * @param {import("./editor.js").EditorPage} page
 * @param {any} kind
 * @param {number[]} box */
export function askFleet(page, kind, box) {
  const [x0, y0, x1, y1] = box;
  const problem = h("p", { class: "error", role: "alert" });
  const model = h("select", {}, (kind.models ?? []).map((/** @type {string} */ name) => h("option", { value: name }, name)));
  const modelOf = (/** @type {string} */ note) => note.split(",")[0];
  const usual = page.stage.things.filter(({ kind: one }) => one === "robot").map(({ note }) => modelOf(note)).find((name) => kind.models?.includes(name));
  model.value = usual ?? "pioneer2dx"; // as those that are there
  const count = h("input", { type: "text", inputmode: "numeric", autocomplete: "off", value: "10" });
  const stands = h("select", {}, h("option", { value: "random" }, "at random"), h("option", { value: "grid" }, "on a grid"));
  const row = (/** @type {string} */ label, /** @type {HTMLElement} */ input) => h("label", { class: "asked" }, h("span", {}, label), input);
  const make = async () => {
    const many = numberIn(count.value);
    if (!(Number.isInteger(many) && many >= 1 && many <= MOST)) {
      say(problem, `Expected a whole number from 1 to ${MOST}.`);
      return;
    }
    const said = await page.edit(`add ${many} × ${kind.what}`, [{ op: "add", path: kind.path, value: { ...kind.table(model.value, page.stage.things, box), count: many, start: start(box, many, stands.value) } }]);
    if (!said.ok) {
      say(problem, said.error);
      return;
    }
    dialog.close();
    page.choose(said.added);
  };
  const dialog = open(
    `Many in a box of ${round(x1 - x0)} × ${round(y1 - y0)} m`,
    h("div", {}, kind.models ? row("robots of the model", model) : "", row("how many", count), row("they stand", stands), problem),
    [h("button", { onclick: () => dialog.close() }, "cancel"), h("button", { class: "main", onclick: make }, "make")],
  );
  count.select();
}

/** How many start in a box: drawn at random, or from its lower left corner in rows that fill it.
 * @param {number[]} box
 * @param {number} count
 * @param {string} how */
export function start([x0, y0, x1, y1], count, how) {
  if (how === "random") return { random: [x0, y0, x1, y1] };
  // The widest spacing with which so many still fit, with one in each corner where they fill the box.
  const [wide, high] = [x1 - x0, y1 - y0];
  let [spacing, columns] = [0, 1];
  for (let across = 1; across <= count; across++) {
    const up = Math.ceil(count / across);
    const gap = Math.min(across > 1 ? wide / (across - 1) : Infinity, up > 1 ? high / (up - 1) : Infinity);
    if (gap > spacing) [spacing, columns] = [gap, across];
  }
  return { grid: [x0, y0], spacing: Number.isFinite(spacing) ? Math.max(0.01, Math.floor(spacing * 100) / 100) : 1, columns };
}

/** The kinds of which there can be many.
 * @param {string[]} models */
export const fleetKinds = (models) => [
  {
    group: "Many", label: "fleet of robots…", what: "robots", path: "robots", isMany: true, models,
    table: (/** @type {string} */ model, /** @type {import("./stage.js").Thing[]} */ things) => ({ name: freeName("fleet", things), model }),
  },
  {
    group: "Many", label: "field of posts…", what: "posts", path: "obstacles", isMany: true,
    table: (/** @type {string} */ _, /** @type {import("./stage.js").Thing[]} */ things) => ({ name: freeName("posts", things), shape: { circle: 0.15 } }),
  },
  {
    group: "Many", label: "crowd of people…", what: "people", path: "obstacles", isMany: true,
    table: (/** @type {string} */ _, /** @type {import("./stage.js").Thing[]} */ things, /** @type {number[]} */ [x0, y0, x1, y1]) => ({ name: freeName("people", things), shape: { circle: 0.22 }, motion: walking([[x0, (y0 + y1) / 2], [x1, (y0 + y1) / 2]]) }),
  },
];
