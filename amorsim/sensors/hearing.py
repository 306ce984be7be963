"""What a ring of transducers hears of others that fire at the same time."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.contracts import View
from amorsim.kernels.sensing import acoustics as sounds

__all__ = ["SOUND", "hear"]

Array = npt.NDArray[np.float64]

SOUND = 343.0
"""Speed of sound [m/s] in dry air of 20 °C."""

# Rays in which surfaces are looked for, by parts of a cone's half angle; as many for all cones, so that a row's bits do
# not hang on its company. In a cone of 30 degrees they are half a degree apart.
_FAN = np.linspace(-1.0, 1.0, 61)

_BATCH = 8  # sounds whose ways are looked at together

_OFF = (
    0.01  # [m] before a surface from where the way on is looked at: a start within a cell that is occupied sees nothing
)


def hear(
    view: View,
    medium: str,
    receivers: Array,
    half_angle: Array,
    listens: Array,
    range_min: Array,
    range_max: Array,
) -> Array:
    """What the sound of others, and of other elements of the ring itself, would read `(N, k)` [m]; inf for silence.

    Sound goes straight from one transducer to another where each is in the other's cone, or by way of any surface that
    is seen from both within both cones, other than those of the robot that emits it; of all ways the shortest, which
    on a flat wall is the mirror's. A transducer
    takes what comes for its own echo: it reads half the way that sound would have gone since it fired itself. Nothing
    is heard below `range_min`, while it still rings, nor beyond `range_max`.

    Parameters
    ----------
    receivers
        World poses `(N * k, 3)` of the elements.
    half_angle, range_min, range_max
        `(N, 1)` [rad], [m], [m].
    listens
        When each element fires itself, and so begins to listen `(N, k)` [s], from the tick on.
    """
    rows, k = listens.shape
    said = view.emissions(medium)
    itself = _itself(said.own, k)
    reach = said.time.min(axis=1, keepdims=True)  # of the emitter that fires first, sound has come farthest
    limit = 2.0 * range_max + SOUND * np.maximum(listens.max(axis=1, keepdims=True) - reach, 0.0)
    half = np.repeat(np.broadcast_to(half_angle, (rows, 1)), k)
    fan = half[:, None] * _FAN
    ranges, met = view.look(receivers, fan, limit, landmarks=False)
    owner = view.bodies().owner
    surface = _owners(met, owner)
    points = np.empty((len(receivers), len(_FAN), 2))
    sounds.surface_points(receivers, half, _FAN, ranges, points)
    least = np.repeat(np.broadcast_to(range_min, (rows, 1)), k)
    most = np.repeat(np.broadcast_to(range_max, (rows, 1)), k)
    count = rows * k
    found = np.full(count, np.inf)
    after, after_which = np.full(count, -np.inf), np.full(count, -1, dtype=np.int64)
    heard, which = np.empty((count, _BATCH)), np.empty((count, _BATCH), dtype=np.int64)
    path = np.empty((count, _BATCH, 4))
    hearers = _axes(receivers, half), np.ascontiguousarray(listens).reshape(-1), itself, points, ranges, surface
    emitters = np.ascontiguousarray(said.poses)
    cones = _axes(emitters.reshape(-1, 3), said.half_angle.reshape(-1)).reshape(emitters.shape)
    carriers = np.ascontiguousarray(said.body)
    fires, fired = np.ascontiguousarray(said.time), np.ascontiguousarray(said.fired)
    row = np.repeat(np.arange(count) // k, _BATCH)
    # Sounds in the order in which they come, until for each hearer one is found that nothing keeps off.
    while True:
        sounds.first_sounds(
            receivers,
            *hearers,
            emitters,
            cones,
            carriers,
            fires,
            fired,
            SOUND,
            least,
            most,
            after,
            after_which,
            heard,
            which,
            path,
        )
        comes = which >= 0
        if not comes.any():
            break
        emitter = np.where(comes, which, 0).reshape(-1) // (len(_FAN) + 1)
        free = comes & _is_free(view, receivers, path, limit, carriers[row, emitter], owner).reshape(comes.shape)
        has = free.any(axis=1)
        first = np.argmax(free, axis=1)
        found = np.where(has, heard[np.arange(count), first], found)
        # Those have heard what there is.
        most = np.where(has | ~comes[:, -1], -np.inf, most)
        if np.isneginf(most).all():
            break
        after, after_which = heard[:, -1].copy(), which[:, -1].copy()
    return found.reshape(rows, k)


def _axes(poses: Array, half_angle: Array) -> Array:
    """Where cones look, and how wide they are, as kernels take it `(M, 3)`."""
    out = np.empty((len(poses), 3))
    sounds.axes(poses, np.ascontiguousarray(half_angle), out)
    return out


def _itself(own: npt.NDArray[np.bool_], k: int) -> npt.NDArray[np.int64]:
    """Which emitter each of the k elements of the rows' rings is `(N * k,)`."""
    # A sensor's emitters come in the order of its elements.
    return np.ascontiguousarray(np.argsort(~own, axis=1, kind="stable")[:, :k]).reshape(-1)


def _owners(met: npt.NDArray[np.int64], owner: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Whose surface rays end on: of a part of a robot, the robot's body; -1 for a wall or none."""
    return np.where(met >= 0, owner[met], -1)


def _is_free(
    view: View,
    receivers: Array,
    path: Array,
    limit: Array,
    carrier: npt.NDArray[np.int64],
    owner: npt.NDArray[np.int64],
) -> npt.NDArray[np.bool_]:
    """Whether the straight lines `(M * b,)` of `path` `(M, b, 4)` to the emitters meet nothing but what carries these.

    Who is met is told by number, not by place: an emitter at the rim of its `carrier` `(M * b,)` is as far off as the
    rim, up to rounding.
    """
    start, end = path.reshape(-1, 4)[:, :2], path.reshape(-1, 4)[:, 2:]
    back = np.repeat(receivers[:, :2], path.shape[1], axis=0) - start
    way = np.sqrt(back[:, :1] ** 2 + back[:, 1:] ** 2)
    start = start + back * np.minimum(_OFF / np.where(way > 0.0, way, 1.0), 1.0)
    ahead = end - start
    way = np.sqrt(ahead[:, 0] ** 2 + ahead[:, 1] ** 2)
    towards = np.concatenate((start, np.arctan2(ahead[:, 1:], ahead[:, :1])), axis=1)
    reach, met = view.look(towards, np.zeros((1, 1)), limit, landmarks=False)
    return np.asarray((reach[:, 0] >= way) | (_owners(met[:, 0], owner) == carrier))
