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

const KEPT = "amorsim-theme";
/** @type {string | null} */
let chosen = null; // where nothing may be stored, as in a notebook

function keptTheme() {
  try {
    return localStorage.getItem(KEPT);
  } catch {
    return chosen;
  }
}

/** @param {string} theme */
function keepTheme(theme) {
  chosen = theme;
  try {
    localStorage.setItem(KEPT, theme);
  } catch {
    // It holds for this page alone.
  }
}

/** Follow what the user chose last, or else the page around this one (`data-around` and an event of that name), or the
 * system's light or dark.
 * @param {Element} root */
export function startTheme(root) {
  const page = document.documentElement;
  const system = window.matchMedia("(prefers-color-scheme: dark)");
  const apply = () => {
    const kept = keptTheme();
    const wanted = kept === "dark" || kept === "light" ? kept : page.dataset.around;
    const dark = wanted ? wanted === "dark" : system.matches;
    page.dataset.theme = dark ? "dark" : "light";
    root.dispatchEvent(new CustomEvent("theme"));
  };
  system.addEventListener("change", apply);
  page.addEventListener("around", apply);
  apply();
  return () => {
    keepTheme(page.dataset.theme === "dark" ? "light" : "dark");
    apply();
  };
}
