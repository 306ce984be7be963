// The keys of the Simulator, as they are told.

import { tellKeys } from "../shared/dialogs.js";
import { TOUR } from "./tour.js";

const KEYS = [
  ["Space", "run, pause"], [".", "one step"], ["Shift + R", "reset to the start"], ["M", "drive by hand, or give back"],
  ["arrows, W A S D", "drive, while a key is held"], ["Q, E", "slide, where the drive can"], ["X", "stop"],
  ["O", "overlay of the two panes"], ["F", "follow the robot"], ["T", "trails"], ["G", "grid"], ["0", "see all"],
  ["+, −", "zoom"], ["Shift + arrows", "pan"], ["Enter", "in a pane: what is in its middle"], ["N, P", "next, previous robot"], ["B", "list of robots"], ["Shift + drag", "list the robots in a box"], ["L", "light or dark"], ["C", "large, for a class"], ["?", "this"],
];

const LIVE = ["Shift + R", "M", "arrows, W A S D", "Q, E", "X"];
const RECORDED = [[",", "one step back"], ["Shift + R", "to the start"]];

/** The keys of the Simulator; of a recorded run, those that do something there. */
export function showKeys(isRecorded = false) {
  tellKeys(isRecorded ? [...RECORDED, ...KEYS.filter(([key]) => !LIVE.includes(key))] : KEYS, TOUR);
}
