"""How metrics are tried."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from amorsim.contracts import Episode, Metric, Part
from amorsim.core.maps.map import Map
from amorsim.core.poses import compose
from amorsim.core.shapes import Shape
from amorsim.simulation.events import Event
from amorsim.simulation.kept_quantities import LAST, quantity_problem
from amorsim.testing.failure import Who, array_in_words

__all__ = ["check_metric"]

_STEPS, _ROWS, _DT = 41, 7, 0.1
_BETTER = ("lower", "higher", "neither")


def check_metric(who: Who, metric: Metric) -> None:
    """Try a metric on an episode of a few replicas: one value each, the same bits again and for each replica alone."""
    require = who.require
    require(metric.better in _BETTER, "better", "better", f"one of {', '.join(_BETTER)}", repr(metric.better))
    with who.calling("needs"):
        needs = metric.needs()
    are_texts = isinstance(needs, (tuple, list)) and all(isinstance(name, str) for name in needs)
    require(are_texts, "needs", "needs()", "names of quantities", repr(needs))
    for name in needs:
        problem = quantity_problem(name)
        require(not problem, "needs", "needs()", "names of quantities", problem)
    for episode in (_episode(needs), _in_worlds_of_their_own(_episode(needs))):
        _check_episode(who, metric, episode)


def _check_episode(who: Who, metric: Metric, episode: Episode) -> None:
    require = who.require
    before = {name: array.tobytes() for name, array in episode.kept.items()}
    values = _measured(who, metric, episode)
    for name, array in episode.kept.items():
        require(array.tobytes() == before[name], "inputs", f"kept[{name!r}]", "the same bits after measure()", "others")
    again = _measured(who, metric, episode)
    require(values.tobytes() == again.tobytes(), "determinism", "a second measure()", "the same bits", "others")
    for row, replica in enumerate(episode.replicas):
        alone = attrs.evolve(
            episode,
            replicas=(replica,),
            kept={name: np.ascontiguousarray(array[:, row : row + 1]) for name, array in episode.kept.items()},
            events=[event for event in episode.events if event.replica == replica],
            map=episode.map_of(row),
            maps=episode.maps[row : row + 1],
        )
        value = _measured(who, metric, alone)
        same = value.tobytes() == values[row : row + 1].tobytes()
        require(same, "rows", f"replica {replica} alone", f"the same bits, {values[row]!r}", repr(value[0]))


def _measured(who: Who, metric: Metric, episode: Episode) -> Any:
    with who.calling("measure"):
        values = metric.measure(episode)
    count = len(episode.replicas)
    fits = isinstance(values, np.ndarray) and values.dtype == np.float64 and values.shape == (count,)
    who.require(fits, "shapes", "measure()", f"float64 ({count},)", array_in_words(values))
    return values


def _in_worlds_of_their_own(episode: Episode) -> Episode:
    """The same where each replica has a world of its own: halls, each with another wall."""
    maps = [_hall(1.0 + 0.5 * row) for row in range(_ROWS)]
    return attrs.evolve(episode, map=maps[0], maps=maps)


def _hall(x: float = 0.0) -> Map:
    """A hall of 6 m by 4 m, with a wall from its lower side that begins at `x` [m]; none at 0."""
    sides = [(0.0, 0.0, 6.0, 0.0), (6.0, 0.0, 6.0, 4.0), (6.0, 4.0, 0.0, 4.0), (0.0, 4.0, 0.0, 0.0)]
    return Map.from_segments(np.array([*sides, *([(x, 0.0, x, 1.0)] if x else [])]), resolution=0.05)


def _episode(needs: Any) -> Episode:
    """Robots that go round in circles in a hall, the even ones until they hit something."""
    random = np.random.default_rng(5)
    time = _DT * np.arange(_STEPS, dtype=np.float64)
    turn = 0.3 + 0.1 * np.arange(_ROWS)
    angle = time[:, None] * turn
    true = np.stack((3.0 + np.sin(angle), 2.0 + 0.5 * np.cos(angle), -angle), axis=2)
    believed = true + 0.01 * random.standard_normal(true.shape).cumsum(axis=0)
    covariance = np.broadcast_to(np.diag([0.01, 0.01, 0.004]), (_STEPS, _ROWS, 3, 3)).copy()
    covariance *= 1.0 + time[:, None, None, None]
    kept: dict[str, Any] = {}
    for name in needs:
        last = name.rpartition(".")[2]
        if last == "occupancy":
            kept[name] = random.uniform(0.0, 1.0, (_STEPS, _ROWS, 40, 60))
        elif last == "occupancy_resolution":
            kept[name] = np.full((_STEPS, _ROWS), 0.1)
        elif last == "occupancy_origin":
            kept[name] = np.zeros((_STEPS, _ROWS, 2))
        elif name == "true_pose":
            kept[name] = true.copy()
        elif name == "part_pose":
            kept[name] = compose(true.reshape(-1, 3), np.tile([-0.5, 0.0, 0.0], (true[..., 0].size, 1)))
            kept[name] = kept[name].reshape(_STEPS, _ROWS, 1, 3)
        elif last == "covariance":
            kept[name] = covariance.copy()
        elif last in ("estimated_pose", "pose"):
            kept[name] = believed.copy()
        elif last in ("active", "by_hand", "touching", "fresh"):
            kept[name] = random.uniform(size=(_STEPS, _ROWS)) < 0.5
        else:
            kept[name] = random.uniform(0.1, 3.0, (_STEPS, _ROWS, 3))
        if name.startswith(LAST):
            kept[name] = kept[name][-1:]
    events = []
    for replica in range(0, _ROWS, 2):
        at: dict[str, Any] = {"tick": 20 + replica, "time": (20.5 + replica) * _DT, "replica": replica, "name": "rover"}
        events.append(Event(kind="collision", other="wall", point=(3.0, 2.0), speed=0.2, **at))
        events.append(Event(kind="controller_ended", **at))
    return Episode(
        robot="rover",
        replicas=tuple(range(_ROWS)),
        time=time,
        kept=kept,
        events=events,
        map=_hall(),
        shape=Shape.circle(0.2),
        parts=(Part("trailer", Shape.circle(0.1)),),
    )
