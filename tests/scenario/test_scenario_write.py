"""Documents and files of scenarios: complete, readable, and read again as the same scenario, bit for bit."""

import math
import tomllib

import attrs
import pytest
from hypothesis import HealthCheck, given
from hypothesis import strategies as st

from amorsim.contracts import Mount, Noise
from amorsim.core.errors import RunError, ScenarioError
from amorsim.core.maps.map import Map
from amorsim.core.shapes import Shape
from amorsim.drives.differential import Differential
from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.noise.gaussian import Gaussian
from amorsim.noise.saturate import Saturate
from amorsim.scenario.files.maps import load_map
from amorsim.scenario.files.resolved import resolved, resolved_table
from amorsim.scenario.files.write import table_text, with_copies, write_table
from amorsim.scenario.knowledge import Knowledge
from amorsim.scenario.reading.read import load, loads
from amorsim.scenario.spec import Deviation, Distribution, MountedSensor, NoiseElement, Obstacle, Pose, Robot, Scenario
from amorsim.scenario.toml.angles import parse_float
from amorsim.sensors.compass import Compass
from amorsim.sensors.laser import Laser
from tests.disks import small_disk
from tests.examples import settings

FULL = """
format = 1
[world]
map = "room.wld"
resolution = 0.05
[simulation]
dt = 0.05
[[robots]]
name = "rover"
model = "pioneer2dx"
controller = { use = "mine.py:drive", speed = 0.25, gains = [1, 2.5], names = { left = "a" } }
ground = [{ use = "diffusion", variance_per_length = 1e-6 }]
sensors.sonar = false
drive.acceleration_max_deg = "none"
[robots.errors]
drive.track = { scale = { normal = [1.0, 0.02] }, per = "study" }
sensors.laser.mount.heading_deg = { add = 0.5, scale = 2.0 }
pose.heading_deg = 12.0
[robots.knowledge]
map = "room.wld"
landmarks = [[1, 2]]
[[robots]]
name = "scout"
model = "pioneer2dx"
pose = { x = 3.0, y = 1.0 }
controller = { use = "goto", x = 1.0, y = 1.0 }
[[obstacles]]
name = "box"
shape = { polygon = [[0, 0], [1, 0], [0, 1]], rounding = 0.1 }
pose = { x = 3.0, y = 2.0, heading_deg = 33.3 }
"""


@pytest.fixture
def full(read, folder):
    (folder / "mine.py").write_text("def drive(readings, estimate, clock, speed, gains, names):\n    return None\n")
    return read(FULL)


def parts(scenario):
    """All of a scenario that files determine, with maps by their cells."""
    robots = [
        attrs.asdict(attrs.evolve(robot, knowledge=Knowledge(landmarks=robot.knowledge.landmarks)), recurse=False)
        for robot in scenario.robots
    ]
    obstacles = [attrs.asdict(obstacle, recurse=False) for obstacle in scenario.obstacles]
    others = (scenario.dt, scenario.duration, scenario.seed, scenario.recording)
    return robots, obstacles, others, scenario.map.to_array().tobytes()


def test_a_resolved_document_is_read_as_the_same_scenario(full, registry):
    again = loads(resolved(full), "/nowhere", registry=registry)
    assert parts(again) == parts(full)
    assert again.resolved == full.resolved
    assert "model" not in full.resolved["robots"][0]


def test_written_and_read_it_is_the_same(full, registry, tmp_path):
    path = tmp_path / "scenario.toml"
    write_table(full.resolved, path)
    assert tomllib.loads(path.read_text(), parse_float=parse_float) == full.resolved
    again = load(path, registry=registry)
    assert parts(again) == parts(full)
    second = tmp_path / "again.toml"
    write_table(again.resolved, second)
    assert second.read_bytes() == path.read_bytes()


def test_the_text_has_a_table_a_thing_and_short_things_on_a_line(full):
    text = table_text(full.resolved)
    headers = [line for line in text.splitlines() if line.startswith("[")]
    assert headers == [
        "[world]",
        "[simulation]",
        "[recording]",
        *[
            header
            for robot in ("rover", "scout")
            for header in (
                "[[robots]]",
                "[robots.shape]",
                "[robots.drive]",
                "[robots.sensors.encoder]",
                "[robots.sensors.laser]",
                *(["[robots.sensors.sonar]"] if robot == "scout" else []),
                "[robots.sensors.compass]",
                "[robots.sensors.gyro]",
                "[robots.estimators.dead_reckoning]",
                *(
                    ["[robots.errors.drive]", "[robots.errors.sensors.laser.mount]", "[robots.errors.pose]"]
                    if robot == "rover"
                    else []
                ),
                *(["[robots.knowledge]"] if robot == "rover" else []),
            )
        ],
        "[[obstacles]]",
    ]
    assert "mount = {x = 0.017, y = 0.008, heading_deg = 0.0}" in text
    assert "acceleration_max_deg" not in text.split('name = "scout"')[0], "none by default, so none is left out"
    assert max(len(line) for line in text.splitlines()) < 200


def test_every_default_is_there(full):
    scout = full.resolved["robots"][1]
    assert scout["controller"]["tolerance"] > 0
    assert scout["sensors"]["laser"]["noise"][0] == {
        "use": "gaussian",
        "name": "gaussian",
        "std": 0.005,
        "proportional": 0.0,
        "per": "sample",
    }
    assert full.resolved["world"]["push_sign"] == "clockwise"
    assert full.resolved["simulation"] == {"dt": 0.05, "duration": 60.0, "seed": 0}


def test_copies_make_a_folder_that_runs_by_itself(full, registry, folder, tmp_path):
    document = with_copies(full, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.py", "room.wld"]
    assert document["world"]["map"] == "room.wld"
    assert document["robots"][0]["controller"]["use"] == "mine.py:drive"
    assert document["robots"][0]["knowledge"]["map"] == "room.wld"
    assert full.resolved["world"]["map"] == str(folder / "room.wld"), "the scenario's own document stays"
    write_table(document, tmp_path / "scenario.toml")
    moved = tmp_path.rename(tmp_path.with_name("moved"))
    again = load(moved / "scenario.toml", registry=registry)
    assert again.map.to_array().tobytes() == full.map.to_array().tobytes()
    assert again.robots[0].controller.source == f"{(moved / 'mine.py').resolve()}:drive"
    assert with_copies(again, moved) == document, "a folder's files are not copied onto themselves"


def test_files_of_one_name_from_two_places_are_both_kept(read, registry, folder, tmp_path):
    other = folder / "other"
    other.mkdir(exist_ok=True)
    (other / "room.wld").write_text("width 2000\nheight 2000\n")
    scenario = read(
        '[[robots]]\nmodel = "pioneer2dx"\nknowledge.map = "other/room.wld"\n'
        '[[robots]]\nname = "b"\nmodel = "pioneer2dx"\n'
        'knowledge.map = "other/room.wld"\n'
    )
    document = with_copies(scenario, tmp_path)
    assert document["world"]["map"] == "room.wld"
    assert [robot["knowledge"]["map"] for robot in document["robots"]] == ["room_2.wld", "room_2.wld"]
    assert (tmp_path / "room_2.wld").read_bytes() == (other / "room.wld").read_bytes()


def test_a_controller_called_as_a_file_of_the_run_is_renamed(read, folder, tmp_path):
    (folder / "scenario.toml.py").write_text("def f(a, b, c):\n    return None\n")
    (folder / "poses.csv").write_text("width 2000\nheight 2000\n")
    scenario = read('format = 1\n[world]\nmap = "poses.csv"\nuse = "wld"\n[[robots]]\nmodel = "pioneer2dx"\n')
    assert with_copies(scenario, tmp_path)["world"]["map"] == "poses_2.csv"


def test_what_cannot_be_copied_or_written_is_said(full, tmp_path):
    with pytest.raises(RunError, match=r"none/\S+: cannot be written \(No such file or directory\)"):
        with_copies(full, tmp_path / "none")
    with pytest.raises(RunError, match="cannot be written"):
        write_table(full.resolved, tmp_path / "none" / "scenario.toml")


def test_a_full_disk_leaves_the_scenario_that_was_there(full, tmp_path):
    file = tmp_path / "scenario.toml"
    file.write_text("format = 1\n")
    with small_disk(), pytest.raises(RunError, match=r"scenario\.toml: cannot be written \(File too large\)"):
        write_table(full.resolved, file)
    assert file.read_text() == "format = 1\n"
    assert list(tmp_path.iterdir()) == [file]


def robot(**changes):
    given = {
        "shape": Shape.circle(0.2),
        "drive": Differential(wheel_radius_left=0.1, wheel_radius_right=0.1, track=0.4, rate_max=10.0),
        "estimators": {"odometry": DeadReckoning()},
        "pose": Pose(x=1.0, y=1.0),
    }
    return Robot(**(given | changes))


def test_a_scenario_built_in_python_has_a_document_too(registry, folder):
    scenario = Scenario(
        map=load_map(folder / "room.wld", registry=registry),
        robots=[
            robot(
                sensors={
                    "laser": Laser(beams=3, fov=1.2000000000000002, range_max=5),
                    "compass": MountedSensor(
                        sensor=Compass(),
                        mount=Mount(heading=1.2),
                        noise=(
                            NoiseElement(name="n", noise=Gaussian(std=0.012345678901234567)),
                            NoiseElement(name="s", noise=Saturate(minimum=-1.0)),
                        ),
                    ),
                },
                errors={
                    "drive.track": Deviation(scale=Distribution(kind="normal", values=(1.0, 0.1))),
                    "sensors.laser.fov": Deviation(add=-0.2),
                },
            )
        ],
        obstacles=[Obstacle(name="post", shape=Shape.circle(0.05), pose=Pose(x=2.0, y=2.0, heading=1.2))],
        dt=1,
    )
    document = resolved_table(scenario, registry=registry)
    assert type(document["simulation"]["dt"]) is float
    again = loads(tomllib.loads(table_text(document), parse_float=parse_float), "/", registry=registry)
    assert parts(again) == parts(scenario)


def test_what_has_no_name_in_a_file_is_listed(registry):
    @attrs.frozen(kw_only=True)
    class Mine(Noise):
        def corrupt(self, values, side, elapsed, state, draws):
            return values

    scenario = Scenario(
        map=Map.from_segments([], extent=(0, 0, 4, 4), resolution=0.1),
        robots=[
            robot(
                ground=(NoiseElement(name="mine", noise=Mine()),),
                controller=lambda readings, estimate, clock: None,
                errors={"drive.trakc": Deviation(add=1.0)},
                shape=Shape.polygon([(0, 0), (2, 0), (2, 2), (1, 0.5), (0, 2)], rounding=0.1),
            )
        ],
    )
    with pytest.raises(ScenarioError) as caught:
        resolved_table(scenario, registry=registry)
    found = {fault.path: fault.message for fault in caught.value.faults}
    assert set(found) == {"world.map", "robots.0.ground.0", "robots.0.controller", "robots.0.errors", "robots.0.shape"}
    assert "Mine is not registered" in found["robots.0.ground.0"]
    assert "FILE.py:" in found["robots.0.controller"]


FINITE = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e9, max_value=1e9)
POSITIVE = st.floats(min_value=1e-9, max_value=1e9)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    x=FINITE,
    heading=st.floats(-10.0, 10.0),
    radius=st.floats(4e-3, 10.0),
    rate=st.none() | POSITIVE,
    fov=st.floats(0.01, 2 * math.pi),
    std=st.floats(0.0, 10.0),
    dt=st.floats(1e-6, 10.0),
    seed=st.integers(0, 2**63 - 1),
    errors=st.dictionaries(
        st.sampled_from(["drive.track", "sensors.compass.mount.heading", "sensors.laser.mount.x", "pose.heading"]),
        st.builds(
            Deviation,
            scale=st.floats(0.5, 2.0)
            | st.builds(lambda a, b: Distribution(kind="normal", values=(a, b)), FINITE, POSITIVE),
            add=st.floats(0.0, 10.0)
            | st.builds(lambda a, b: Distribution(kind="uniform", values=(a, a + b)), FINITE, POSITIVE),
            per=st.sampled_from(["replica", "study"]),
        ),
    ),
)
def test_any_numbers_survive_being_written(registry, folder, x, heading, radius, rate, fov, std, dt, seed, errors):
    scenario = Scenario(
        map=load_map(folder / "room.wld", registry=registry, resolution=0.1),
        robots=[
            robot(
                pose=Pose(x=x, heading=heading),
                shape=Shape.circle(radius),
                drive=Differential(wheel_radius_left=radius, wheel_radius_right=0.1, track=radius, rate_max=radius),
                sensors={
                    "laser": MountedSensor(sensor=Laser(fov=fov), rate=rate, mount=Mount(x=x)),
                    "compass": MountedSensor(
                        sensor=Compass(), noise=(NoiseElement(name="a", noise=Gaussian(std=std)),)
                    ),
                },
                errors=errors,
            )
        ],
        dt=dt,
        seed=seed,
    )
    text = table_text(resolved_table(scenario, registry=registry))
    again = loads(tomllib.loads(text, parse_float=parse_float), "/", registry=registry)
    assert parts(again) == parts(scenario)
    assert table_text(again.resolved) == text
