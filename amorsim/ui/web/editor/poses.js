// Where things stand, as changes of the document.

import { there } from "../shared/dom.js";

const DEGREE = Math.PI / 180;

/** What the document has to say for a thing to stand at a pose: x, y [m], heading [°] from −180 to 180, null where it stays.
 * @param {import("./stage.js").Thing} thing
 * @param {number[]} pose */
export function poseChange({ path, pose: before }, [x, y, heading]) {
  const turned = heading - there(before)[2];
  const degrees = Math.round(((((heading / DEGREE) % 360) + 360) % 360) * 1e4) / 1e4;
  const value = [x, y, Math.abs(turned) < 1e-9 ? null : degrees > 180 ? Math.round((degrees - 360) * 1e4) / 1e4 : degrees];
  return { op: "pose", path, value };
}
