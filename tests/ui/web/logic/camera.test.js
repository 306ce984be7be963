// One camera for all panes, and two fingers that move it.

import assert from "node:assert/strict";
import { Camera, zoomOf } from "../../../../amorsim/ui/web/shared/camera.js";
import { Pinch } from "../../../../amorsim/ui/web/shared/pinch.js";
import { areNear } from "./near.js";

function camera() {
  const made = new Camera();
  made.resize(500, 400);
  made.fit([-3, 2, 9, 11]);
  return made;
}

Deno.test("the point under the pointer stays there when zooming", () => {
  const seen = camera();
  const before = seen.toWorld(123, 77);
  areNear(seen.toScreen(...before), [123, 77]);
  seen.zoom(3.7, 123, 77);
  areNear(seen.toWorld(123, 77), before);
  seen.pan(40, -25);
  areNear(seen.toScreen(...before), [163, 52]);
});

Deno.test("a notch of a wheel zooms, and two fingers on a trackpad as much as they are pulled apart", () => {
  const notch = zoomOf({ deltaY: -120, ctrlKey: false });
  areNear([notch, zoomOf({ deltaY: 120, ctrlKey: false })], [Math.exp(0.18), Math.exp(-0.18)]);
  assert.equal(zoomOf({ deltaY: -1000, ctrlKey: false }), notch);
  // Chromium tells of fingers pulled 1 % apart as -1: 100 ln(1.01).
  const apart = zoomOf({ deltaY: -1, ctrlKey: true });
  assert(apart > 1.01 && apart < 1.02);
  assert.equal(zoomOf({ deltaY: 0, ctrlKey: true }), 1);
});

Deno.test("all that fits is seen, and not much more", () => {
  const [x0, y0, x1, y1] = camera().bounds();
  assert(x0 <= -3 && y0 <= 2 && x1 >= 9 && y1 >= 11);
  assert(y1 - y0 < 1.2 * 9 || x1 - x0 < 1.2 * 12);
});

Deno.test("it goes neither nearer nor farther than what can be told apart", () => {
  const seen = camera();
  seen.zoom(1e9);
  assert.equal(seen.scale, 4000);
  seen.zoom(1e-9);
  assert.equal(seen.scale, 0.5);
  seen.centre(NaN, 3);
  areNear([seen.x, seen.y], [3, 6.5]);
});

Deno.test("pictures at one scale differ by whole pixels", () => {
  const seen = camera();
  for (const x of [0.1, 0.123, 0.4567]) {
    seen.centre(x, 2 * x);
    const { x: left, y: up, scale, width } = seen.onPixels(2, [10, 20]);
    areNear([left * scale * 2, up * scale * 2].map((place) => place - Math.round(place)), [0, 0], 1e-6);
    assert(Math.abs(left - x) * scale <= 0.5);
    assert.equal(width, 510);
  }
});

Deno.test("two fingers keep the places of the world that they are on", () => {
  const seen = camera();
  const pinch = new Pinch(seen);
  assert.equal(pinch.down(1, { left: 100, top: 100 }), false);
  assert.equal(pinch.move(1, { left: 110, top: 100 }), false); // one finger is no pinch
  assert.equal(pinch.down(2, { left: 200, top: 100 }), true);
  const places = [seen.toWorld(100, 100), seen.toWorld(200, 100)];
  pinch.move(1, { left: 80, top: 150 });
  pinch.move(2, { left: 280, top: 150 });
  areNear(seen.toScreen(...places[0]), [80, 150]);
  areNear(seen.toScreen(...places[1]), [280, 150]);
  assert.equal(pinch.up(1), true);
  assert.equal(pinch.isOn, true); // until the last finger is up
  assert.equal(pinch.up(2), true);
  assert.equal(pinch.isOn, false);
});
