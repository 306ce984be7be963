"""Cross-talk: the sound of other transducers that reaches a ring of transducers."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.contracts import Emissions, View
from amorsim.kernels.sensing import acoustics, earshot

__all__ = ["SOUND", "bind_hearing"]


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


def bind_hearing(
    view: View,
    emissions: Callable[[], Emissions],
    receivers: Array,
    half_angle: Array,
    listens: Array,
    range_min: Array,
    range_max: Array,
) -> Callable[[], Array]:
    """A function of the ranges `(N, k)` [m] that sounds of other transducers, of this ring or others, would give.

    Inf for silence. Sound takes the shortest path. It goes straight from one transducer to another if each lies in the
    other's cone. Or it reflects off a surface that both see within their cones, except surfaces of the emitting robot;
    on a flat wall that is the mirror path. A transducer takes the sound for its own echo: it reads half the distance
    that sound travels in the time since it fired itself. Nothing is heard below `range_min`, while the transducer still
    rings, nor beyond `range_max`.

    Parameters
    ----------
    emissions
        Returns all emissions into the medium, from the listening sensor's view.
    receivers
        World poses `(N * k, 3)` of the elements; they keep their place.
    half_angle, range_min, range_max
        `(N, 1)` [rad], [m], [m].
    listens
        Time `(N, k)` [s] after the tick at which each element fires and begins to listen.
    """
    cones = np.concatenate((half_angle, range_min, range_max), axis=1)
    listeners = acoustics.Listeners(receivers, np.ascontiguousarray(listens), cones)
    bearings = half_angle[:1] * _FAN if (half_angle == half_angle[0]).all() else half_angle * _FAN
    if len(bearings) > 1:
        bearings = np.repeat(bearings, listens.shape[1], axis=0)
    cast = np.empty((len(receivers), len(_FAN)))
    surfaces = acoustics.Surfaces(bearings, cast, np.empty(cast.shape, dtype=np.int64), view.bodies().owner.copy())
    nearest, limits = np.empty(cast.shape), np.empty(len(receivers))
    look_alone = view.bind_look(receivers, bearings, limits, surfaces.ranges, surfaces.thing, nearest)
    look_in_company = view.bind_look(receivers, bearings, limits, surfaces.ranges, surfaces.thing)
    rooms: dict[int, acoustics.Facing] = {}

    def hear() -> Array:
        arrays: Any = map(np.ascontiguousarray, emissions())
        emitters = acoustics.Emitters(*arrays)
        count = emitters.time.shape[1]
        if count not in rooms:
            rooms[count] = _room(listens.shape, count, nearest, limits)
        facing = rooms[count]
        heard = np.full(listens.shape, np.inf)
        earshot.face(listeners, emitters, _FAN, SOUND, facing)
        if facing.is_done.all():
            return heard
        if count == listens.shape[1]:
            look_alone()
        else:  # where others fire, too, most rays matter
            look_in_company()
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

    return hear


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


def _are_free(view: View, lines: acoustics.Lines) -> Bools:
    """Which lines `(P,)` no wall and no body blocks, other than the emitter's carrier.

    Bodies are compared by number, not by place: an emitter at the rim of its carrier is as far away as the rim, up to
    rounding.
    """
    length = np.hypot(lines.ahead[:, :1], lines.ahead[:, 1:])
    limit = length * _BEYOND + _OFF
    is_free = view.cast(lines.poses, _AHEAD, limit, bodies=False, row=lines.row) >= length
    if not view.has_company:
        return is_free[:, 0]
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


def _room(shape: tuple[int, ...], emitters: int, nearest: Array, limits: Array) -> acoustics.Facing:
    rows, count = shape[0], shape[0] * shape[1]
    return acoustics.Facing(
        axes=np.empty((count, 3)),
        emitter_axes=np.empty((rows, emitters, 4)),
        hears=np.empty((count, emitters), dtype=np.bool_),
        nearest=nearest,
        limit=limits,
        is_done=np.empty(count, dtype=np.bool_),
    )


def _lines(count: int) -> acoustics.Lines:
    return acoustics.Lines(
        row=np.empty(count, dtype=np.int64),
        poses=np.empty((count, 3)),
        ahead=np.empty((count, 2)),
        carrier=np.empty(count, dtype=np.int64),
    )
