// What the buttons of the window do.

import { leadBack } from "./back.js";
import { askControls } from "./controls.js";
import { showKeys } from "./key_list.js";

const STATE_EVERY = 1000; // milliseconds
const LECTURE = "#lecture"; // ends the address of a window that is shown to a class

/** @param {import("./simulator.js").Simulator} simulator */
export function listenToClicks(simulator) {
  const { parts, stage } = simulator;
  for (const [name, button] of parts.tools) button.addEventListener("click", () => stage.setOption(name, !stage.options[name]));
  parts.zoom.in.addEventListener("click", () => stage.camera.zoom(1.3));
  parts.zoom.out.addEventListener("click", () => stage.camera.zoom(1 / 1.3));
  parts.zoom.fit.addEventListener("click", () => stage.fit());
  parts.robot.addEventListener("change", () => simulator.ask({ do: "select", robot: Number(parts.robot.value) }));
  parts.fleet.addEventListener("click", () => simulator.toggleFleet());
  parts.asAtFirst.addEventListener("click", () => parts.arrangement.reset());
  parts.theme.addEventListener("click", () => simulator.toggleTheme());
  parts.lecture.addEventListener("click", () => simulator.setLecture(!simulator.isLecture));
  if (location.hash === LECTURE) simulator.setLecture(true);
  parts.keys.addEventListener("click", () => showKeys(simulator.timebar.isRecorded));
  parts.asInFile.addEventListener("click", () => simulator.restoreAll());
  parts.controls.addEventListener("click", () => askControls(simulator));
  leadBack(parts.editor);
  simulator.saving.listen();
  parts.saveRun.addEventListener("click", () => simulator.saving.run());
  parts.page.addEventListener("click", () => simulator.saving.page());
  parts.saveScenario.addEventListener("click", () => simulator.saving.scenario());
  parts.picture.addEventListener("click", () => simulator.saving.picture());
  parts.film.addEventListener("click", () => simulator.saving.toggle("film"));
  parts.video.addEventListener("click", () => simulator.saving.toggle("video"));
  setInterval(() => !document.hidden && simulator.connection.isOpen && simulator.reader.readState(), STATE_EVERY);
}
