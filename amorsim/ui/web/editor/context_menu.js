// The menu of what lies under the pointer: the secondary button, a long press, or the menu key.

import { h, there } from "../shared/dom.js";
import { showAdding } from "./adding.js";
import { askArray, mirror } from "./arrange.js";
import { askNumbers } from "./ask_numbers.js";
import { lastCopy, paste, remove } from "./clipboard.js";
import { askOffset, askTurn, splitWalls } from "./reshape.js";

/** @typedef {{words: string, keys?: string, does: () => void}} Item */

/** What can be done at a place with what is selected; groups are parted by a line.
 * @param {import("./editor.js").EditorPage} page
 * @param {import("../shared/tool.js").Place} place
 * @returns {Item[][]} */
function itemsAt(page, place) {
  const { stage } = page;
  const some = stage.selection.things.some((one) => one.kind !== "settings");
  const view = [
    { words: "select all", keys: "Ctrl + A", does: () => stage.selection.set(stage.within([-Infinity, -Infinity, Infinity, Infinity])) },
    { words: "see all", keys: "0", does: () => stage.fit() },
  ];
  if (page.watching) return [view];
  /** @type {Item[]} */
  const here = [{ words: "add here …", does: () => showAdding(page, place) }];
  if (lastCopy() ?? page.clip) here.push({ words: "paste here", keys: "Ctrl + V", does: () => paste(page, place) });
  if (!some) return [here, view];
  /** @type {Item[]} */
  const own = [{ words: "its values", does: () => /** @type {HTMLElement | null} */ (page.inspector.element.querySelector("input, select, button, textarea"))?.focus() }];
  const sized = stage.grips().find(({ asks, shape }) => asks && shape === "round");
  if (sized && stage.chosenThings.length === 1) own.push({ words: "size …", keys: "double click on a grip", does: () => askNumbers(page, there(sized.asks)) });
  own.push({ words: "turn …", keys: "[ ]", does: () => askTurn(page) });
  const walls = stage.chosenWalls.length && !page.wallsFixed
    ? [{ words: "split", does: () => splitWalls(page) }, { words: "offset …", does: () => askOffset(page) }]
    : [];
  const copies = [
    { words: "copy", keys: "Ctrl + C", does: () => page.copy() },
    { words: "cut", keys: "Ctrl + X", does: () => page.copy(true) },
    { words: "duplicate", keys: "Ctrl + D", does: () => page.duplicate() },
    { words: "copies in rows …", does: () => askArray(page) },
    { words: "mirror", does: () => mirror(page) },
  ];
  return [own, walls, copies, here, view, [{ words: "delete", keys: "Delete", does: () => remove(page) }]].filter((group) => group.length);
}

/** Open the menu on the canvas.
 * @param {import("./editor.js").EditorPage} page
 * @param {MouseEvent} event */
export function openMenu(page, event) {
  event.preventDefault();
  document.querySelector(".context-menu")?.remove();
  const { pane, selection } = page.stage;
  const isByKey = event.button !== 2 && /** @type {PointerEvent} */ (event).pointerType !== "touch";
  const place = isByKey ? pane.keyPlace : pane.placeOf(event);
  pane.cancel();
  if (page.toolName !== "select") page.take("select");
  const found = page.stage.at(place);
  if (found && !selection.has(found.kind, found.key)) selection.set([found]);
  else if (!found && !isByKey) selection.clear();
  /** @type {HTMLElement[]} */
  const buttons = [];
  const groups = itemsAt(page, place).map((items) =>
    h("div", { role: "group" }, items.map(({ words, keys, does }) => {
      const button = h("button", { role: "menuitem", tabindex: "-1", onclick: () => {
        close();
        does();
      } }, h("span", {}, words), h("span", { class: "keys" }, keys ?? ""));
      buttons.push(button);
      return button;
    })),
  );
  const menu = h("div", { class: "context-menu", role: "menu", "aria-label": found ? found.title : "drawing" }, groups);
  const box = pane.canvas.getBoundingClientRect();
  page.root.append(menu);
  menu.style.left = `${Math.max(4, Math.min(box.left + place.left, innerWidth - menu.offsetWidth - 8))}px`;
  menu.style.top = `${Math.max(4, Math.min(box.top + place.top, innerHeight - menu.offsetHeight - 8))}px`;
  const close = () => {
    menu.remove();
    globalThis.removeEventListener("pointerdown", outside, true);
  };
  const outside = (/** @type {Event} */ down) => !menu.contains(/** @type {Node} */ (down.target)) && close();
  globalThis.addEventListener("pointerdown", outside, true);
  menu.addEventListener("keydown", (pressed) => {
    const at = buttons.indexOf(/** @type {HTMLElement} */ (document.activeElement));
    /** @type {Record<string, number | undefined>} */
    const places = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: buttons.length - 1 };
    const to = places[pressed.key];
    if (to !== undefined) buttons[(to + buttons.length) % buttons.length].focus();
    else if (pressed.key === "Escape" || pressed.key === "Tab") {
      close();
      pane.canvas.focus();
    } else if (pressed.key !== "Enter" && pressed.key !== " ") return;
    else return;
    pressed.preventDefault();
    pressed.stopPropagation();
  });
  buttons[0].focus();
}
