// The window's elements, as they stand; `simulator.js` gives them life.

import { VIDEO } from "../shared/capture.js";
import { h } from "../shared/dom.js";
import { Arrangement } from "./arrangement.js";

const swatch = (/** @type {string} */ kind) => h("span", { class: `swatch ${kind}`, "aria-hidden": "true" });
const panel = (/** @type {string} */ name, /** @type {any[]} */ ...children) => h("section", { class: `panel ${name}`, "aria-labelledby": `${name}-title` }, children);
const head = (/** @type {string} */ name, /** @type {any[]} */ ...children) => h("div", { class: "head" }, h("h2", { id: `${name}-title` }, children));

const scroll = (/** @type {string} */ name, /** @type {HTMLElement} */ child) => h("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": name }, child);

export const TOOLS = [
  ["overlay", "overlay", "both panes in one (O)"],
  ["follow", "follow", "keep the robot in the middle (F)"],
  ["trails", "trails", "paths driven so far (T)"],
  ["ellipse", "95 %", "where the robot believes to be, with 95 %"],
  ["grid", "grid", "lines of a round distance (G)"],
];

/** What an estimator may believe, and which number of a frame counts it; switches for these are in the Control pane. */
export const BELIEFS = [
  ["particles", "particleCount", "the particles that its estimator holds"],
  ["hypotheses", "hypothesisCount", "where its estimator thinks the robot might be, each with 95 %"],
];

/** @param {any} what */
export function build({ stage, timebar, driving, form, replay, futures, fleet }) {
  /** @type {Record<string, any>} */
  const parts = {};
  /** @template T @param {string} name @param {T} element @returns {T} */
  const make = (name, element) => {
    parts[name] = element;
    return element;
  };
  parts.tools = new Map(
    TOOLS.map(([name, label, title]) => [name, h("button", { class: "tool", "aria-pressed": "false", title, "data-tool": name }, label)]),
  );
  const views = [...parts.tools.values()];
  for (const [name, , title] of BELIEFS) {
    parts.tools.set(name, h("button", { class: "tool", "aria-pressed": "true", title, "data-tool": name }, name));
  }
  parts.zoom = {
    out: h("button", { class: "tool", "aria-label": "zoom out (−)", title: "zoom out (−)" }, "−"),
    in: h("button", { class: "tool", "aria-label": "zoom in (+)", title: "zoom in (+)" }, "+"),
    fit: h("button", { class: "tool", "aria-label": "see all (0)", title: "see all (0)" }, "all"),
  };
  make("saveList", h(
    "div",
    { class: "save-list", id: "save-list", popover: true, role: "group", "aria-label": "save" },
    make("saveRun", h("button", { class: "holders-only live-only server-only" }, "save run")),
    make("saveScenario", h("button", { class: "holders-only live-only", title: "the scenario with its present parameters" }, "save as…")),
    make("page", h("button", { class: "server-only", title: "this run as one file, which plays in any browser without amorsim" }, "page")),
    make("picture", h("button", { title: "a picture of the view" }, "picture")),
    make("film", h("button", { class: "server-only", title: "record the view as a GIF", "aria-pressed": "false" }, "GIF")),
    make("video", h("button", { hidden: !VIDEO, title: "record the view as a video", "aria-pressed": "false" }, "video")),
  ));
  const header = h(
    "header",
    { class: "bar" },
    h("h1", {}, "amorsim"),
    make("scenario", h("span", { class: "scenario" })),
    h("span", { class: "badge recorded-only", title: "a recorded run: nothing is simulated" }, "recorded"),
    make("robot", h("select", { class: "robots", "aria-label": "robot" })),
    timebar.element,
    make("controls", h("button", { class: "controls", hidden: true })),
    h(
      "div",
      { class: "menu" },
      make("editor", h("button", { hidden: true, title: "back to the Editor, where all is as it was" }, "← edit")),
      make("save", h("button", { popovertarget: "save-list", "aria-haspopup": "true", title: "the run, the scenario, a picture, a film" }, "save ▾")),
      parts.saveList,
      make("asAtFirst", h("button", { class: "icon", hidden: true, "aria-label": "panels as at first", title: "panels as at first" }, "⊞")),
      make("lecture", h("button", { "aria-pressed": "false", title: "large, for a class (C)" }, "lecture")),
      make("theme", h("button", { class: "icon", "aria-label": "light or dark (L)", title: "light or dark (L)" }, "◐")),
      make("keys", h("button", { class: "icon", "aria-label": "keys (?)", title: "keys (?)" }, "?")),
    ),
  );
  const robot = panel(
    "robot",
    make("robotHead", h(
      "div",
      { class: "head" },
      h("h2", { id: "robot-title" }, swatch("true"), make("robotName", h("span", {}, "Robot"))),
      make("robotNote", h("span", { class: "note" }, "what is true")),
      h("div", { class: "tools", role: "group", "aria-label": "view" }, [...views, ...Object.values(parts.zoom)]),
    )),
    stage.robot.element,
  );
  // At the lower end of the pane, where it covers no words.
  stage.robot.element.append(make("hint", h("div", { class: "hint", role: "status", "aria-live": "polite" })));
  const control = panel(
    "control",
    make("controlHead", h(
      "div",
      { class: "head" },
      h("h2", { id: "control-title" }, swatch("estimated"), "Control"),
      h("span", { class: "note", title: "its readings, drawn from its estimated pose" }, "what it knows"),
      make("knownTools", h(
        "div",
        { class: "known-tools" },
        make("fleet", h("button", { class: "tool", hidden: true, "aria-pressed": "false", title: "list of robots (B)" }, "robots")),
        stage.mapped.element,
        stage.intended.element,
        make("sensors", h("div", { class: "tools", role: "group", "aria-label": "sensors that are drawn" })),
      )),
    )),
    stage.control.element,
  );
  stage.control.element.append(fleet.element);
  const about = panel("run", head("run", "This run"), scroll("about this run", replay.element));
  const side = panel(
    "errors",
    h(
      "div",
      { class: "head" },
      make("errorsTitle", h("h2", { id: "errors-title" }, "Errors")),
      make("asInFile", h("button", { class: "tool holders-only", title: "all parameters as in the scenario" }, "as in file")),
    ),
    make("formNote", h("p", { class: "form-note", hidden: true })),
    scroll("parameters", form.element),
    driving.element,
  );
  const column = (/** @type {string} */ kind) => h("th", { scope: "col", class: kind }, swatch(kind), kind);
  const numbers = panel(
    "numbers",
    scroll(
      "quantities",
      h(
        "table",
        {},
        h(
          "thead",
          {},
          h("tr", {}, h("th", { scope: "col" }, make("numbersTitle", h("span", { id: "numbers-title" }, "quantity"))), column("true"), column("measured"), column("estimated"), h("th", { scope: "col", class: "difference" }, "difference")),
        ),
        make("table", h("tbody", {})),
      ),
    ),
  );
  // The first plot takes the title into its head.
  make("plotHead", h("div", { class: "plot-title" }, make("plotTitle", h("h2", { id: "plot-title" }, "Over time"))));
  const plot = panel("plot", futures.element, make("plots", h("div", { class: "plots" }, parts.plotHead)));
  const events = panel(
    "events",
    head("events", "Events"),
    scroll("events", make("events", h("ol", { class: "events-list" }))),
  );
  const arrangement = make(
    "arrangement",
    new Arrangement(
      { left: [robot], right: [control], low: [numbers], middle: [plot], last: [events], side: [side, about] },
      () => (parts.asAtFirst.hidden = parts.arrangement?.isFirst ?? true),
    ),
  );
  parts.element = h(
    "div",
    { class: "window" },
    header,
    make("banner", h("div", { class: "banner", role: "alert", hidden: true })),
    arrangement.element,
    timebar.past,
    make("card", h("div", { class: "card", role: "status", hidden: true })),
  );
  return parts;
}
