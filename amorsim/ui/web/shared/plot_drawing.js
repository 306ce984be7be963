// A plot as an SVG drawing: axes, curves, and what the robot believes, in the colours of the page.

import { fixed, there } from "./dom.js";
import { decimalsOf, linesBetween, spanOf, timeOf } from "./plot.js";
import { DASHES } from "./theme.js";

const EDGES = { left: 58, right: 14, top: 30, bottom: 34 }; // pixels around the curves
const [WIDTH, HEIGHT] = [720, 300];

/**
 * @param {import("./plot.js").Plot} plot
 * @param {string} title
 */
export function drawing({ curves: drawn, look: shown, range, zoom }, title) {
  const [curves, look] = [there(drawn), there(shown)];
  const { theme, unit } = look;
  const [from, to] = spanOf(curves, look, zoom);
  const x = (/** @type {number} */ time) => EDGES.left + ((time - from) / (to - from || 1)) * (WIDTH - EDGES.left - EDGES.right);
  const y = (/** @type {number} */ value) => HEIGHT - EDGES.bottom - ((value - range[0]) / (range[1] - range[0])) * (HEIGHT - EDGES.top - EDGES.bottom);
  const lines = linesBetween(range[0], range[1], HEIGHT - EDGES.top);
  const moments = linesBetween(from, to, (WIDTH - EDGES.left) / 3);
  const parts = [
    `<rect width="${WIDTH}" height="${HEIGHT}" fill="${theme.paper}"/>`,
    `<clipPath id="inside"><rect x="${EDGES.left}" y="${EDGES.top}" width="${WIDTH - EDGES.left - EDGES.right}" height="${HEIGHT - EDGES.top - EDGES.bottom}"/></clipPath>`,
    text(EDGES.left, 19, unit ? `${title} [${unit}]` : title, theme.ink, "start", 13),
    ...lines.map((value) => `<path d="M${EDGES.left} ${round(y(value))}H${WIDTH - EDGES.right}" stroke="${theme.line}"/>`),
    ...lines.map((value) => text(EDGES.left - 6, y(value) + 4, fixed(value, decimalsOf(lines)), theme.soft, "end")),
    ...moments.map((time) => text(x(time), HEIGHT - EDGES.bottom + 18, timeOf(time, moments), theme.soft, "middle")),
  ];
  const inside = [];
  if (curves.band) {
    const [low, high] = curves.band;
    const known = curves.times.map((_, n) => n).filter((n) => Number.isFinite(low[n]) && Number.isFinite(high[n]));
    const edge = (/** @type {number[]} */ column, /** @type {number[]} */ places) => places.map((n) => `${round(x(curves.times[n]))} ${round(y(column[n]))}`).join("L");
    if (known.length > 1) inside.push(`<path d="M${edge(low, known)}L${edge(high, [...known].reverse())}Z" fill="${theme["estimated-fill"]}"/>`);
  }
  for (const other of curves.others ?? []) inside.push(...all(other.times, other.values, 0.4));
  inside.push(...all(curves.times, curves.values, 1));
  parts.push(`<g clip-path="url(#inside)" fill="none" stroke-width="1.5">${inside.join("")}</g>`);
  curves.curves.forEach((kind, n) => parts.push(text(WIDTH - EDGES.right - 90 * (curves.curves.length - 1 - n), 19, kind, theme[kind] ?? theme.ink, "end")));
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${WIDTH} ${HEIGHT}" font-family="system-ui, sans-serif">${parts.join("")}</svg>\n`;

  /** @param {number[]} times
   * @param {number[][]} values
   * @param {number} opacity */
  function all(times, values, opacity) {
    return values.map((column, n) => {
      const kind = curves.curves[n];
      const dash = (DASHES[kind] ?? []).join(" ");
      return `<path d="${path(times, column)}" stroke="${theme[kind] ?? theme.ink}" opacity="${opacity}"${dash && ` stroke-dasharray="${dash}"`}/>`;
    });
  }

  /** @param {number[]} times
   * @param {number[]} column */
  function path(times, column) {
    let down = false;
    let drawn = "";
    column.forEach((value, n) => {
      if (!Number.isFinite(value)) down = false;
      else {
        drawn += `${down ? "L" : "M"}${round(x(times[n]))} ${round(y(value))}`;
        down = true;
      }
    });
    return drawn;
  }
}

const round = (/** @type {number} */ value) => Math.round(value * 100) / 100;

/** @type {Record<string, string>} */
const ESCAPES = { "<": "&lt;", ">": "&gt;", "&": "&amp;", '"': "&quot;" };

/** @param {number} x
 * @param {number} y
 * @param {string} words
 * @param {string} colour
 * @param {string} anchor */
function text(x, y, words, colour, anchor, size = 11) {
  const safe = String(words).replace(/[<>&"]/g, (letter) => ESCAPES[letter]);
  return `<text x="${round(x)}" y="${round(y)}" fill="${colour}" text-anchor="${anchor}" font-size="${size}">${safe}</text>`;
}
