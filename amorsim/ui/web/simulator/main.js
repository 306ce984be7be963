// The Simulator's page: its window, and the connection with the server.

import { Connection } from "../shared/socket.js";
import { Simulator } from "./simulator.js";

const root = /** @type {HTMLElement & {simulator?: Simulator}} */ (document.querySelector(".amorsim"));
root.simulator = new Simulator(root, (on) => new Connection(on));
