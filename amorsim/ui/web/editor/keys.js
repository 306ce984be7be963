// What keys and buttons of the Editor do.

import { tellKeys } from "../shared/dialogs.js";
import { numberIn } from "../shared/field.js";
import { showAdding } from "./adding.js";
import { askArray, mirror } from "./arrange.js";
import { remove } from "./clipboard.js";
import { openMenu } from "./context_menu.js";
import { run, save, saveAs, showText } from "./files.js";
import { KEYS } from "./layout.js";
import { play } from "./play.js";
import { MENU } from "./project.js";
import { holdSensor } from "./mounting.js";
import { TOUR } from "./tour.js";
import { beginTyping, keyTyped, showTyped } from "./typing.js";

/** @param {import("./editor.js").EditorPage} page */
export function listen(page) {
  const { parts, stage } = page;
  const { camera } = stage;
  for (const [name, button] of parts.tools) button.addEventListener("click", () => page.take(name));
  const clicks = {
    undo: () => page.step("undo"), redo: () => page.step("redo"), save: () => save(page), saveAs: () => saveAs(page), run: () => run(page), play: () => play(page),
    text: () => showText(page), duplicate: () => page.duplicate(), array: () => askArray(page), mirror: () => mirror(page), remove: () => remove(page), theme: () => page.toggleTheme(), keys: showKeys,
    in: () => camera.zoom(1.3), out: () => camera.zoom(1 / 1.3), all: () => stage.fit(),
  };
  for (const [name, does] of Object.entries(clicks)) parts[name].addEventListener("click", does);
  parts.add.addEventListener("click", () => showAdding(page));
  stage.pane.canvas.addEventListener("contextmenu", (event) => openMenu(page, event));
  parts.brush.value = String(page.brush);
  parts.brush.addEventListener("change", () => {
    const wide = numberIn(parts.brush.value);
    if (wide > 0 && wide <= 100) page.brush = wide;
    parts.brush.value = String(page.brush);
  });
  parts.menu.addEventListener("change", () => {
    const chosen = MENU.find(({ name }) => name === parts.menu.value);
    parts.menu.value = "";
    chosen?.does(page);
  });
  parts.grid.addEventListener("change", () => (page.grid = Number(parts.grid.value)));
  parts.mounts.addEventListener("change", () => holdSensor(page, parts.mounts.value));
  parts.doors.addEventListener("change", () => {
    page.door = parts.doors.value;
    page.showTool(page.tools.door);
  });
  parts.width.value = String(page.width);
  parts.width.addEventListener("change", () => {
    const width = numberIn(parts.width.value);
    if (width >= 0.05 && width <= 100) page.width = width;
    parts.width.value = String(page.width);
  });
  for (const name of ["length", "angle"]) {
    parts[name].addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => keyTyped(page, event));
    parts[name].addEventListener("input", () => showTyped(page));
  }
  globalThis.addEventListener("keydown", (event) => press(page, event));
}

/** @returns {Record<string, (() => void) | undefined>} */
const plain = (/** @type {import("./editor.js").EditorPage} */ page) => ({
  v: () => page.take("select"), h: () => page.take("hand"), w: () => page.take(page.state?.cells ? "cells" : "line"), p: () => page.take("polyline"),
  r: () => page.take("rectangle"), c: () => page.take(page.state?.cells ? "crop" : "circle"), b: () => page.take("brush"), e: () => page.take("eraser"), f: () => page.take("fill"), m: () => page.take("measure"), o: () => page.take("room"), d: () => page.take("door"), t: () => page.take("trim"),
  "+": () => page.stage.camera.zoom(1.3), "=": () => page.stage.camera.zoom(1.3), "-": () => page.stage.camera.zoom(1 / 1.3), 0: () => page.stage.fit(),
  g: () => {
    page.stage.options.grid = !page.stage.options.grid;
    page.stage.redraw();
  },
  a: () => page.isHolder && showAdding(page),
  l: () => page.toggleTheme(), "?": showKeys,
  Delete: () => page.isHolder && remove(page), Backspace: () => page.isHolder && remove(page),
  Escape: () => (page.toolName === "select" ? page.stage.selection.clear() : page.take("select")),
});

/** @returns {Record<string, (() => void) | undefined>} */
const withControl = (/** @type {import("./editor.js").EditorPage} */ page) => ({
  z: () => page.isHolder && page.step("undo"), y: () => page.isHolder && page.step("redo"), Z: () => page.isHolder && page.step("redo"), s: () => save(page), S: () => saveAs(page),
  c: () => page.copy(), x: () => page.isHolder && page.copy(true), v: () => page.isHolder && page.paste(), d: () => page.isHolder && page.duplicate(),
  a: () => page.stage.selection.set(page.stage.within([-Infinity, -Infinity, Infinity, Infinity])),
});

/** @param {import("./editor.js").EditorPage} page
 * @param {KeyboardEvent} event */
function press(page, event) {
  const target = /** @type {HTMLElement} */ (event.target);
  if (event.defaultPrevented || target.closest?.("dialog")) return;
  const isTyping = target.matches?.("input, textarea, select, [contenteditable], .code-editor");
  const { pane } = page.stage;
  if (event.ctrlKey || event.metaKey) {
    if (isTyping && event.key !== "s") return;
    const does = withControl(page)[event.key];
    if (!does) return;
    event.preventDefault();
    does();
    return;
  }
  if (isTyping || event.altKey) return;
  if (beginTyping(page, event.key)) {
    event.preventDefault();
    return;
  }
  /** @type {Record<string, (() => void) | undefined>} */
  const shifted = { ArrowLeft: () => pane.pan(60, 0), ArrowRight: () => pane.pan(-60, 0), ArrowUp: () => pane.pan(0, 60), ArrowDown: () => pane.pan(0, -60) };
  const does = (event.shiftKey && shifted[event.key]) || plain(page)[event.key];
  if (!does) return;
  event.preventDefault();
  does();
}

function showKeys() {
  tellKeys(KEYS, TOUR);
}
