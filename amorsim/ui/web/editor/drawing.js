// Small drawings on buttons.

const SVG = "http://www.w3.org/2000/svg";

/** A drawing of lines on a square of 20 × 20.
 * @param {string} path as of SVG */
export function drawing(path) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", "0 0 20 20");
  svg.setAttribute("aria-hidden", "true");
  const line = document.createElementNS(SVG, "path");
  line.setAttribute("d", path);
  svg.append(line);
  return svg;
}
