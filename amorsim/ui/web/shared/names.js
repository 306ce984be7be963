// The names of robots next to them, clear of one another where they can be.

const MOST = 40; // robots whose names are all drawn
const HIGH = 12; // pixels of a letter

/**
 * Draw the names of robots at `poses`, in CSS pixels on the pane: that of the selected one bold, and of a crowd, or
 * where `alone`, no other. One robot that has no company needs no name.
 * @param {CanvasRenderingContext2D} context
 * @param {import("./camera.js").Camera} camera
 * @param {import("./scene.js").Robot[]} robots
 * @param {ArrayLike<number>} poses
 * @param {number} selected
 * @param {boolean} alone
 * @param {import("./theme.js").Theme} theme
 */
export function drawNames(context, camera, robots, poses, selected, alone, theme) {
  if (robots.length < 2) return;
  const others = alone || robots.length > MOST ? [] : robots.map((_, i) => i).filter((i) => i !== selected);
  /** @type {number[][]} */
  const taken = [];
  context.lineJoin = "round";
  context.lineWidth = 3;
  context.strokeStyle = theme.paper;
  context.fillStyle = theme.ink;
  for (const i of [selected, ...others]) {
    const [x, y] = camera.toScreen(poses[3 * i], poses[3 * i + 1]);
    if (!(x > 0 && x < camera.width && y > 0 && y < camera.height)) continue;
    context.font = `${i === selected ? 650 : 400} ${HIGH}px system-ui, sans-serif`;
    const wide = context.measureText(robots[i].name).width;
    const gap = Math.max(0.75 * robots[i].reach * camera.scale, 5) + 2;
    const places = [[gap, -gap], [-gap - wide, -gap], [gap, gap + HIGH], [-gap - wide, gap + HIGH]];
    const boxes = places.map(([right, down]) => [x + right, y + down - HIGH, x + right + wide, y + down]);
    const free = boxes.findIndex((box) => !taken.some((other) => overlap(box, other)));
    const [left, , , base] = boxes[Math.max(free, 0)];
    taken.push(boxes[Math.max(free, 0)]);
    context.strokeText(robots[i].name, left, base);
    context.fillText(robots[i].name, left, base);
  }
}

const overlap = (/** @type {number[]} */ a, /** @type {number[]} */ b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
