// The elements of the Editor's page; `editor.js` connects them.

import { h } from "../shared/dom.js";
import { drawing } from "./drawing.js";
import { MENU } from "./project.js";

/** The tools: name, what it does, its key, its drawing. */
export const TOOLS = [
  ["select", "select, move and turn", "V", "M4 3l11 6-5 1.5L8 16z"],
  ["hand", "move the view", "H", "M10 3v14M3 10h14M10 3l-2 2M10 3l2 2M10 17l-2-2M10 17l2-2M3 10l2-2M3 10l2 2M17 10l-2-2M17 10l-2 2"],
  ["line", "draw a wall", "W", "M4 16L16 4"],
  ["polyline", "draw walls, end to end", "P", "M3 15l5-8 4 5 5-8"],
  ["rectangle", "draw a rectangle of walls", "R", "M3 5h14v10H3z"],
  ["circle", "draw a circle of walls", "C", "M17 10a7 7 0 1 1-14 0a7 7 0 1 1 14 0"],
  ["room", "draw a room with an opening", "O", "M3 4h14v12h-5M8 16H3V4"],
  ["door", "put a door or an opening into a wall", "D", "M2 15h4M14 15h4M6 15V6l6 3"],
  ["trim", "trim a wall where others cross it", "T", "M4 16L16 4M4 5l4 3M12 12l4 3"],
  ["brush", "paint cells occupied", "B", "M4 16c4 0 4-3 6-5l6-7"],
  ["eraser", "paint cells free", "E", "M3 13l7-8 6 5-6 6H6z"],
  ["cells", "a line of occupied cells", "W", "M4 16L16 4"],
  ["fill", "fill an area", "F", "M5 10l6-6 5 5-7 7z M3 16h4"],
  ["crop", "crop the world", "C", "M6 2v12h12M2 6h12v12"],
  ["measure", "measure a distance", "M", "M3 14L14 3l3 3L6 17zM6 11l2 2M9 8l2 2M12 5l2 2"],
];

/** What can be done with what is selected. */
export const DOINGS = [
  ["duplicate", "copy", "duplicate what is selected (Ctrl + D)"], ["array", "array…", "copies in rows"],
  ["mirror", "mirror", "mirror what is selected, left to right"], ["remove", "delete", "delete what is selected (Delete)"],
];

export const GRIDS = [["0.1", "grid 0.1 m"], ["0.01", "grid 0.01 m"], ["0.05", "grid 0.05 m"], ["0.25", "grid 0.25 m"], ["0.5", "grid 0.5 m"], ["1", "grid 1 m"], ["0", "no grid"]];

const DOORS = [["swinging", "a swinging door"], ["sliding", "a sliding door"], ["opening", "an opening alone"]];

/** @param {any} what */
export function build({ pane, objects, inspector }) {
  /** @type {Record<string, any>} */
  const parts = {};
  /** @template {HTMLElement} T @param {string} name @param {T} element @returns {T} */
  const make = (name, element) => {
    parts[name] = element;
    return element;
  };
  const button = (/** @type {string} */ name, /** @type {Record<string, any>} */ attributes, /** @type {any[]} */ ...children) => make(name, h("button", attributes, children));
  const icon = (/** @type {string} */ name, /** @type {string} */ label, /** @type {string} */ sign) => button(name, { class: "icon", "aria-label": label, title: label }, sign);
  parts.tools = new Map(TOOLS.map(([name, does, key, path]) => {
    const drawn = h("button", { "aria-pressed": "false", "aria-label": `${does} (${key})`, title: `${does} (${key})`, "data-tool": name });
    drawn.append(drawing(path));
    return [name, drawn];
  }));
  const field = (/** @type {string} */ name, /** @type {string} */ label) => make(name, h("input", { type: "text", inputmode: "decimal", autocomplete: "off", id: `typed-${name}`, "aria-label": label }));
  pane.append(make("reading", h("p", { class: "reading", role: "status" }, "reading the scenario …")));
  parts.element = h(
    "div",
    { class: "window" },
    h(
      "header",
      { class: "bar" },
      h("h1", {}, "amorsim"),
      make("file", h("span", { class: "file" })),
      h("span", { class: "holders-only both" }, icon("undo", "undo (Ctrl + Z)", "↶"), icon("redo", "redo (Ctrl + Y)", "↷")),
      make("menu", h("select", { "aria-label": "file and world" }, h("option", { value: "" }, "file …"), MENU.map(({ name, words }) => h("option", { value: name }, words)))),
      button("add", { class: "holders-only", title: "robots, obstacles, people, doors, furniture, worlds (A)" }, "add …"),
      h("span", { class: "space" }),
      make("saved", h("span", { class: "saved", role: "status" })),
      button("pen", { class: "pen", hidden: true }),
      button("text", { title: "the scenario's file, as text" }, "text"),
      button("save", { class: "holders-only", title: "save (Ctrl + S)" }, "save"),
      button("saveAs", { class: "holders-only" }, "save as…"),
      icon("play", "play here", "▷"),
      button("run", { class: "holders-only run", title: "simulate what is drawn here" }, "▶ run"),
      icon("theme", "light or dark (L)", "◐"),
      icon("keys", "keys (?)", "?"),
    ),
    make("banner", h("div", { class: "banner", role: "alert", hidden: true })),
    h(
      "div",
      { class: "panels" },
      h("div", { class: "panel toolbox", role: "toolbar", "aria-label": "tools", "aria-orientation": "vertical" }, [...parts.tools.values()], h("hr"),
        button("in", { "aria-label": "zoom in (+)", title: "zoom in (+)" }, "+"), button("out", { "aria-label": "zoom out (−)", title: "zoom out (−)" }, "−"),
        button("all", { "aria-label": "see all (0)", title: "see all (0)" }, "⤢")),
      h(
        "section",
        { class: "panel drawing", "aria-label": "drawing" },
        h(
          "div",
          { class: "options" },
          make("says", h("span", { class: "says" })),
          make("typing", h("span", { class: "both holders-only", hidden: true }, ["length", "angle"].flatMap((name) => [
            make(`${name}Word`, h("label", { for: `typed-${name}` })), field(name, name), make(`${name}Unit`, h("span", {}))]))),
          make("openings", h("span", { class: "both holders-only", hidden: true }, h("label", { for: "typed-width" }, "width"), field("width", "width of the opening in metres"), h("span", {}, "m"),
            make("doors", h("select", { "aria-label": "what is put into the wall" }, DOORS.map(([value, words]) => h("option", { value }, words)))))),
          make("brushes", h("span", { class: "both holders-only", hidden: true }, h("label", { for: "typed-brush" }, "width"), field("brush", "width of the brush in metres"), h("span", {}, "m"))),
          make("mounting", h("span", { class: "both holders-only", hidden: true }, h("label", { for: "mounts" }, "drag the mount of"), make("mounts", h("select", { id: "mounts" })))),
          make("grid", h("select", { "aria-label": "what is drawn snaps to" }, GRIDS.map(([value, words]) => h("option", { value }, words)))),
        ),
        pane,
        make("faults", h("div", { class: "faults", tabindex: "0", role: "group", "aria-label": "faults", hidden: true })),
      ),
      h("section", { class: "panel objects", "aria-labelledby": "objects-title" }, h("div", { class: "head" }, h("h2", { id: "objects-title" }, "Objects"), h("div", { class: "tools holders-only" }, DOINGS.map(([name, label, title]) => button(name, { class: "tool", title, disabled: true }, label)))), objects),
      h("section", { class: "panel inspector", "aria-labelledby": "inspector-title" }, h("div", { class: "head" }, inspector.title), inspector.element),
    ),
    h("footer", { class: "status" }, make("problems", h("span", { role: "status" })), make("counts", h("span", { class: "grow" })), make("hint", h("span", { role: "status", "aria-live": "polite" }))),
  );
  return parts;
}

export const KEYS = [
  ["V, H, W, P, R, C", "select, move the view, a wall, walls, a rectangle, a circle"],
  ["A", "add a robot, an obstacle, a person, a world …"],
  ["secondary button, menu key", "what can be done with what lies there"],
  ["double click on a grip", "its numbers, to be typed"],
  ["O, D, T, M", "a room, a door, trim a wall, measure"],
  ["B, E, W, F, C", "in a bitmap: brush, eraser, a line, fill, crop"],
  ["Enter", "on the canvas: select, or set a point, in its middle"],
  ["Escape", "end what was begun"],
  ["arrows", "move what is selected by a step of the grid; with Alt by 1 cm"],
  ["[ and ]", "turn what is selected by 5°, walls about their middle"],
  ["Delete", "delete what is selected"],
  ["Ctrl + Z, Ctrl + Y", "undo, redo"],
  ["Ctrl + C, X, V", "copy, cut, paste"],
  ["Ctrl + D", "duplicate"],
  ["Ctrl + A", "select all"],
  ["Ctrl + S", "save"],
  ["Shift + arrows", "move the view"],
  ["+, −, 0", "zoom in, out, see all"],
  ["G", "grid"],
  ["L", "light or dark"],
  ["?", "this"],
];
