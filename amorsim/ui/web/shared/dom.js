// Small helpers for elements and numbers; everything in the window is plain DOM.

/** An element: `h("button", {class: "quiet", onclick: f, "aria-label": "run"}, "text", child, …)`.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, any>} [attributes]
 * @param {any[]} children
 * @returns {HTMLElementTagNameMap[K]} */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "value" || name === "checked" || name === "disabled") Reflect.set(element, name, value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

/** A value that is there, where its type cannot tell.
 * @template T
 * @param {T | null | undefined} value
 * @returns {T} */
export function there(value) {
  if (value === null || value === undefined) throw new Error("a value is missing that should be there");
  return value;
}

/** What draws on a canvas.
 * @param {HTMLCanvasElement} canvas
 * @param {CanvasRenderingContext2DSettings} [settings] */
export const context2d = (canvas, settings) => there(canvas.getContext("2d", settings));

/** A spot of a robot's colour.
 * @param {string} colour */
export function colourChip(colour) {
  const chip = h("span", { class: "chip", "aria-hidden": "true" });
  chip.style.background = colour;
  return chip;
}

/** Set an element's text where it differs: the DOM is left alone otherwise, which is what makes a table cheap.
 * @param {Element} element
 * @param {string} text */
export function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

const MINUS = "−";

/** A number with so many decimals, and a true minus; "–" for none, "∞" for no return.
 * @param {number | null | undefined} value
 * @param {number} decimals */
export function fixed(value, decimals) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : MINUS + "∞";
  const text = Math.abs(value).toFixed(decimals);
  return value < 0 && Number(text) !== 0 ? MINUS + text : text;
}

/** The same with a sign in any case, for differences.
 * @param {number} value
 * @param {number} decimals */
export function signed(value, decimals) {
  const text = fixed(value, decimals);
  return value > 0 && Number.isFinite(value) && Number(text) !== 0 ? "+" + text : text;
}

/** A parameter's value in as few digits as tell it apart.
 * @param {any} value */
export function brief(value) {
  if (typeof value !== "number") return String(value);
  return String(Number(value.toPrecision(6)));
}

/** "01:03.2" of seconds.
 * @param {number} seconds */
export function clock(seconds) {
  const tenths = Math.round(seconds * 10);
  const minutes = Math.floor(tenths / 600);
  const rest = ((tenths % 600) / 10).toFixed(1);
  return `${String(minutes).padStart(2, "0")}:${rest.padStart(4, "0")}`;
}

/** An angle in (-pi, pi].
 * @param {number} angle */
export function wrap(angle) {
  const turned = angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
  return turned <= -Math.PI ? turned + 2 * Math.PI : turned;
}

/** A step of 1, 2 or 5 times a power of ten that is at least `least`.
 * @param {number} least */
export function niceStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  for (const factor of [1, 2, 5]) if (factor * power >= least * (1 - 1e-9)) return factor * power;
  return 10 * power;
}
