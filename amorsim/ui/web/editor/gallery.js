// A gallery: cards with a picture and a sentence, in groups, found by a search.

import { Camera } from "../shared/camera.js";
import { open } from "../shared/dialogs.js";
import { h } from "../shared/dom.js";
import { drawLayer } from "../shared/layer.js";
import { reach, trace } from "../shared/footprint.js";
import { Pictures } from "../shared/pictures.js";
import { readScene } from "../shared/scene.js";
import { StillRobotLayer, stillFrame } from "../shared/still.js";
import { BodiesLayer, WorldLayer } from "../shared/world.js";

const [WIDTH, HEIGHT] = [168, 104]; // pixels of a picture
const AIR = 1.25; // around a robot, of its reach

/**
 * Something to choose. Its picture is that of a scenario, a robot or a generated world (`of`: kind and name), or an outline.
 * @typedef {{name: string, of?: [string, string], footprint?: any, sentence?: string, does: () => void}} Entry
 */

/** What the server has said about cards, by kind and name. @type {Map<string, Promise<any>>} */
const known = new Map();

/** @param {import("./editor.js").EditorPage} page
 * @param {[string, string]} of */
function cardOf(page, [kind, name]) {
  const key = `${kind} ${name}`;
  if (kind === "scenario" || !known.has(key)) known.set(key, page.connection.ask({ do: "card", kind, name }));
  return known.get(key);
}

/**
 * Show a gallery; what is chosen closes it.
 * @param {import("./editor.js").EditorPage} page
 * @param {string} title
 * @param {{title: string, entries: Entry[]}[]} groups
 * @returns {HTMLDialogElement}
 */
export function showGallery(page, title, groups) {
  const search = h("input", { type: "text", "aria-label": "search", placeholder: "search", autocomplete: "off", spellcheck: "false" });
  const nothing = h("p", { class: "note", role: "status" });
  /** @type {{element: HTMLElement, words: string}[]} */
  const cards = [];
  const sections = groups.filter(({ entries }) => entries.length).map(({ title: name, entries }) =>
    h("section", {}, h("h3", {}, name), h("div", { class: "cards" }, entries.map((entry) => {
      const canvas = h("canvas", { "aria-hidden": "true" });
      const sentence = h("span", { class: "sentence" }, entry.sentence ?? "");
      const element = h("button", { class: "card-choice", onclick: () => {
        dialog.close();
        entry.does();
      } }, canvas, h("strong", {}, entry.name), sentence);
      const card = { element, words: `${entry.name} ${name} ${entry.sentence ?? ""}`.toLowerCase() };
      cards.push(card);
      if (entry.footprint) drawOutline(canvas, entry.footprint, page.stage.theme);
      const { of } = entry;
      if (of) {
        whenSeen(canvas, async () => {
          const said = await cardOf(page, of);
          if (!said.ok || !canvas.isConnected) return;
          sentence.textContent = said.sentence;
          card.words += ` ${said.sentence.toLowerCase()}`;
          drawStill(canvas, said, of[0], page.stage.theme);
        });
      } else if (!entry.footprint) canvas.remove();
      return element;
    }))),
  );
  const filter = () => {
    const wanted = search.value.trim().toLowerCase();
    for (const { element, words } of cards) element.hidden = !words.includes(wanted);
    for (const section of sections) section.hidden = !section.querySelector(".card-choice:not([hidden])");
    nothing.textContent = cards.some(({ element }) => !element.hidden) ? "" : "nothing of that name";
  };
  search.addEventListener("input", filter);
  search.addEventListener("keydown", (event) => {
    if (event.key !== "Enter") return;
    event.preventDefault();
    cards.find(({ element }) => !element.hidden)?.element.click();
  });
  const close = h("button", { onclick: () => dialog.close() }, "close");
  const dialog = open(title, h("div", { class: "gallery" }, search, nothing, h("div", { class: "groups", tabindex: "0", role: "group", "aria-label": title }, sections)), [close]);
  search.focus();
  return dialog;
}

/** Call a function once an element is seen.
 * @param {HTMLElement} element
 * @param {() => void} does */
function whenSeen(element, does) {
  const watcher = new IntersectionObserver((found) => {
    if (!found.some(({ isIntersecting }) => isIntersecting)) return;
    watcher.disconnect();
    does();
  });
  watcher.observe(element);
}

/** A brush on a picture that shows an extent [m].
 * @param {HTMLCanvasElement} canvas
 * @param {number[]} extent
 * @param {import("../shared/theme.js").Theme} theme */
function brushOn(canvas, extent, theme) {
  const ratio = globalThis.devicePixelRatio || 1;
  [canvas.width, canvas.height] = [Math.round(WIDTH * ratio), Math.round(HEIGHT * ratio)];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d", { alpha: false }));
  context.fillStyle = theme.paper;
  context.fillRect(0, 0, canvas.width, canvas.height);
  const camera = new Camera();
  camera.resize(WIDTH, HEIGHT);
  camera.fit(extent, 6);
  return { context, camera, ratio, theme };
}

const around = (/** @type {number} */ far) => [-far, -far, far, far].map((value) => AIR * value);

/** @param {HTMLCanvasElement} canvas
 * @param {any} footprint
 * @param {import("../shared/theme.js").Theme} theme */
function drawOutline(canvas, footprint, theme) {
  const { context, camera, ratio } = brushOn(canvas, around(reach(footprint)), theme);
  camera.apply(context, ratio);
  context.beginPath();
  trace(context, footprint, 0, 0, 0);
  context.fillStyle = theme.obstacle;
  context.fill();
  context.strokeStyle = theme.ink;
  context.lineWidth = 1.5 / camera.scale;
  context.stroke();
}

/** @param {HTMLCanvasElement} canvas
 * @param {{still: import("../shared/still.js").Still, pictures: Record<string, string>}} card
 * @param {string} kind
 * @param {import("../shared/theme.js").Theme} theme */
function drawStill(canvas, { still, pictures }, kind, theme) {
  const scene = readScene(still.scene);
  const extent = kind === "robot" && scene.robots.length ? around(scene.robots[0].reach) : still.extent;
  const draw = () => {
    const brush = brushOn(canvas, extent, theme);
    for (const layer of layers) if (layer.isShown) drawLayer(layer, brush);
  };
  const sight = /** @type {any} */ ({ scene, still, frame: stillFrame(still), pictures: new Pictures(draw), selection: { things: [] }, posesOf: () => sight.frame.truePoses });
  sight.pictures.reset((/** @type {string} */ name) => Promise.resolve(pictures[name] ? `data:image/png;base64,${pictures[name]}` : null));
  const layers = [new WorldLayer(sight), new BodiesLayer(sight), new StillRobotLayer(sight)];
  draw();
}
