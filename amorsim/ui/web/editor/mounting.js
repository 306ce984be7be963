// Which sensor of the selected robot can be taken hold of on the canvas.

import { h } from "../shared/dom.js";

/** The sensors of the robot that is selected.
 * @param {import("./editor.js").EditorPage} page */
export function showMounts(page) {
  const { parts, stage } = page;
  const [thing, ...others] = stage.chosenThings;
  const mounts = thing && !others.length && page.isHolder ? thing.mounts : [];
  parts.mounting.hidden = !mounts.length || page.toolName !== "select";
  if (!mounts.some(({ sensor }) => sensor === stage.sensor)) stage.sensor = "";
  const names = ["", ...mounts.map(({ sensor }) => sensor)];
  if (names.join() !== [...parts.mounts.options].map(({ value }) => value).join()) {
    parts.mounts.replaceChildren(...names.map((name) => h("option", { value: name }, name || "no sensor")));
  }
  parts.mounts.value = stage.sensor;
}

/** Let the mount of a sensor be dragged.
 * @param {import("./editor.js").EditorPage} page
 * @param {string} name */
export function holdSensor(page, name) {
  page.stage.sensor = name;
  showMounts(page);
  page.stage.touch();
}
