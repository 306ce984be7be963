// Running in place: the simulation of what is drawn, shown on the editing canvas, which is locked meanwhile.

import { tell } from "../shared/dialogs.js";
import { clock, h, say, there } from "../shared/dom.js";
import { readScene } from "../shared/scene.js";
import { Connection } from "../shared/socket.js";
import { readFrame } from "../simulator/protocol.js";

/** Play what is drawn, or stop it.
 * @param {import("./editor.js").EditorPage} page */
export async function play(page) {
  if (page.playing) {
    stop(page);
    return;
  }
  const { play: button } = page.parts;
  button.disabled = true;
  say(button, "…");
  const said = await page.connection.ask({ do: "run" });
  button.disabled = false;
  if (!said.ok) {
    say(button, "▷");
    tell("It cannot be run", h("pre", {}, said.error));
    return;
  }
  const playing = page.playing = /** @type {any} */ ({ scene: null });
  playing.connection = new Connection({
    frame: (/** @type {ArrayBuffer} */ buffer) => page.playing === playing && frameCame(page, playing, readFrame(buffer, playing.scene)),
    news: () => {},
    open: () => begin(page, playing),
    lost: () => stop(page),
  }, new URL(said.path, location.href).pathname);
  page.stage.selection.clear();
  page.take("select");
  lock(page);
}

/** @param {import("./editor.js").EditorPage} page
 * @param {any} playing */
async function begin(page, playing) {
  const said = await playing.connection.ask({ do: "scene" });
  if (!said.ok || page.playing !== playing) return;
  playing.scene = readScene(said.scene);
  const places = (/** @type {any[]} */ from, /** @type {any[]} */ to) => {
    const at = new Map(to.map(({ name }, n) => [name, n]));
    return from.map(({ name }) => at.get(name) ?? -1);
  };
  playing.robots = places(playing.scene.robots, there(page.stage.scene).robots);
  playing.obstacles = places(playing.scene.obstacles, there(page.stage.scene).obstacles);
  await playing.connection.ask({ do: "speed", factor: 1 });
  await playing.connection.ask({ do: "run" });
}

/** @param {import("./editor.js").EditorPage} page
 * @param {any} playing
 * @param {import("../simulator/messages.d.ts").Frame} frame */
function frameCame(page, playing, frame) {
  playing.connection.drawn(frame.number);
  if (!playing.robots || !page.stage.frame) return;
  for (const [which, places] of /** @type {["truePoses" | "obstacles", number[]][]} */ ([["truePoses", playing.robots], ["obstacles", playing.obstacles]])) {
    places.forEach((n, i) => n >= 0 && page.stage.carry(which, n, frame[which].subarray(3 * i, 3 * i + 3)));
  }
  playing.tick = frame.tick;
  page.hint(`playing, ${clock(frame.time)}: stop it to change something`);
  page.stage.redraw();
}

/** End it, and show what is drawn again.
 * @param {import("./editor.js").EditorPage} page */
export function stop(page) {
  const { playing } = page;
  if (!playing) return;
  page.playing = null;
  playing.connection.ask({ do: "pause" });
  playing.connection.close();
  page.hint("stopped");
  lock(page);
  if (page.drawn) page.draw(page.drawn);
}

/** @param {import("./editor.js").EditorPage} page */
function lock(page) {
  say(page.parts.play, page.playing ? "■" : "▷");
  const label = page.playing ? "stop" : "play here";
  page.parts.play.setAttribute("aria-label", label);
  page.parts.play.title = label;
  page.showState();
}
