// A tour of a page: what stands where, one thing after another.

import { h, say } from "./dom.js";

/** @typedef {{at: string, words: string}} Step what is pointed at, as a selector, and what is told of it */

const AIR = 6; // pixels around what is pointed at

/** Show one step after another; those whose element is not on the page are left out.
 * @param {HTMLElement} root
 * @param {Step[]} steps */
export function startTour(root, steps) {
  const seen = (/** @type {string} */ at) => [...root.querySelectorAll(at)].find((one) => /** @type {HTMLElement} */ (one).offsetParent);
  const shown = steps.filter(({ at }) => seen(at));
  if (!shown.length) return;
  let place = 0;
  const mark = h("div", { class: "tour-mark", "aria-hidden": "true" });
  const words = h("p", { "aria-live": "polite" });
  const count = h("span", { class: "note" });
  const back = h("button", { onclick: () => show(place - 1) }, "back");
  const next = h("button", { class: "main", onclick: () => (place === shown.length - 1 ? end() : show(place + 1)) }, "next");
  const box = h("div", { class: "tour", role: "dialog", "aria-label": "tour" }, words, h("div", { class: "buttons" }, count, back, next, h("button", { class: "quiet", onclick: () => end() }, "end")));
  const end = () => {
    mark.remove();
    box.remove();
    removeEventListener("resize", put);
  };
  const put = () => {
    const target = seen(shown[place].at);
    if (!target) return end();
    const { left, top, width, height } = target.getBoundingClientRect();
    Object.assign(mark.style, { left: `${left - AIR}px`, top: `${top - AIR}px`, width: `${width + 2 * AIR}px`, height: `${height + 2 * AIR}px` });
    // Below what is pointed at, or above it, or else within it.
    const { offsetWidth: wide, offsetHeight: high } = box;
    const below = top + height + 2 * AIR;
    const y = below + high < innerHeight ? below : top - high - 2 * AIR > 0 ? top - high - 2 * AIR : top + 44;
    box.style.left = `${Math.max(8, Math.min(left, innerWidth - wide - 8))}px`;
    box.style.top = `${Math.max(8, Math.min(y, innerHeight - high - 8))}px`;
    return undefined;
  };
  const show = (/** @type {number} */ n) => {
    place = n;
    say(words, shown[n].words);
    say(count, `${n + 1} of ${shown.length}`);
    say(next, n === shown.length - 1 ? "done" : "next");
    back.disabled = n === 0;
    put();
    next.focus();
  };
  box.addEventListener("keydown", (event) => {
    if (event.key === "Escape") end();
    else if (event.key === "ArrowRight" && place < shown.length - 1) show(place + 1);
    else if (event.key === "ArrowLeft" && place > 0) show(place - 1);
    else if (event.key !== "Enter" && event.key !== " " && event.key !== "Tab") return;
    event.stopPropagation();
  });
  addEventListener("resize", put);
  root.append(mark, box);
  show(0);
}
