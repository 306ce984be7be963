// The colours of the canvas are those of the style sheet: one place says what green, orange and blue are.

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

/** Follow the system's light or dark, or what the user chose last. */
export function startTheme(root) {
  const kept = localStorage.getItem("amorsim-theme");
  const system = window.matchMedia("(prefers-color-scheme: dark)");
  const apply = () => {
    const chosen = localStorage.getItem("amorsim-theme");
    const dark = chosen ? chosen === "dark" : system.matches;
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    root.dispatchEvent(new CustomEvent("theme"));
  };
  system.addEventListener("change", apply);
  if (kept !== "dark" && kept !== "light") localStorage.removeItem("amorsim-theme");
  apply();
  return () => {
    const dark = document.documentElement.dataset.theme === "dark";
    localStorage.setItem("amorsim-theme", dark ? "light" : "dark");
    apply();
  };
}
