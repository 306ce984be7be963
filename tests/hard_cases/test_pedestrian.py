"""A pedestrian who walks up and down between two places, and steps aside for whatever comes."""

from __future__ import annotations

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Context, Draws, Motion, State, View, parameter
from amorsim.core.shapes import Shape
from amorsim.drives.differential import Differential
from amorsim.scenario.spec import Obstacle, Pose, Robot, Scenario
from amorsim.simulation.simulation import Simulation
from tests.hard_cases.common import SLIP, Hold, advance, bodies, check_bits, room

Array = npt.NDArray[np.float64]

_GLANCES = 48
_BEARINGS = (np.arange(_GLANCES) * (2.0 * np.pi / _GLANCES) - np.pi).reshape(1, -1)


@attrs.frozen(kw_only=True)
class Pedestrian(Motion):
    """Wants to go to a place and back, and is pushed away by what is near, walls and bodies alike.

    He looks about with rays, for a view tells of other bodies by them only; so he cannot tell who comes towards him
    from who goes away, but where something is he knows.
    """

    along: float = parameter(6.0, unit="m", help="where he turns back, as far along x as this from his start")
    speed: float = parameter(1.2, unit="m/s", gt=0, help="at which he walks where there is room")
    room: float = parameter(1.2, unit="m", gt=0, help="what he keeps free about him if he can")
    waver: float = parameter(0.05, unit="m/s", ge=0, help="standard deviation of his velocity")

    def start(self, context: Context) -> State:
        return {"home": context.pose[:, :2].copy(), "back": np.zeros((context.rows, 1), dtype=bool)}

    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        place = view.body_pose[:, :2]
        gone = place[:, :1] - state["home"][:, :1]
        state["back"] = np.where(state["back"], gone > 0.2, gone >= self.along)
        target = state["home"] + np.where(state["back"], 0.0, np.concatenate((self.along, 0.0 * self.along), axis=1))
        way = target - place
        distance = np.maximum(np.sqrt(way[:, :1] ** 2 + way[:, 1:] ** 2), 1e-9)
        wanted = self.speed * way / distance
        level = np.concatenate((place, np.zeros((view.rows, 1))), axis=1)  # glances count from the world's x axis
        near = view.cast(level, _BEARINGS, 2.0 * self.room)
        urge = np.maximum(1.0 - near / (2.0 * self.room), 0.0) ** 2 * 1.5
        push_x, push_y = np.zeros((view.rows, 1)), np.zeros((view.rows, 1))
        for i, bearing in enumerate(_BEARINGS[0]):
            push_x -= urge[:, i : i + 1] * np.cos(bearing)
            push_y -= urge[:, i : i + 1] * np.sin(bearing)
        # He passes on the right: what pushes him back pushes him to his right as well.
        velocity = wanted + np.concatenate((push_x - 0.9 * push_y, push_y + 0.9 * push_x), axis=1)
        velocity += draws.normal(2) * self.waver
        size = np.maximum(np.sqrt(velocity[:, :1] ** 2 + velocity[:, 1:] ** 2), 1e-9)
        velocity = velocity * np.minimum(1.0, self.speed / size)
        c, s = np.cos(view.body_pose[:, 2:]), np.sin(view.body_pose[:, 2:])
        x, y = velocity[:, :1] * dt, velocity[:, 1:] * dt
        return np.concatenate((c * x + s * y, c * y - s * x, np.zeros_like(x)), axis=1)


def walker(name: str, y: float, motion: Pedestrian) -> Obstacle:
    return Obstacle(name=name, shape=Shape.circle(0.25), pose=Pose(x=2.0, y=y, heading=0.4), motion=motion)


def cart(x: float, y: float, speed: float, **others: object) -> Robot:
    """A robot that drives straight on towards -x, and looks at nothing."""
    return Robot(
        name="cart",
        shape=Shape.circle(0.3),
        drive=Differential(wheel_radius_left=0.1, wheel_radius_right=0.1, track=0.3, rate_max=30.0),
        controller=Hold(channels=(speed / 0.1, speed / 0.1)),
        pose=Pose(x=x, y=y, heading=np.pi),
        **others,
    )


def paths(motion: Pedestrian, steps: int) -> tuple[Simulation, Array]:
    """True places `(steps, 2 bodies, 2)` of the cart and of a walker who meets it head on."""
    sim = Simulation(Scenario(map=room(), robots=[cart(10.0, 6.0, 0.6)], obstacles=[walker("ann", 6.0, motion)]))
    places = []
    for _ in range(steps):
        sim.step()
        places.append(bodies(sim)[:, :2])
    return sim, np.array(places)


def test_without_his_care_the_two_would_meet() -> None:
    careless = Pedestrian(waver=0.0, room=1e-3)
    sim, _ = paths(careless, 60)
    assert any(event.name == "cart" and event.other == "ann" for event in sim.events)


def test_steps_aside_passes_and_comes_to_his_place() -> None:
    sim, places = paths(Pedestrian(waver=0.0), 110)
    assert not sim.events
    gap = np.hypot(*(places[:, 0] - places[:, 1]).T) - 0.55
    assert gap.min() > 0.1
    ann = places[:, 1]
    assert ann[:, 0].max() > 7.9  # he came to his place, past the cart ...
    passing = np.argmin(gap)
    assert abs(ann[passing, 1] - 6.0) > 0.4  # ... beside it, on his right
    assert ann[passing, 1] < 6.0
    speeds = np.hypot(*np.diff(ann, axis=0).T) / sim.dt
    assert speeds.max() <= 1.2 + 1e-9


def test_two_walkers_keep_each_to_his_speed() -> None:
    walkers = [
        walker("ann", 3.0, Pedestrian(speed=1.5, waver=0.0)),
        walker("bob", 9.0, Pedestrian(speed=0.5, along=2.0, waver=0.0)),
    ]
    sim = Simulation(Scenario(map=room(), robots=[cart(10.0, 6.0, 0.0)], obstacles=walkers))
    before = bodies(sim)
    advance(sim, 1)
    after = bodies(sim)
    moved = np.hypot(*(after - before)[1:, :2].T)
    assert 1.0 * sim.dt < moved[0] <= 1.5 * sim.dt + 1e-12
    assert 0.3 * sim.dt < moved[1] <= 0.5 * sim.dt + 1e-12
    advance(sim, 60)
    assert bodies(sim)[2, 0] < 4.6


def test_bits() -> None:
    walkers = [walker("ann", 6.0, Pedestrian()), walker("bob", 4.0, Pedestrian(speed=0.7, room=0.8))]
    check_bits(Scenario(map=room(), robots=[cart(7.0, 6.0, 0.6, ground=SLIP)], obstacles=walkers), steps=30)
