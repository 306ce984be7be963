// The colours of the canvas are those of the style sheet: one place says what green, orange and blue are.

import { keep, kept } from "./storage.js";

const NAMES = [
  "true", "measured", "estimated", "true-fill", "measured-fill", "estimated-fill", "wall", "known-wall", "paper",
  "grid", "ink", "soft", "danger", "obstacle", "line",
];

/** The colours of the canvas, by the names of the style sheet's variables. @typedef {Record<string, string>} Theme */

/** Line styles that tell the three apart without colour: true solid, measured dotted, estimated dashed. */
/** @type {Record<string, number[]>} */
export const DASHES = { true: [], measured: [2, 3], estimated: [6, 4] };

/** @param {Element} element
 * @returns {Theme} */
export function readTheme(element) {
  const style = getComputedStyle(element);
  /** @type {Theme} */
  const theme = {};
  for (const name of NAMES) theme[name] = style.getPropertyValue(`--${name}`).trim() || "#888";
  return theme;
}

const KEPT = "amorsim-theme";
/** Follow what the user chose last, or else the page around this one (`data-around` and an event of that name), or the
 * system's light or dark.
 * @param {Element} root */
export function startTheme(root) {
  const page = document.documentElement;
  const system = window.matchMedia("(prefers-color-scheme: dark)");
  const apply = () => {
    const chosen = kept(KEPT);
    const wanted = chosen === "dark" || chosen === "light" ? chosen : page.dataset.around;
    const dark = wanted ? wanted === "dark" : system.matches;
    page.dataset.theme = dark ? "dark" : "light";
    root.dispatchEvent(new CustomEvent("theme"));
  };
  system.addEventListener("change", apply);
  page.addEventListener("around", apply);
  apply();
  return () => {
    keep(KEPT, page.dataset.theme === "dark" ? "light" : "dark");
    apply();
  };
}
