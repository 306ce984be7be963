"""What a ring of transducers hears of others that fire at the same time."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Emissions, View
from amorsim.kernels.sensing import acoustics, earshot

__all__ = ["SOUND", "hear"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

SOUND = 343.0
"""Speed of sound [m/s] in dry air of 20 °C."""

# Rays in which surfaces are looked for, by parts of a cone's half angle; as many for all cones, so that a row's bits do
# not depend on other rows. In a cone of 30 degrees they are half a degree apart.
_FAN = np.linspace(-1.0, 1.0, 61)

# Sounds of each listener whose lines are looked along together: at first one, which mostly is free.
_BATCHES = (1, 8, 64)

_TOGETHER = 12  # rays of a listener that are cast as one look
_OFF = 0.01  # [m] before a surface from where the way on is looked at: within an occupied cell nothing is seen
_AHEAD = np.zeros((1, 1))


def hear(
    view: View,
    said: Emissions,
    receivers: Array,
    half_angle: Array,
    listens: Array,
    range_min: Array,
    range_max: Array,
) -> Array:
    """What the sound of others, and of other elements of the ring itself, would read `(N, k)` [m]; inf for silence.

    Sound goes straight from one transducer to another where each is in the other's cone, or by way of any surface that
    is seen from both within both cones, other than those of the robot that emits it; of all ways the shortest, which
    on a flat wall is the mirror's. A transducer takes what comes for its own echo: it reads half the way that sound
    would have gone since it fired itself. Nothing is heard below `range_min`, while it still rings, nor beyond
    `range_max`.

    Parameters
    ----------
    said
        What everyone fires into the medium, as the view tells the sensor that listens.
    receivers
        World poses `(N * k, 3)` of the elements.
    half_angle, range_min, range_max
        `(N, 1)` [rad], [m], [m].
    listens
        When each element fires itself, and so begins to listen `(N, k)` [s], from the tick on.
    """
    heard = np.full(listens.shape, np.inf)
    cones = np.concatenate((half_angle, range_min, range_max), axis=1)
    listeners = acoustics.Listeners(receivers, np.ascontiguousarray(listens), cones)
    arrays: Any = map(np.ascontiguousarray, said)
    emitters = acoustics.Emitters(*arrays)
    rows, k = listens.shape
    facing = _room(rows, k, emitters.time.shape[1])
    looks = earshot.face(listeners, emitters, _FAN, SOUND, _TOGETHER, facing)
    if facing.is_done.all():
        return heard
    surfaces = _surfaces(view, listeners, facing, len(listens) * looks)
    after, after_number = np.full(len(receivers), -np.inf), np.full(len(receivers), -1, dtype=np.int64)
    # Sounds in the order in which they come, until for each listener one is found that nothing keeps off.
    for batch in itertools.chain(_BATCHES, itertools.repeat(_BATCHES[-1])):
        sounds = _silence(len(receivers), batch)
        found = acoustics.first_sounds(listeners, emitters, facing, surfaces, SOUND, after, after_number, sounds)
        if not found:
            break
        lines = _lines(len(listens) * found)
        acoustics.lay_lines(listeners, emitters, facing, sounds, _OFF, lines)
        lines.poses[:, 2] = np.arctan2(lines.ahead[:, 1], lines.ahead[:, 0])
        reach, met = view.look(lines.poses, _AHEAD, facing.limit, landmarks=False)
        met = _owners(view, met)
        if not acoustics.take_free(sounds, lines, reach, met, facing.is_done, heard, after, after_number):
            break
    return heard


def _surfaces(view: View, listeners: acoustics.Listeners, facing: acoustics.Facing, looks: int) -> acoustics.Surfaces:
    """Where those rays end that may carry a sound, in so many looks."""
    shape = (looks, _TOGETHER)
    surfaces = acoustics.Surfaces(
        np.empty((looks, 3)), np.empty(shape), np.empty(shape), np.empty(shape, dtype=np.int64)
    )
    if not looks:
        return surfaces
    earshot.lay_rays(listeners, facing, _FAN, surfaces)
    ranges, met = view.look(surfaces.poses, surfaces.bearings, facing.limit, landmarks=False)
    return surfaces._replace(ranges=ranges, owner=_owners(view, met))


def _owners(view: View, met: Ints) -> Ints:
    """Whose surface rays end on: of a part of a robot, the robot's body; -1 for a wall or none."""
    if (met < 0).all():
        return met
    return np.where(met >= 0, view.bodies().owner[met], -1)


def _room(rows: int, k: int, emitters: int) -> acoustics.Facing:
    return acoustics.Facing(
        axes=np.empty((rows * k, 3)),
        emitter_axes=np.empty((rows, emitters, 4)),
        hears=np.empty((rows * k, emitters), dtype=np.bool_),
        limit=np.empty((rows, 1)),
        rays=np.empty((rows * k, len(_FAN)), dtype=np.int64),
        is_done=np.empty(rows * k, dtype=np.bool_),
    )


def _silence(listeners: int, batch: int) -> acoustics.Sounds:
    shape = (listeners, batch)
    return acoustics.Sounds(np.empty(shape), np.empty(shape, dtype=np.int64), np.empty((*shape, 2)))


def _lines(count: int) -> acoustics.Lines:
    return acoustics.Lines(np.empty((count, 3)), np.empty((count, 2)), np.empty(count, dtype=np.int64))
