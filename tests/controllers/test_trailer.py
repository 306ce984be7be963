"""Pushing a trailer: its axle drives as it is asked to, and along the path of a plan, to its end."""

import math

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.controllers.trailer import Trailer
from amorsim.kernels.kinematics.trailer import hitch_after
from tests.controllers.test_dwa import said
from tests.planners.test_hybrid_a_star import OUTLINE, TRACTOR, TRAILER

RIG = TRAILER | OUTLINE
DT = 0.1
WALLS = [(0, 0, 14, 0), (14, 0, 14, 9), (14, 9, 0, 9), (0, 9, 0, 0), (8.0, 0, 8.0, 2.6), (9.6, 0, 9.6, 2.6)]


def pushed(hitch: float, bend: float, way: float, speed: float = -0.5, offset: float = 0.3, turn_rate: float = 9.0):
    """Hitch angles [rad] and poses (N, 3) of the axle, every millimetre of so much way, exactly as the drive goes."""
    pose, step = np.zeros((1, 3)), 0.001
    hitches, axles = [], []
    for _ in range(round(way / step)):
        trailer = Trailer(0.9, offset, hitch, 1.2)
        hitches.append(hitch)
        axles.append(trailer.axle(pose)[0])
        v, w = trailer.twist(speed, bend, turn_rate)
        ahead, turn = math.copysign(step, v), step * w / abs(v)
        hitch = hitch_after(hitch, ahead, turn, 0.9, offset, 1.2)
        middle = pose[0, 2] + 0.5 * turn
        pose += [[ahead * math.cos(middle), ahead * math.sin(middle), turn]]
    return np.array(hitches), np.array(axles)


@pytest.mark.parametrize("offset", [-0.2, 0.0, 0.3])
@pytest.mark.parametrize("bend", [-0.6, 0.0, 0.4])
def test_the_axle_drives_along_the_bend_that_is_asked_for(bend, offset):
    """From any hitch angle: what is off falls to a third in half of the trailer's length."""
    hitches, axles = pushed(0.5, bend, 3.0, offset=offset)
    way = np.hypot(*np.diff(axles[-201:, :2], axis=0).T).sum()
    turned = axles[-1, 2] - axles[-201, 2]
    assert turned / -way == pytest.approx(bend, abs=0.01)  # it drives backwards
    errors = np.abs(hitches - hitches[-1])
    assert errors[450] / errors[0] == pytest.approx(math.exp(-1.0), abs=0.02)


def test_it_slows_down_rather_than_turn_too_fast():
    fast, slow = (Trailer(0.9, 0.3, 0.5, 1.2).twist(-0.5, 0.0, limit) for limit in (9.0, 0.1))
    assert abs(slow[1]) == pytest.approx(0.1)
    assert slow[1] / slow[0] == pytest.approx(fast[1] / fast[0])
    assert fast[0] == -0.5


@attrs.frozen(kw_only=True)
class Laid(am.Planner):
    """A planner that has made its plan."""

    plans_headings = True
    made: tuple[am.Plan, ...] = ()

    def plan(self, world, start, goal, *, footprint=None):
        return self.made[0]


def planner(**changes) -> am.planners.HybridAStar:
    given = {"radius": 1.5, "clearance": 0.1, "backward": 1.2} | RIG | {"hitch_max": 0.7}
    return am.planners.HybridAStar(**(given | changes))


def tractor(start, controller, **changes) -> am.Robot:
    """A tractor whose motors lag and whose encoders count in steps."""
    drive = am.drives.Tractor(
        wheel_radius_left=0.2, wheel_radius_right=0.2, track=0.5, rate_max=6.0, lag=0.2, acceleration_max=8.0, **RIG
    )
    return am.Robot(
        name="tractor",
        shape=TRACTOR,
        drive=drive,
        sensors={
            "encoder": am.sensors.Encoder(counts_per_revolution=4096.0),
            "laser": am.MountedSensor(sensor=am.sensors.Laser(beams=31, range_max=8.0), mount=am.Mount(x=0.5)),
        },
        estimators={"odometry": am.estimators.DeadReckoning()},
        controller=controller,
        pose=am.Pose(x=start[0], y=start[1], heading=start[2]),
        **changes,
    )


def driven(world: am.Map, start, plan: am.Plan, **changes) -> am.Simulation:
    """A tractor that is to drive the plan to its end."""
    *place, heading = plan.poses[-1].tolist()
    controller = am.controllers.Navigate(
        goals=(tuple(place),),
        headings=(heading,),
        planner=Laid(made=(plan,)),
        avoider=am.controllers.PathPursuit(speed=0.6, lookahead=0.5),
        tolerance=0.06,
        recovery=(),
    )
    robot = tractor(start, controller, knowledge=am.Knowledge(map=world), **changes)
    return am.Simulation(am.Scenario(map=world, robots=[robot], dt=DT, seed=1))


def off_plan(simulation: am.Simulation, plan: am.Plan, seconds: float) -> float:
    """How far the trailer's axle comes off its planned path [m] until the tractor reports something."""
    most = 0.0
    for _ in range(round(seconds / DT)):
        simulation.step()
        off = np.hypot(*(plan.trailer[:, :2] - simulation.part_pose[0, :2]).T).min()
        most = max(most, float(off))
        if said(simulation):
            break
    simulation.run(1.0)
    return most


def check_end(simulation: am.Simulation, plan: am.Plan, near: float, turned: float) -> None:
    assert [event for event in simulation.events if "collision" in event.kind] == []
    assert said(simulation) == [("tractor", "goal_reached", "1 of 1")]
    off = simulation.part_pose[0] - plan.trailer[-1]
    assert math.hypot(off[0], off[1]) < near
    assert abs(math.remainder(off[2], 2.0 * math.pi)) < math.radians(turned)


def test_a_trailer_is_pushed_aside_as_planned():
    """3.5 m back and 0.4 m aside. Bounds are about twice what was measured."""
    world = am.Map.from_segments(WALLS[:4], resolution=0.02)
    start = (9.0, 5.0, 0.0)
    plan = planner(backward=1.0).plan(world, start, (5.5, 5.4, 0.0), footprint=TRACTOR)
    simulation = driven(world, start, plan)
    assert off_plan(simulation, plan, 30.0) < 0.06
    check_end(simulation, plan, 0.05, 2.0)
    assert simulation.true_pose[0, 0] < start[0] - 3.0


def test_a_trailer_that_is_off_its_path_at_first_is_led_back():
    world = am.Map.from_segments(WALLS[:4], resolution=0.02)
    plan = planner(backward=1.0).plan(world, (9.0, 5.0, 0.0), (5.5, 5.4, 0.0), footprint=TRACTOR)
    simulation = driven(world, (9.0, 5.2, -0.1), plan)
    assert off_plan(simulation, plan, 30.0) > 0.15
    check_end(simulation, plan, 0.05, 2.0)


@pytest.mark.long
@pytest.mark.parametrize("start", [(11.0, 5.5, math.pi), (5.0, 5.0, 0.0)], ids=["left", "right"])
def test_a_trailer_is_backed_into_a_bay(start):
    """A bay 0.5 m wider than the trailer on either side, between walls."""
    world = am.Map.from_segments(WALLS, resolution=0.02)
    plan = planner().plan(world, start, (8.8, 2.7, 0.5 * math.pi), footprint=TRACTOR)
    assert plan.status == "found"
    simulation = driven(world, start, plan)
    assert off_plan(simulation, plan, 60.0) < 0.08
    check_end(simulation, plan, 0.05, 3.0)
