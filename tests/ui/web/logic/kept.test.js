// What is kept of the past: trails and series within bounds, and the bytes of a frame.

import assert from "node:assert/strict";
import { Series, nearest } from "../../../../amorsim/ui/web/shared/series.js";
import { readFrame, writeFrame } from "../../../../amorsim/ui/web/simulator/protocol.js";
import { quantitiesOf } from "../../../../amorsim/ui/web/simulator/quantities.js";
import { Trail } from "../../../../amorsim/ui/web/simulator/trail.js";
import { areNear } from "./near.js";

Deno.test("a trail stays within bounds and keeps both ends", () => {
  const trail = new Trail();
  for (let tick = 0; tick < 40000; tick++) trail.add(tick, tick * 0.01, 0);
  assert(trail.count > 2000 && trail.count <= 6000);
  assert.deepEqual([trail.points[0][0], trail.points.at(-1)[0]], [0, 39999]);
  trail.add(20000, 200, 0); // back in time: what came after is dropped
  assert.equal(trail.points.at(-1)[0], 20000);
  assert(trail.points.every(([tick], n) => n === 0 || tick > trail.points[n - 1][0]));
  trail.add(20001, 200.0001, 0); // what does not move is not added
  assert.equal(trail.points.at(-1)[0], 20000);
});

Deno.test("of a trail the time is shown that is asked for, up to the present place", () => {
  const trail = new Trail();
  trail.load([0, 10, 20, 30], [[0, 0], [1, 0], [2, 0], [3, 0]]);
  const shown = () => {
    const xs = [];
    trail.each((x) => xs.push(x));
    return xs;
  };
  trail.showUntil(15, 1.5, 0);
  assert.deepEqual(shown(), [0, 1, 1.5]);
  trail.from = 5;
  assert.deepEqual(shown(), [1, 1.5]);
  trail.to = 12;
  assert.deepEqual(shown(), [1]);
});

Deno.test("a series stays within bounds, and goes back in time", () => {
  const series = new Series(["true", "measured"]);
  for (let tick = 0; tick < 40000; tick++) series.add(tick * 0.1, [tick, undefined]);
  assert(series.times.length > 2000 && series.times.length <= 9001);
  areNear([series.times[0], series.times.at(-1)], [0, 3999.9]);
  assert(series.values[1].every(Number.isNaN));
  series.add(2000, [1, 2]);
  assert.equal(series.times.at(-1), 2000);
  assert(series.values.every((column) => column.length === series.times.length));
});

Deno.test("the nearest of some times is found", () => {
  const times = [0, 1, 3, 3.5];
  assert.deepEqual([-5, 0.4, 0.6, 2.1, 3.3, 9].map((time) => nearest(times, time)), [0, 0, 1, 2, 3, 3]);
  assert.equal(nearest([], 1), -1);
});

Deno.test("a frame is read as it was written", () => {
  const scene = { version: 7, robots: [{ sensors: [{ size: 2 }, { size: 1 }] }] };
  const head = { version: 7, number: 3, epoch: 1, time: 1.5, speed: 2, achieved: 1, tick: 15, selected: 0, sensorCount: 2 };
  const blocks = { trueValues: [1, 2, 3], measuredValues: [1.5, 2.5, 3.5], ages: [0.1, 0.2], truePoses: [4, 5, 6, 7, 8, 9], flags: [1, 2] };
  const frame = readFrame(writeFrame(head, blocks), scene);
  assert.deepEqual([frame.time, frame.tick, frame.robotCount, frame.selected, frame.valueCount], [1.5, 15, 2, 0, 3]);
  assert.deepEqual([...frame.truePoses], blocks.truePoses);
  assert.deepEqual(frame.sensors.map((one) => [[...one.true], [...one.measured], one.age]), [[[1, 2], [1.5, 2.5], 0.1], [[3], [3.5], 0.2]]);
  assert.deepEqual(readFrame(writeFrame({ ...head, version: 8 }, blocks), scene).sensors, []); // of another scene
});

Deno.test("what is no frame is refused", () => {
  for (const size of [4, 200]) assert.throws(() => readFrame(new ArrayBuffer(size), null), { message: "these are not a frame's bytes" });
});

Deno.test("differences of angles go the short way round", () => {
  const heading = quantitiesOf({ twist: [1, 0, 1], joints: [], sensors: [] }).find(({ key }) => key === "heading");
  const [truth, measured, , apart] = heading.of({ truePoses: [0, 0, 3.1], estimatedPoses: [0, 0, -3.1], sensors: [] }, 0);
  areNear([truth, apart], [(3.1 * 180) / Math.PI, ((2 * Math.PI - 6.2) * 180) / Math.PI]); // not -355 degrees
  assert(Number.isNaN(measured));
});

Deno.test("a robot for the table is shown to a tenth of a millimetre", () => {
  const of = (reach) => new Map(quantitiesOf({ reach, twist: [1, 1, 1], joints: [], sensors: [] }).map(({ key, decimals }) => [key, decimals]));
  const [small, large] = [of(0.03), of(0.3)];
  const lengths = [...small.keys()].filter((key) => small.get(key) !== large.get(key));
  assert.deepEqual(lengths.sort(), ["apart", "forward", "left", "x", "y"]);
  assert(lengths.every((key) => small.get(key) === 4));
});
