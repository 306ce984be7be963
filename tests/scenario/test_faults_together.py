"""All faults of a file are said at once: none hides another, whatever the thing that they are in."""

from __future__ import annotations

from pathlib import Path

import pytest

import amorsim as am

HEADS = {
    "simulation": (),
    "recording": (),
    "robots.0": ('name = "rover"', 'model = "pioneer2dx"', "pose = { x = 1, y = 1 }"),
    "robots.1": ('name = "second"', 'model = "pioneer2dx"', "pose = { x = 3, y = 3 }"),
    "obstacles.0": ('name = "box"', "shape = { circle = 0.2 }", "pose = { x = 5, y = 5 }"),
    "zones.0": ('name = "wet"', "shape = { circle = 0.2 }", "ground = []"),
    "landmarks.0": ("id = 7",),
    "lights.0": (),
}
WRONG = {
    "simulation": ("dt = -1", "seed = 1.5", "nokey = 1"),
    "recording": ("sensors = 3", 'also = [{ use = "nope" }]', "foo = 1"),
    "robots.0": (
        "spead = 1",
        'colour = "blurple"',
        "height = -1",
        "count = 0",
        'start = { random = "everywhere", x = 1 }',
        "drive.track = -1",
        "errors.drive.trak = 1.1",
        "errors.sensors.laser.range_maxx = 1",
        'controller = { use = "goto" }',
        "sensors.laser.range_max = -2",
        'sensors.sonar.noise = [{ use = "nope" }]',
        'sensors.zzz = { use = "gyro", rate = -1 }',
        'estimators.e = { use = "ekf", gps_std = -1, wheel_variance = 0.1 }',
        'initial_belief = { kind = "nothing", std = -1 }',
        "kidnappings = [{ time = -1 }]",
        'knowledge.map = "no.wld"',
        'ground = [{ use = "gaussian", std = -1 }]',
        'on_collision = "x"',
        "shape = { circle = -1 }",
        "fiducial = -4",
    ),
    "robots.1": ('name = "box"', 'colour = "nope"'),
    "obstacles.0": (
        "spead = 1",
        'colour = "nope"',
        'motion = { use = "nope" }',
        "shape = { circle = -1 }",
        "count = 0",
    ),
    "zones.0": ("shape = { circle = -1 }", 'ground = [{ use = "nope" }]', "extra = 1"),
    "landmarks.0": ("id = 0", 'x = "a"'),
    "lights.0": ('x = "a"',),
}


def text(wrong: dict[str, tuple[str, ...]]) -> str:
    """A scenario in which these lines stand in place of the right ones."""
    lines = ["format = 1", "[world]", 'map = "room.wld"']
    for place, right in HEADS.items():
        name, _, number = place.partition(".")
        said = {line.partition(" =")[0]: line for line in (*right, *wrong.get(place, ()))}
        lines += [f"[[{name}]]" if number else f"[{name}]", *said.values()]
    return "\n".join(lines) + "\n"


@pytest.fixture
def paths_of(tmp_path: Path):
    (tmp_path / "room.wld").write_text("width 9000\nheight 9000\n")

    def found(wrong: dict[str, tuple[str, ...]]) -> set[str]:
        return {fault.path for fault in am.Document(text(wrong), tmp_path / "one.toml").faults()}

    return found


def test_without_them_there_is_no_fault(paths_of) -> None:
    assert paths_of({}) == set()


@pytest.mark.parametrize("place", HEADS)
def test_no_fault_hides_another(paths_of, place: str) -> None:
    together = paths_of(WRONG)
    for line in WRONG[place]:
        alone = paths_of({place: (line,)})
        assert alone, line
        if not line.startswith("name"):  # of one of unknown number, nobody knows what it is called
            assert alone <= together, line
