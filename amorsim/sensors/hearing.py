"""Cross-talk: the sound of other transducers that reaches a ring of transducers."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Emissions, View
from amorsim.kernels import elementary
from amorsim.kernels.sensing import acoustics, earshot

__all__ = ["SOUND", "hear"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

SOUND = 343.0
"""Speed of sound [m/s] in dry air of 20 °C."""

# Rays that look for surfaces, as fractions of a cone's half angle. Their number is the same for all cones, so a row's
# bits do not depend on other rows. In a cone of 30 degrees they are half a degree apart.
_FAN = np.linspace(-1.0, 1.0, 61)

# Number of sounds of each listener whose lines of sight are tested together: first one, which is mostly free.
_BATCHES = (1, 8, 64)

_OFF = 0.01  # [m] before a surface from where the way on is looked at: within an occupied cell nothing is seen
_BEYOND = 1.001  # times its length, a line is looked along: what blocks it is not farther
_AHEAD = np.zeros((1, 1))


def hear(
    view: View,
    emissions: Emissions,
    receivers: Array,
    half_angle: Array,
    listens: Array,
    range_min: Array,
    range_max: Array,
) -> Array:
    """The ranges `(N, k)` [m] that sounds of other transducers, of this ring or others, would give; inf for silence.

    Sound takes the shortest path. It goes straight from one transducer to another if each lies in the other's cone. Or
    it reflects off a surface that both see within their cones, except surfaces of the emitting robot; on a flat wall
    that is the mirror path. A transducer takes the sound for its own echo: it reads half the distance that sound
    travels in the time since it fired itself. Nothing is heard below `range_min`, while the transducer still rings, nor
    beyond `range_max`.

    Parameters
    ----------
    emissions
        All emissions into the medium, from the listening sensor's view.
    receivers
        World poses `(N * k, 3)` of the elements.
    half_angle, range_min, range_max
        `(N, 1)` [rad], [m], [m].
    listens
        Time `(N, k)` [s] after the tick at which each element fires and begins to listen.
    """
    heard = np.full(listens.shape, np.inf)
    cones = np.concatenate((half_angle, range_min, range_max), axis=1)
    listeners = acoustics.Listeners(receivers, np.ascontiguousarray(listens), cones)
    arrays: Any = map(np.ascontiguousarray, emissions)
    emitters = acoustics.Emitters(*arrays)
    rows, k = listens.shape
    facing = _room(rows, k, emitters.time.shape[1])
    look = np.empty(len(receivers), dtype=np.int64)
    earshot.face(listeners, emitters, _FAN, SOUND, facing, look)
    if facing.is_done.all():
        return heard
    surfaces = _surfaces(view, listeners, facing, look)
    sounds = _sounds(listeners, emitters, facing, surfaces)
    begin = sounds.first[:-1].copy()
    # Try sounds in order of arrival until each listener has one that nothing blocks.
    for batch in itertools.chain(_BATCHES, itertools.repeat(_BATCHES[-1])):
        wanted = acoustics.lines_wanted(sounds, begin, batch, facing.is_done)
        if not wanted:
            break
        lines = _lines(wanted)
        acoustics.lay_lines(listeners, emitters, facing, surfaces, sounds, begin, batch, _OFF, lines)
        acoustics.take_free(sounds, begin, batch, _are_free(view, lines), facing.is_done, heard)
    return heard


def _surfaces(view: View, listeners: acoustics.Listeners, facing: acoustics.Facing, look: Ints) -> acoustics.Surfaces:
    """Where the rays of cones end that may carry a sound: of listeners with a `look` `(M,)`."""
    which = np.flatnonzero(look >= 0)
    row = which // listeners.listens.shape[1]
    half = listeners.cones[:, :1]
    bearings = half[:1] * _FAN if (half == half[0]).all() else half[row] * _FAN
    ranges, met = view.look(listeners.poses[which], bearings, facing.limit[which, 1:], landmarks=False, row=row)
    return acoustics.Surfaces(bearings, ranges, _owners(view, met), look)


def _sounds(
    listeners: acoustics.Listeners,
    emitters: acoustics.Emitters,
    facing: acoustics.Facing,
    surfaces: acoustics.Surfaces,
) -> acoustics.Sounds:
    """All sounds that may reach each listener, in order."""
    first = np.empty(len(listeners.poses) + 1, dtype=np.int64)
    room = 16 + 4 * int(facing.hears.sum())
    while True:
        sounds = acoustics.Sounds(first, np.empty(room), np.empty(room, dtype=np.int64))
        count = acoustics.sounds_in_order(listeners, emitters, facing, surfaces, SOUND, sounds)
        if count <= room:
            return sounds
        room = count


def _are_free(view: View, lines: acoustics.Lines) -> npt.NDArray[np.bool_]:
    """Which lines `(P,)` no wall and no body blocks, other than the emitter's carrier.

    Bodies are compared by number, not by place: an emitter at the rim of its carrier is as far away as the rim, up to
    rounding.
    """
    lines.poses[:, 2] = elementary.arctan2(lines.ahead[:, 1], lines.ahead[:, 0])
    length = np.hypot(lines.ahead[:, :1], lines.ahead[:, 1:])
    limit = length * _BEYOND + _OFF
    is_free = view.cast(lines.poses, _AHEAD, limit, bodies=False, row=lines.row) >= length
    # In a building walls block most lines; bodies are looked for along the others only.
    which = np.flatnonzero(is_free)
    reach, met = view.look(lines.poses[which], _AHEAD, limit[which], landmarks=False, row=lines.row[which])
    is_free[which] = (reach >= length[which]) | (_owners(view, met) == lines.carrier[which, None])
    return is_free[:, 0]


def _owners(view: View, met: Ints) -> Ints:
    """The body on whose surface each ray ends (the robot for a part of it); -1 for a wall or none."""
    if (met < 0).all():
        return met
    return np.where(met >= 0, view.bodies().owner[met], -1)


def _room(rows: int, k: int, emitters: int) -> acoustics.Facing:
    return acoustics.Facing(
        axes=np.empty((rows * k, 3)),
        emitter_axes=np.empty((rows, emitters, 4)),
        hears=np.empty((rows * k, emitters), dtype=np.bool_),
        limit=np.empty((rows * k, 2)),
        is_done=np.empty(rows * k, dtype=np.bool_),
    )


def _lines(count: int) -> acoustics.Lines:
    return acoustics.Lines(
        row=np.empty(count, dtype=np.int64),
        poses=np.empty((count, 3)),
        ahead=np.empty((count, 2)),
        carrier=np.empty(count, dtype=np.int64),
    )
