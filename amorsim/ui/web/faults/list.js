// The list of faults: where each is, what stands there, what is wrong with it, and what would be right.

import { h } from "../shared/dom.js";

/** @typedef {import("../simulator/messages.d.ts").FaultLine} FaultLine */

/** Where a fault is: file and line.
 * @param {FaultLine} fault
 * @param {string} file of the scenario, as its user calls it */
function placeOf(fault, file) {
  const name = fault.file || file;
  return fault.line === null ? name : `${name}, line ${fault.line}`;
}

/** What is wrong, without the remedy, which has a line of its own.
 * @param {FaultLine} fault */
function problemOf({ message, remedy }) {
  if (!remedy || message === remedy) return message;
  const rest = message.endsWith(remedy) ? message.slice(0, -remedy.length).replace(/[;:,.\s]+$/, "") : message;
  return rest || message;
}

/** @param {FaultLine} fault
 * @param {string} file */
function item(fault, file) {
  const row = (/** @type {string} */ name, /** @type {string} */ text, kind = "") =>
    text ? [h("dt", {}, name), h("dd", { class: kind }, text)] : [];
  return h(
    "li",
    { class: "fault" },
    h("p", { class: "problem" }, problemOf(fault)),
    h(
      "dl",
      {},
      row("where", placeOf(fault, file)),
      row("key", fault.path, "code"),
      row("line", fault.said, "code"),
      row("value", fault.value, "code"),
      row("remedy", fault.remedy, "remedy"),
    ),
  );
}

/** The faults as a list.
 * @param {FaultLine[]} faults
 * @param {string} file */
export const faultList = (faults, file) => h("ol", { class: "faults-list" }, faults.map((fault) => item(fault, file)));
