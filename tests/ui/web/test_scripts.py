"""The window's scripts against what they must agree with: the frames that Python packs, and clicks on what is drawn."""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from amorsim.ui.simulator.frames.packing import Dynamic, Selected, pack_frame, unpack_frame
from tests.ui.windows import Server, Window, new_user


@pytest.fixture(scope="module")
def window(browser: Any, started: Server) -> Iterator[Window]:
    """One for all: of what a window shows these tests change nothing."""
    window = Window(new_user(browser).new_page()).open(started.address)
    yield window
    assert window.problems == []
    window.page.context.close()


def frame_of(robots: int, obstacles: int, sizes: list[int]) -> bytes:
    """A frame of random numbers, some of them not finite."""
    random = np.random.default_rng(5)
    values = sum(sizes)
    true = random.normal(size=values)
    true[0] = math.inf
    return pack_frame(
        Dynamic(
            version=7,
            number=2**31 + 5,
            epoch=3,
            time=12.3,
            speed=math.inf,
            achieved=41.5,
            tick=123,
            newest=456,
            oldest=2,
            flags=5,
            events=9,
            selected_robot=1,
            true_pose=random.normal(size=(robots, 3)),
            estimated_pose=random.normal(size=(robots, 3)),
            covariance=random.normal(size=(robots, 6)),
            obstacle_pose=random.normal(size=(obstacles, 3)),
            robot_flags=random.integers(0, 8, robots).astype(np.uint8),
            selected=Selected(
                true=true,
                measured=random.normal(size=values),
                age=random.normal(size=len(sizes)),
                true_rates=random.normal(size=2),
                measured_rates=np.array([math.nan, 1.0]),
                true_twist=random.normal(size=3),
                estimated_twist=random.normal(size=3),
                command=random.normal(size=2),
                parts=random.normal(size=3 * obstacles),
                particles=random.normal(size=4 * robots),
                hypotheses=random.normal(size=10 * obstacles),
            ),
        )
    )


def flat(values: Any) -> list[float]:
    return [float(value) for value in np.ravel(np.asarray(values, dtype=float))]


@pytest.mark.parametrize(("robots", "obstacles"), [(2, 0), (5, 3), (7, 1)])
def test_a_frame_is_read_as_python_reads_it(window: Window, robots: int, obstacles: int) -> None:
    sizes = [2, 181, 16, 1]
    data = frame_of(robots, obstacles, sizes)
    read = window.page.evaluate(
        """async ([text, sizes, robots]) => {
            const { readFrame } = await import("/amorsim/web/simulator/protocol.js");
            const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
            const robot = { sensors: sizes.map((size) => ({ size })) };
            const scene = { version: 7, robots: Array(robots).fill(robot) };
            const frame = readFrame(bytes.buffer, scene);
            const plain = (value) => (ArrayBuffer.isView(value) ? Array.from(value) : value);
            const sensors = frame.sensors.map((one) => [plain(one.true), plain(one.measured), one.age]);
            return [Object.fromEntries(Object.entries(frame).map(([key, value]) => [key, plain(value)])), sensors];
        }""",
        [base64.b64encode(data).decode(), sizes, robots],
    )
    frame, sensors = read
    meant = unpack_frame(data)
    for key in ("version", "number", "epoch", "time", "speed", "achieved", "tick", "newest", "oldest", "events"):
        assert frame[key] == getattr(meant, key), key
    assert frame["states"] == meant.flags
    assert frame["selected"] == 1
    for key, values in (
        ("truePoses", meant.true_pose),
        ("estimatedPoses", meant.estimated_pose),
        ("covariances", meant.covariance),
        ("obstacles", meant.obstacle_pose),
        ("flags", meant.robot_flags),
        ("trueRates", meant.selected.true_rates),
        ("measuredRates", meant.selected.measured_rates),
        ("trueTwist", meant.selected.true_twist),
        ("estimatedTwist", meant.selected.estimated_twist),
        ("command", meant.selected.command),
        ("believedParts", meant.selected.parts),
        ("particles", meant.selected.particles),
        ("hypotheses", meant.selected.hypotheses),
    ):
        np.testing.assert_array_equal(flat(frame[key]), flat(values), err_msg=key)
    ends = np.cumsum(sizes)
    for s, (true, measured, age) in enumerate(sensors):
        part = slice(ends[s] - sizes[s], ends[s])
        np.testing.assert_array_equal(flat(true), meant.selected.true[part])
        np.testing.assert_array_equal(flat(measured), meant.selected.measured[part])
        assert age == meant.selected.age[s]


def sensor(**more: Any) -> dict[str, Any]:
    """A sensor's shape as a scene has it."""
    plain = {"name": "it", "kind": "it", "unit": "count", "columns": [], "size": 2, "mounts": [[0, 0, 0]]}
    return {**plain, "bearings": None, "range_max": None, "half_angle": None, **more}


SIDES = [[0.1, 0.2, math.pi / 2], [0.1, -0.2, -math.pi / 2]]  # an element that looks left, and one that looks right
FINDER = [["range", "m"], ["bearing", "rad"], ["id", "id"]]
BLOBS = [["colour", "id"], ["range", "m"], ["bearing", "rad"]]
# Of a robot at (2, 1) that looks along y: what is drawn, its values, a point [m] on one and what a click there says, a
# point where nothing is drawn.
STYLES: dict[str, tuple[dict[str, Any], list[float], tuple[float, float], tuple[str, str], tuple[float, float]]] = {
    "beams": (
        sensor(drawing={"style": "beams"}, unit="m", mounts=[[0.1, 0.2, 0.0]], bearings=[0.0, 1.0], range_max=8.0),
        [0.5, math.inf],
        (1.8, 1.6),
        ("it, beam 0", "true 0.5000 m, measured 0.5000 m, apart 0.0000 m"),
        (2.5, 1.6),
    ),
    "cones": (
        sensor(drawing={"style": "cones"}, unit="m", mounts=SIDES, bearings=[0.0, 0.0], range_max=5.0, half_angle=0.2),
        [0.5, 0.9],
        (1.3, 1.1),
        ("it, element 0", "looks 90.0° from ahead"),
        (2.0, 1.8),
    ),
    "glow": (
        sensor(drawing={"style": "glow", "half_angle": 0.5, "reach": 0.4, "span": [0, 1000]}, mounts=SIDES),
        [0.0, 600.0],
        (2.45, 1.12),
        ("it, element 1", "true 600.0 count, measured 600.0 count, apart 0.0 count"),
        (2.0, 1.8),
    ),
    "sticks": (
        sensor(drawing={"style": "sticks", "span": [500, 50]}, mounts=SIDES),
        [50.0, 500.0],
        (1.5, 1.1),  # 30 pixels to the left of (1.8, 1.1) at 100 a metre
        ("it, element 0", "true 50.0 count, measured 50.0 count, apart 0.0 count"),
        (2.5, 1.1),
    ),
    "marks": (
        sensor(drawing={"style": "things"}, unit="mixed", columns=FINDER, size=6),
        [0.5, math.pi / 2, 7.0, math.inf, math.inf, -1.0],
        (1.45, 1.0),
        ("it, 7", "bearing: true 90.00 °, measured 90.00 °, apart 0.00 °"),
        (2.6, 1.0),
    ),
    "blobs": (
        sensor(
            drawing={"style": "things", "colours": ["#ff0000"], "names": ["red"]}, unit="mixed", columns=BLOBS, size=3
        ),
        [0.0, 0.5, -math.pi / 2],
        (2.45, 1.0),
        ("it, red", "colour: true red, measured red"),
        (1.4, 1.0),
    ),
    "contacts": (
        sensor(drawing={"style": "contacts", "lines": [[[0.3, 0.0, 0.3, 0.3]], [[0.3, -0.3, 0.3, 0.0]]]}),
        [1.0, 0.0],
        (1.85, 1.3),
        ("it, segment 0", "true pressed, measured pressed"),
        (2.0, 1.6),
    ),
    "fix": (
        sensor(drawing={"style": "fix"}, unit="m", columns=[["x", "m"], ["y", "m"], ["heading", "rad"]], size=3),
        [2.6, 1.7, 0.5],
        (2.6, 1.7),
        ("it", "true 2.600, 1.700 m, 28.65°"),
        (1.4, 1.0),
    ),
    "needle": (
        sensor(drawing={"style": "needle"}, unit="rad", size=1),
        [math.pi],
        (1.6, 1.0),
        ("it", "true 180.00°, measured 180.00°, apart 0.00°"),
        (2.4, 1.0),
    ),
}


@pytest.mark.parametrize("style", STYLES)
def test_a_reading_is_drawn_where_a_click_finds_it(window: Window, style: str) -> None:
    shape, values, point, (title, line), nowhere = STYLES[style]
    found = window.page.evaluate(
        """async ([sensor, plain, points]) => {
            const { Camera } = await import("/amorsim/web/shared/camera.js");
            const { drawReadings, isDrawn, nearestPart, tellPart } = await import("/amorsim/web/simulator/readings.js");
            const values = Float64Array.from(plain, (value) => value ?? Infinity);
            const camera = new Camera();
            camera.resize(300, 300);
            [camera.x, camera.y, camera.scale] = [2, 1, 100];
            const context = new OffscreenCanvas(300, 300).getContext("2d");
            camera.apply(context, 1);
            const theme = { true: "rgb(9 200 9)", "true-fill": "rgb(9 200 9 / 0.2)", paper: "white" };
            const pose = [2, 1, Math.PI / 2];
            drawReadings({ context, camera, theme, kind: "true" }, sensor, pose, values);
            const parts = points.map(([x, y]) => {
                const [left, top] = camera.toScreen(x, y).map(Math.round);
                const { data } = context.getImageData(left - 3, top - 3, 7, 7);
                let drawn = 0;
                for (let i = 3; i < data.length; i += 4) drawn += data[i] > 0;
                const part = nearestPart(sensor, pose, values, x, y, 0.09, camera.scale);
                return [drawn, part && tellPart(sensor, { true: values, measured: values, age: 0.5 }, part)];
            });
            return { isDrawn: isDrawn(sensor), parts };
        }""",
        [shape, [value if math.isfinite(value) else None for value in values], [point, nowhere]],
    )
    assert found["isDrawn"]
    (drawn, said), (elsewhere, nothing) = found["parts"]
    assert drawn > 0
    assert said["title"] == title
    assert line in said["lines"]
    assert said["lines"][-1] == "0.50 s old"
    assert (elsewhere, nothing) == (0, None)
