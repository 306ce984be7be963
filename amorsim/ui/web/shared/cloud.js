// What a particle filter holds: its particles, and its hypotheses with their ellipses.

import { drawEllipse } from "./marks.js";

const EACH = 4; // numbers of a particle: x, y, heading, weight
const OF_HYPOTHESIS = 10; // x, y, heading, weight, and the upper triangle of the covariance

/**
 * Particles as ticks that point where they look; the lighter, the paler.
 * @param {CanvasRenderingContext2D} context
 * @param {{scale: number}} camera
 * @param {Float64Array} particles
 * @param {Record<string, string>} theme
 */
export function drawCloud(context, camera, particles, theme) {
  let heaviest = 0;
  for (let k = 3; k < particles.length; k += EACH) heaviest = Math.max(heaviest, particles[k]);
  if (!(heaviest > 0)) return;
  const size = 1.5 / camera.scale;
  const length = 7 / camera.scale;
  context.save();
  context.strokeStyle = theme.estimated;
  context.fillStyle = theme.estimated;
  context.lineWidth = 1 / camera.scale;
  // Weights in a few steps: a path for each, not one for each particle.
  const steps = 4;
  for (let step = 1; step <= steps; step++) {
    context.globalAlpha = 0.15 + (0.6 * step) / steps;
    context.beginPath();
    for (let k = 0; k < particles.length; k += EACH) {
      if (Math.max(1, Math.ceil((steps * particles[k + 3]) / heaviest)) !== step) continue;
      const [x, y, heading] = [particles[k], particles[k + 1], particles[k + 2]];
      context.rect(x - size / 2, y - size / 2, size, size);
      context.moveTo(x, y);
      context.lineTo(x + length * Math.cos(heading), y + length * Math.sin(heading));
    }
    context.stroke();
    context.fill();
  }
  context.restore();
}

/**
 * Hypotheses, each with its ellipse; the lighter, the paler.
 * @param {CanvasRenderingContext2D} context
 * @param {{scale: number}} camera
 * @param {Float64Array} hypotheses
 * @param {Record<string, string>} theme
 */
export function drawHypotheses(context, camera, hypotheses, theme) {
  for (let k = 0; k < hypotheses.length; k += OF_HYPOTHESIS) {
    const [x, y, heading, weight, ...covariance] = hypotheses.subarray(k, k + OF_HYPOTHESIS);
    context.save();
    context.globalAlpha = 0.25 + 0.75 * Math.sqrt(weight);
    drawEllipse(context, camera, [x, y, heading], covariance, theme);
    const far = 16 / camera.scale;
    context.lineWidth = 2 / camera.scale;
    context.strokeStyle = theme.estimated;
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + far * Math.cos(heading), y + far * Math.sin(heading));
    context.stroke();
    context.restore();
  }
}
