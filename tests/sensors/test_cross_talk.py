"""What sonars hear of one another, against the geometry of sound: straight across, and mirrored by a wall."""

import math

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.core.shapes import Shape
from amorsim.noise import CrossTalk, Gaussian, SpecularLoss
from amorsim.sensors import Laser, Sonar
from amorsim.sensors.hearing import SOUND
from amorsim.testing import check_component
from tests import building
from tests.noise.sampling import assert_share

HALF = math.radians(15.0)
# The ray nearest to the mirror's way is half a step of the fan beside it.
STEP = HALF / 60.0
US = "ultrasound"


def sonar(**changes):
    return Sonar(**({"half_angle": HALF, "range_min": 0.1, "range_max": 5.0, "medium": US} | changes))


def robot(name, x, y, heading, *noise, radius=0.1, **changes):
    """A disc with a transducer at its front, that looks ahead."""
    unit = am.MountedSensor(sensor=sonar(**changes), mount=am.Mount(x=radius), noise=noise or (CrossTalk(),))
    return building.robot(
        name=name,
        shape=Shape.circle(radius),
        sensors={"sonar": unit},
        estimators={},
        pose=am.Pose(x=x, y=y, heading=heading),
    )


def readings(*robots, map_=None, replicas=1, obstacles=(), steps=0):
    """True and measured readings by robot, of the first replica."""
    sim = am.Simulation(
        building.scenario(*robots, map=map_ or building.room(12.0, 10.0), obstacles=obstacles), replicas=replicas
    )
    for _ in range(steps):
        sim.step()
    return {
        r.name: tuple(part.tolist() for part in sim.robot(r.name, sim.replicas[0]).readings["sonar"][:2])
        for r in robots
    }


def mirrored(receiver, emitter, wall, normal):
    """Length of the way by a wall through a point, with a unit normal: straight to the emitter's image."""
    emitter, receiver = np.array(emitter), np.array(receiver)
    behind = 2.0 * np.dot(np.array(wall) - emitter, normal)
    return float(np.hypot(*(emitter + behind * np.array(normal) - receiver)))


def allowed(distance, slant):
    """By how much half the way by the nearest ray's end may exceed half the mirror's, at a wall of 1 mm cells.

    The way by a point u beside the mirror's is longer by at most u^2 / distance, where a step of the fan moves the
    point by at most distance / cos(slant)^2; the wall itself is a cell thick, and steps of cells where it slants.
    """
    return 0.5 * (distance * STEP / math.cos(slant) ** 2) ** 2 / distance + 1.5e-3


def test_two_that_face_each_other_read_half_the_way_between_them():
    found = readings(robot("a", 2.0, 5.0, 0.0), robot("b", 6.0, 5.0, math.pi))
    for true, measured in found.values():
        assert measured == pytest.approx([1.9], abs=1e-9)  # 3.8 m between the transducers
        assert true == pytest.approx([3.8], abs=1e-9)


@pytest.mark.parametrize("late", [-0.004, -0.001, 0.002, 0.006])
def test_who_fires_later_reads_nearer_and_who_fires_earlier_farther(late):
    found = readings(robot("a", 2.0, 5.0, 0.0), robot("b", 6.0, 5.0, math.pi, phase=late))
    expected = 0.5 * (3.8 + SOUND * late)  # what a hears of b, that fires so much later
    assert found["a"][1] == pytest.approx([min(expected, 3.8)], abs=1e-9)
    assert found["b"][1] == pytest.approx([min(0.5 * (3.8 - SOUND * late), 3.8)], abs=1e-9)


def test_sound_that_comes_before_one_listens_is_not_heard():
    found = readings(robot("a", 2.0, 5.0, 0.0), robot("b", 6.0, 5.0, math.pi, phase=-3.7 / SOUND))
    assert found["a"][1] == found["a"][0]  # it would read 5 cm, where the transducer still rings


def test_bodies_walls_and_cones_keep_sound_off():
    alone = readings(robot("a", 2.0, 5.0, 0.0))["a"][1]
    assert not math.isfinite(alone[0])
    away = readings(robot("a", 2.0, 5.0, 0.0), robot("b", 6.0, 5.0, math.pi + 1.2 * HALF))
    assert away["a"][1] == away["a"][0]
    between = am.Obstacle(name="post", shape=Shape.circle(0.2), pose=am.Pose(x=4.0, y=5.0))
    found = readings(robot("a", 2.0, 5.0, 0.0), robot("b", 6.0, 5.0, math.pi), obstacles=[between])
    assert found["a"][1] == found["a"][0] == pytest.approx([1.7], abs=1e-6)
    other = readings(robot("a", 2.0, 5.0, 0.0), robot("b", 6.0, 5.0, math.pi, medium="40kHz"))
    assert other["a"][1] == other["a"][0]


def test_a_wall_keeps_sound_off_behind_the_robot_that_emits_it_too():
    """Its transducer is on an arm, on the other side of the robot and of the wall, and looks back at the listener."""
    unit = am.MountedSensor(sensor=sonar(), mount=am.Mount(x=3.0, heading=math.pi), noise=(CrossTalk(),))
    emitter = attrs.evolve(robot("b", 4.0, 5.0, 0.0), sensors={"sonar": unit})
    listener = robot("a", 2.0, 5.0, 0.0, phase=5e-3)
    true, measured = readings(listener, emitter)["a"]
    assert true == pytest.approx([1.8], abs=1e-9)
    assert measured == pytest.approx([0.5 * (4.9 - 5e-3 * SOUND)], abs=1e-9)  # through its own robot
    wall = Map.from_segments(np.concatenate((building.room(12.0, 10.0).segments, [(5.5, 4.0, 5.5, 6.0)])))
    true, measured = readings(listener, emitter, map_=wall)["a"]
    assert measured == true


def test_an_obstacle_that_leaves_the_line_free_does_not():
    beside = am.Obstacle(name="post", shape=Shape.circle(0.05), pose=am.Pose(x=5.5, y=5.1))
    found = readings(robot("a", 2.0, 5.0, 0.0), robot("b", 6.0, 5.0, math.pi), obstacles=[beside])
    assert found["a"][1] == pytest.approx([1.9], abs=1e-9)


def test_the_hull_of_the_robot_that_emits_reflects_nothing_of_its_own_sound():
    """The emitter, well within its hull, looks aside: a part of the hull lies in both cones, the way across in none."""
    aside = am.MountedSensor(sensor=sonar(), mount=am.Mount(x=0.05, heading=math.radians(40.0)), noise=(CrossTalk(),))
    b = building.robot(
        name="b",
        shape=Shape.circle(0.3),
        sensors={"sonar": aside},
        estimators={},
        pose=am.Pose(x=4.0, y=5.0, heading=math.pi),
    )
    true, measured = readings(robot("a", 2.0, 5.0, 0.0, phase=2e-3), b, map_=building.empty(30.0))["a"]
    assert true == pytest.approx([1.6], abs=1e-3)
    assert measured == true  # by the hull, b's sound would come 2 ms before the echo of a's own


@pytest.mark.parametrize("radius", [0.1, 0.2667])
def test_round_robots_that_face_each_other_hear_each_other_from_rim_to_rim(radius):
    """By rounding, the rim is a little nearer than the emitter on it, or a little farther."""
    random = np.random.default_rng(4)
    for _ in range(40):
        x, y, heading, apart = random.uniform((2.0, 2.0, -math.pi, 0.5), (8.0, 8.0, math.pi, 2.0))
        to = apart + 2.0 * radius
        there = x + to * math.cos(heading), y + to * math.sin(heading), heading + math.pi
        pair = robot("a", x, y, heading, radius=radius), robot("b", *there, radius=radius)
        for _, measured in readings(*pair, map_=building.empty(30.0)).values():
            assert measured == pytest.approx([apart / 2.0], abs=1e-9)


def test_a_post_beside_the_hull_keeps_sound_off_though_the_hull_reaches_as_far_elsewhere():
    unit = am.MountedSensor(sensor=sonar(), mount=am.Mount(y=0.1, heading=math.pi / 2), noise=(CrossTalk(),))
    b = building.robot(
        name="b",
        shape=Shape.rectangle(1.0, 0.2),
        sensors={"sonar": unit},
        estimators={},
        pose=am.Pose(x=6.0, y=5.0, heading=math.pi / 2),
    )
    post = am.Obstacle(name="post", shape=Shape.circle(0.05), pose=am.Pose(x=5.7, y=5.0))
    found = readings(robot("a", 2.0, 5.0, 0.0, phase=2e-3), b, obstacles=[post])
    assert found["a"][1] == found["a"][0]


@pytest.mark.parametrize("apart", [0.4, 0.8, 1.2])
@pytest.mark.parametrize("distance", [1.5, 3.0])
def test_a_wall_mirrors_the_sound_of_a_neighbour(distance, apart):
    """Side by side before a wall, the one half a millisecond earlier: the other hears it before its own echo."""
    slant = math.atan2(apart / 2.0, distance)
    if slant > HALF:
        pytest.skip("out of the cones")
    early = 1.5e-3
    x = 12.0 - distance - 0.1
    found = readings(robot("a", x, 5.0, 0.0), robot("b", x, 5.0 + apart, 0.0, phase=-early))
    way = mirrored((12.0 - distance, 5.0), (12.0 - distance, 5.0 + apart), (12.0, 0.0), (1.0, 0.0))
    assert way == pytest.approx(math.hypot(2.0 * distance, apart))
    expected = 0.5 * (way - SOUND * early)
    assert found["a"][0] == pytest.approx([distance], abs=2e-3)
    assert -1.5e-3 <= found["a"][1][0] - expected <= allowed(distance, slant)


@pytest.mark.parametrize("slope_deg", [20.0, 35.0])
def test_a_slanting_wall_leads_sound_from_one_robot_to_another(slope_deg):
    """Two that look at one wall from either side: far off the normal, yet the mirror's way is in both cones."""
    slope = math.radians(slope_deg)
    wall = Map.from_segments(
        np.array([(0.0, 8.0, 12.0, 8.0), (0.0, 0.0, 12.0, 0.0), (0.0, 0.0, 0.0, 8.0), (12.0, 0.0, 12.0, 8.0)]),
        resolution=0.001,
    )
    # From (x, y) the wall above is met at (6, 8) under the slant.
    down = 3.0
    reach = down * math.tan(slope)
    a = robot("a", 6.0 - reach - 0.1 * math.sin(slope), 8.0 - down - 0.1 * math.cos(slope), math.pi / 2 - slope)
    b = robot("b", 6.0 + reach + 0.1 * math.sin(slope), 8.0 - down - 0.1 * math.cos(slope), math.pi / 2 + slope)
    found = readings(a, b, map_=wall)
    expected = down / math.cos(slope)
    for true, measured in found.values():
        # The shortest way to the wall alone is along the cone's edge, that of both together the mirror's.
        assert true == pytest.approx([down / math.cos(slope - HALF)], abs=2e-3)
        assert measured == true
    lost = [SpecularLoss(critical=math.radians(4.0)), CrossTalk()]
    a, b = (
        building.robot(
            name=r.name,
            shape=r.shape,
            pose=r.pose,
            estimators={},
            sensors={"sonar": am.MountedSensor(sensor=sonar(), mount=am.Mount(x=0.1), noise=tuple(lost))},
        )
        for r in (a, b)
    )
    found = readings(a, b, map_=wall)
    for _, measured in found.values():
        assert -1.5e-3 <= measured[0] - expected <= allowed(expected, slope + HALF)


@pytest.mark.long
def test_a_ring_hears_its_own_elements_by_a_wall_in_their_turns():
    """Two elements 0.3 m apart before a wall, that fire 2 ms one after the other."""
    pair = (am.Mount(y=-0.15), am.Mount(y=0.15))
    unit = am.MountedSensor(
        sensor=sonar(elements=pair, firing=(0, 1), interval=0.002), mount=am.Mount(x=0.1), noise=(CrossTalk(),)
    )
    rover = building.robot(
        shape=Shape.circle(0.1), sensors={"sonar": unit}, estimators={}, pose=am.Pose(x=9.9, y=5.0, heading=0.0)
    )
    ((true, measured),) = readings(rover).values()
    way = math.hypot(2.0 * 2.0, 0.3)
    assert true == pytest.approx([2.0, 2.0], abs=2e-3)
    assert measured[0] == true[0]  # the other's sound comes 2 ms after its own echo
    assert -1.5e-3 <= measured[1] - 0.5 * (way - 0.002 * SOUND) <= allowed(2.0, 0.1)


def test_nothing_hears_its_own_echo_whatever_sensors_come_after_it():
    """A wall met askew sends the own pulse away, which is not a sound of others."""
    noise = (SpecularLoss(critical=0.1), CrossTalk())
    unit = am.MountedSensor(sensor=sonar(), mount=am.Mount(x=0.1), noise=noise)
    tail = {"tail": am.MountedSensor(sensor=Laser(beams=3), mount=am.Mount(x=-0.1))}
    for more in ({}, tail):
        rover = building.robot(
            shape=Shape.circle(0.1),
            sensors={"sonar": unit} | more,
            estimators={},
            pose=am.Pose(x=9.9, y=5.0, heading=math.radians(35.0)),
        )
        sim = am.Simulation(building.scenario(rover, map=building.room(12.0, 10.0)))
        reading = sim.robot("rover").readings["sonar"]
        assert np.isfinite(reading.true).all()
        assert np.isinf(reading.measured).all()


def test_elements_that_fire_together_hear_their_own_echo_first():
    """At one distance from a flat wall, no way to a neighbour is shorter than to oneself."""
    ring = tuple(am.Mount(y=0.05 * i) for i in range(7))
    unit = am.MountedSensor(sensor=sonar(elements=ring), mount=am.Mount(x=0.1), noise=(CrossTalk(),))
    rover = building.robot(
        shape=Shape.circle(0.1), sensors={"sonar": unit}, estimators={}, pose=am.Pose(x=9.9, y=5.0, heading=0.0)
    )
    ((true, measured),) = readings(rover).values()
    assert true == measured


def test_a_sonar_without_a_medium_is_silent_and_deaf():
    quiet = robot("b", 6.0, 5.0, math.pi, Gaussian(), medium="")
    found = readings(robot("a", 2.0, 5.0, 0.0), quiet)
    assert found["a"][1] == found["a"][0]
    sim = am.Simulation(building.scenario(quiet, map=building.room(12.0, 10.0)))
    assert not sim._fleet.has_emitters  # nobody is even asked


@pytest.mark.long
def test_sound_is_taken_for_an_echo_as_often_as_set():
    a = robot("a", 2.0, 5.0, 0.0, CrossTalk(probability=0.3))
    b = robot("b", 6.0, 5.0, math.pi)
    sim = am.Simulation(building.scenario(a, b, map=building.room(12.0, 10.0)), replicas=2000)
    taken = []
    for _ in range(5):
        sim.step()
        rows = np.array([sim.robot("a", r).readings["sonar"].measured[0] for r in range(2000)])
        taken.append(rows < 2.0)
    assert_share(np.array(taken), 0.3)


def test_cross_talk_leaves_the_draws_of_others():
    def error(*noise):
        found = readings(robot("a", 2.0, 5.0, 0.0, *noise), robot("b", 6.0, 5.0, math.pi), steps=3)["a"]
        return found[1][0] - found[0][0]

    white = Gaussian(std=0.01)
    assert error(CrossTalk(probability=0.0), white) == error(white) != 0.0
    assert error(CrossTalk(), white) == pytest.approx(error(white) + error(CrossTalk()), abs=1e-12)


def test_a_sensor_that_does_not_tell_what_it_hears_is_refused():
    for sensor in (Laser(beams=3), Sonar()):
        unit = am.MountedSensor(sensor=sensor, noise=(CrossTalk(),))
        with pytest.raises(am.ComponentError, match="expected a sonar that reports what it hears, one with a medium"):
            am.Simulation(building.scenario(building.robot(sensors={"sonar": unit}, estimators={})))


def test_each_element_has_a_turn():
    with pytest.raises(ParameterError, match="expected a turn for each of 1 elements, got 2"):
        sonar(firing=(0, 1))


@pytest.mark.long
def test_a_sonar_that_fires_into_a_medium_keeps_its_contract():
    ring = tuple(am.Mount(x=0.1, heading=heading) for heading in (-0.6, 0.0, 0.6))
    check_component(sonar(elements=ring, firing=(0, 1, 0), half_angle=0.3))


def test_threads_replicas_and_rows_leave_the_bits():
    crowd = [
        building.robot(
            name=f"r{i}",
            shape=Shape.circle(0.1),
            pose=am.Pose(x=3.0 + 1.1 * (i % 3), y=3.0 + 1.3 * (i // 3), heading=0.9 * i),
            controller=building.Roam(),
            on_collision="continue",
            estimators={},
            sensors={
                "encoder": building.encoder(),
                "sonar": am.MountedSensor(
                    sensor=sonar(
                        elements=tuple(am.Mount(x=0.1, heading=math.pi * j / 4) for j in range(8)),
                        firing=tuple(range(8)),
                        interval=0.001,
                    ),
                    noise=(SpecularLoss(critical=0.4), CrossTalk(probability=0.7), Gaussian(std=0.01)),
                ),
            },
            errors={"sensors.sonar.phase": am.Deviation(add=am.Distribution(kind="uniform", values=(0.0, 0.008)))},
        )
        for i in range(6)
    ]
    scenario = building.scenario(*crowd, map=building.room(8.0, 8.0))
    many = am.Simulation(scenario, replicas=5)
    many.run(1.0)
    middle = many.snapshot()
    many.run(0.5)
    for again in (am.Simulation(scenario, replicas=[3]), am.Simulation(scenario, replicas=[3, 0], threads=2)):
        again.run(1.5)
        assert again.digest(3) == many.digest(3)
    end = many.digest()
    many.restore(middle)
    many.run(0.5)
    assert many.digest() == end
    heard = [r for i in range(6) for r in (many.robot(f"r{i}", 0).readings["sonar"],)]
    assert any((r.measured < r.true - 0.1).any() for r in heard)  # there was something to hear
