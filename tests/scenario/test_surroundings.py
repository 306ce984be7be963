"""Landmarks, lamps, and how bodies look, in scenario files; and chains of sensors with columns."""

import tomllib

import pytest

from amorsim.core.errors import ScenarioError
from amorsim.core.parameters import ParameterError
from amorsim.noise import AimGaussian, Gaussian
from amorsim.scenario.files.write import table_text
from amorsim.scenario.reading.read import loads
from amorsim.scenario.spec import Landmark, MountedSensor, NoiseElement, Obstacle
from amorsim.sensors import Compass, Fiducial
from tests.building import robot

TEXT = """
format = 1
[world]
map = "room.wld"
resolution = 0.1
[[robots]]
name = "rover"
model = "pioneer2dx"
pose = { x = 1.0, y = 1.0 }
colour = "red"
fiducial = 12
height = 0.25
knowledge = { landmarks = "world" }
[robots.sensors.finder]
use = "fiducial"
noise = [
    { use = "gaussian", column = "range", std = 0.02 },
    { use = "gaussian", column = "bearing", std_deg = 1.0 },
    { use = "dropout", column = "range", probability = 0.1 },
]
[[robots]]
name = "scout"
model = "pioneer2dx"
pose = { x = 3.0, y = 1.0 }
knowledge = { landmarks = [[1.0, 2.0], { id = 4, x = 2.0, y = 0.5 }] }
[[obstacles]]
shape = { circle = 0.1 }
pose = { x = 2.0, y = 2.0 }
fiducial = 3
colour = "#00ff00"
[[landmarks]]
id = 1
x = 0.5
y = 2.5
colour = "orange"
[[landmarks]]
id = 2
radius = 0.0
[[lights]]
x = 2.0
intensity = 5.0
"""


def read_text(text, folder, registry, overrides=()):
    return loads(tomllib.loads(text), folder, overrides, registry=registry)


def test_everything_is_read(folder, registry):
    made = read_text(TEXT, folder, registry)
    assert made.landmarks == (Landmark(id=1, x=0.5, y=2.5, colour="orange"), Landmark(id=2, radius=0.0))
    assert [(light.x, light.y, light.intensity) for light in made.lights] == [(2.0, 0.0, 5.0)]
    rover, scout = made.robots
    assert (rover.colour, rover.fiducial, rover.height) == ("red", 12, 0.25)
    assert (scout.colour, scout.fiducial, scout.height) == (None, 0, 0.3)
    assert (made.obstacles[0].colour, made.obstacles[0].fiducial) == ("#00ff00", 3)
    assert rover.knowledge.landmarks == ((0.5, 2.5), (0.0, 0.0))
    assert rover.knowledge.landmark_ids == (1, 2)
    assert scout.knowledge.landmarks == ((1.0, 2.0), (2.0, 0.5))
    assert scout.knowledge.landmark_ids == (0, 4)
    chain = rover.sensors["finder"].noise
    assert [(e.name, e.column) for e in chain] == [
        ("gaussian", "range"),
        ("gaussian_2", "bearing"),
        ("dropout", "range"),
    ]
    assert chain[1].noise.std == pytest.approx(0.0174532925199)


def test_written_it_is_read_as_the_same(folder, registry):
    made = read_text(TEXT, folder, registry)
    again = read_text(table_text(made.resolved), folder, registry)
    assert again.resolved == made.resolved
    assert again.landmarks == made.landmarks
    assert again.lights == made.lights
    assert again.robots[0].sensors == made.robots[0].sensors
    assert [r.knowledge.landmark_ids for r in again.robots] == [(1, 2), (0, 4)]


def test_a_setting_moves_a_landmark(folder, registry):
    assert read_text(TEXT, folder, registry, ["landmarks.1.x=2.5"]).landmarks[1].x == 2.5


@pytest.mark.parametrize(
    ("old", "new", "path", "says"),
    [
        (
            'column = "range", std',
            'column = "rnge", std',
            "robots.0.sensors.finder.noise.0.column",
            "Did you mean",
        ),
        ('column = "range", std', "std", "robots.0.sensors.finder.noise.0.column", "'range', 'bearing', 'id'"),
        ("std_deg = 1.0", "std = 1.0", "robots.0.sensors.finder.noise.1.std", "std_deg"),
        ('colour = "red"', 'colour = "reddish"', "robots.0.colour", "CSS"),
        ('colour = "#00ff00"', 'colour = "#00ff0"', "obstacles.0.colour", "CSS"),
        ("fiducial = 12", "fiducial = 1.5", "robots.0.fiducial", "whole number"),
        ("id = 2", "id = 0", "landmarks.1.id", ">= 1"),
        ("id = 2", "name = 'b'\nid = 2", "landmarks.1.name", "unknown key"),
        ("intensity = 5.0", "intensity = -5.0", "lights.0.intensity", ">= 0"),
        ('landmarks = "world"', 'landmarks = "map"', "robots.0.knowledge.landmarks", "'world'"),
        ("{ id = 4, x = 2.0,", "{ id = 4,", "robots.1.knowledge.landmarks.1.x", "missing"),
        ("[1.0, 2.0]", "[1.0]", "robots.1.knowledge.landmarks.0", "two finite numbers"),
    ],
)
def test_a_mistake_is_named_by_its_path(folder, registry, old, new, path, says):
    assert old in TEXT
    with pytest.raises(ScenarioError) as caught:
        read_text(TEXT.replace(old, new, 1), folder, registry)
    assert [fault.path for fault in caught.value.faults] == [path]
    assert says in caught.value.faults[0].message


def test_a_ground_chain_has_no_columns(folder, registry):
    text = TEXT.replace('colour = "red"', 'ground = [{ use = "bias", column = "x", value = 0.1 }]')
    with pytest.raises(ScenarioError, match=r"robots\.rover\.ground\.0\.column: this chain has no columns"):
        read_text(text, folder, registry)


def test_in_python_the_same_is_refused():
    with pytest.raises(ParameterError, match="several quantities"):
        MountedSensor(sensor=Fiducial(), noise=(Gaussian(std=0.1),))
    with pytest.raises(ParameterError, match="one quantity"):
        MountedSensor(sensor=Compass(), noise=(NoiseElement(name="n", noise=Gaussian(std=0.1), column="range"),))
    MountedSensor(sensor=Fiducial(), noise=(AimGaussian(std=0.1),))  # in no unit of the sensor's
    with pytest.raises(ParameterError, match="colour"):
        Landmark(id=1, colour="nothing")
    with pytest.raises(ParameterError, match="colour"):
        robot(colour="nothing")
    with pytest.raises(ParameterError, match="colour"):
        Obstacle(name="o", shape=robot().shape, colour="nothing")


def test_mounts_and_numbers_have_errors(folder, registry):
    text = TEXT.replace(
        'colour = "red"', "errors = { sensors.finder.mount.heading_deg = 1.5, sensors.finder.fov_deg = 90 }"
    )
    rover = read_text(text, folder, registry).robots[0]
    assert set(rover.errors) == {"sensors.finder.mount.heading", "sensors.finder.fov"}


@pytest.mark.parametrize("path", ["finder.slots", "bumper.segments.0.end_deg"])
def test_what_fixes_shapes_has_no_error(folder, registry, path):
    text = (
        TEXT[: TEXT.index("[[robots]]")]
        + f"""
[[robots]]
model = "pioneer2dx"
pose = {{ x = 1.0, y = 1.0 }}
sensors = {{ finder = {{ use = "fiducial" }}, bumper = {{ use = "bumper" }} }}
errors = {{ sensors.{path} = 3.0 }}
"""
    )
    with pytest.raises(ScenarioError, match=rf"errors\.sensors\.{path}: .*is fixed once a simulation is made"):
        read_text(text, folder, registry)
