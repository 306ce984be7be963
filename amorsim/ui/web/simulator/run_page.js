// A recorded run as a page of its own: the Simulator's window, over what the page holds.

import { there } from "../shared/dom.js";
import { unpack } from "./packed.js";
import { RecordedRun } from "./recorded_run.js";
import { Simulator } from "./simulator.js";

const root = /** @type {HTMLElement & {simulator?: Simulator}} */ (document.querySelector(".amorsim"));
const contents = await unpack(there(document.querySelector("#contents")).textContent);
document.documentElement.classList.add("without-server");
root.simulator = new Simulator(root, (on) => new RecordedRun(on, contents));
