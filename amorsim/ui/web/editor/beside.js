// A panel beside the drawing, in the place of the list and the inspector: one at a time.

import { h, there } from "../shared/dom.js";

/**
 * Open a panel; it tells of its end by the event "close".
 * @param {import("./editor.js").EditorPage} page
 * @param {string} title
 * @param {HTMLElement} body
 * @param {HTMLElement[]} buttons
 */
export function openBeside(page, title, body, buttons) {
  page.closeBeside?.();
  const element = h("section", { class: "panel beside", "aria-label": title }, h("div", { class: "head" }, h("h2", {}, title), h("div", { class: "tools" }, buttons)), body);
  const panels = there(page.root.querySelector(".panels"));
  panels.append(element);
  panels.classList.add("with-beside");
  const close = () => {
    if (page.closeBeside !== close) return;
    page.closeBeside = null;
    element.remove();
    panels.classList.remove("with-beside");
    element.dispatchEvent(new Event("close"));
  };
  page.closeBeside = close;
  return { element, close };
}
