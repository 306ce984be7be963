// What the page says of the pen and of files that something else has changed, and which tools there are.

import { tell } from "../shared/dialogs.js";
import { h, say, there } from "../shared/dom.js";

export const WALL_TOOLS = ["line", "polyline", "rectangle", "circle", "room", "door", "trim"];
const PAINT_TOOLS = ["brush", "eraser", "cells", "fill", "crop"];

/** The tools for the world as it is: of lines, or a bitmap.
 * @param {import("./editor.js").EditorPage} page */
export function showTools(page) {
  const { parts, state, watching } = page;
  for (const name of WALL_TOOLS) {
    there(parts.tools.get(name)).disabled = watching;
    there(parts.tools.get(name)).hidden = Boolean(state.cells);
  }
  for (const name of PAINT_TOOLS) {
    there(parts.tools.get(name)).disabled = watching;
    there(parts.tools.get(name)).hidden = !state.cells;
  }
  if (page.wantedTool && !state.walls_fixed && !watching) {
    page.take(page.wantedTool); // for which the walls were made a file
    page.wantedTool = "";
  } else if (WALL_TOOLS.includes(page.toolName ?? "") && (state.walls_fixed || state.cells)) page.take("select");
}

/** Show which window holds the pen, and the button that asks for it.
 * @param {import("./editor.js").EditorPage} page */
export function showPen(page) {
  const { pen } = page.parts;
  const asking = page.state.asking ?? [];
  pen.hidden = Boolean(page.playing) || (page.isHolder && !asking.length);
  say(pen, page.isHolder ? "give the pen" : asking.includes(page.window) ? "asked for the pen" : page.state.holder ? "ask for the pen" : "take the pen");
  pen.onclick = () => page.connection.ask({ do: "controls", want: page.isHolder ? "give" : page.state.holder ? "ask" : "take" });
}

/** Show which files another program has changed, and what can be done about it.
 * @param {import("./editor.js").EditorPage} page */
export function showOutside(page) {
  const { changed_outside: changed, gone_outside: gone, remark, is_saved: isSaved } = page.state;
  const key = `${changed.join()}|${gone.join()}|${remark}|${isSaved}`;
  if (key === page.outside) return;
  page.outside = key;
  if (!changed.length && !remark) {
    page.warn("");
    return;
  }
  const act = (/** @type {object} */ command) => async () => {
    const said = await page.connection.ask(command);
    if (!said.ok) page.hint(said.error);
  };
  if (!changed.length) {
    page.warn(
      `${remark[0].toUpperCase()}${remark.slice(1)}.`,
      isSaved ? "" : h("button", { class: "tool holders-only", onclick: act({ do: "reload" }) }, "begin without them"),
      h("button", { class: "tool holders-only", onclick: act({ do: "heard" }) }, "go on"),
    );
    return;
  }
  const others = changed.filter((/** @type {string} */ name) => !gone.includes(name));
  const happened = [[others, "changed"], [gone, "deleted"]]
    .filter(([names]) => names.length)
    .map(([names, what]) => `${names.join(" and ")} ${names.length > 1 ? "were" : "was"} ${what} by something else`);
  page.warn(
    `${happened.join("; ")}.`,
    h("button", { class: "tool", onclick: () => showDifference(page) }, "difference"),
    others.length ? h("button", { class: "tool holders-only", onclick: act({ do: "reload" }) }, "reload the file") : "",
    h("button", { class: "tool holders-only", onclick: act({ do: "save", force: true }) }, "keep mine"),
  );
}

/** The lines by which the file and what is edited differ.
 * @param {import("./editor.js").EditorPage} page */
async function showDifference(page) {
  const said = await page.connection.ask({ do: "difference" });
  if (!said.ok) {
    page.hint(said.error);
    return;
  }
  /** @type {Record<string, string>} */
  const kinds = { "+": "added", "-": "taken", "@": "where" };
  const lines = said.text.split("\n").map((/** @type {string} */ line) => h("span", { class: kinds[line[0]] ?? "" }, `${line}\n`));
  tell("The file now, and what is here", h("p", { class: "note" }, "− is in the file now, + is here"), h("pre", { class: "difference", tabindex: "0" }, said.text ? lines : "they say the same"));
}
