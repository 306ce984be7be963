"""What a ring of transducers hears of others that fire at the same time."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.contracts import View
from amorsim.kernels import sounds

__all__ = ["SOUND", "hear"]

Array = npt.NDArray[np.float64]

SOUND = 343.0
"""Speed of sound [m/s] in dry air of 20 °C."""

# Rays in which surfaces are looked for, by parts of a cone's half angle; as many for all cones, so that a row's bits do
# not hang on its company. In a cone of 30 degrees they are half a degree apart.
_FAN = np.linspace(-1.0, 1.0, 61)

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
    is seen from both within both cones; of all ways the shortest, which on a flat wall is the mirror's. A transducer
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
    ranges = view.cast(receivers, fan, limit)
    points = np.empty((len(receivers), len(_FAN), 2))
    sounds.surface_points(receivers, half, _FAN, ranges, points)
    least = np.repeat(np.broadcast_to(range_min, (rows, 1)), k)
    most = np.repeat(np.broadcast_to(range_max, (rows, 1)), k)
    found = np.full(rows * k, np.inf)
    heard, which = np.full(rows * k, -np.inf), np.full(rows * k, -1, dtype=np.int64)
    path = np.empty((rows * k, 4))
    emitters, bodies = np.ascontiguousarray(said.poses), view.bodies()
    emitter_half, fires = np.ascontiguousarray(said.half_angle), np.ascontiguousarray(said.time)
    fired = np.ascontiguousarray(said.fired)
    # Sounds in the order in which they come, until one is found that nothing keeps off.
    while sounds.first_sound(
        receivers,
        half,
        np.ascontiguousarray(listens).reshape(-1),
        itself,
        points,
        ranges,
        emitters,
        emitter_half,
        fires,
        fired,
        SOUND,
        least,
        most,
        heard,
        which,
        path,
    ):
        comes = which >= 0
        carrier = np.where(comes, which, 0) // (len(_FAN) + 1)
        row = np.arange(rows * k) // k
        body = said.body[row, carrier]
        free = _is_free(view, receivers, path, comes, limit, bodies.poses[row, body], bodies.reach[body])
        found = np.where(comes & free, heard, found)
        most = np.where(comes & free | ~comes, -np.inf, most)  # those have heard what there is
    return found.reshape(rows, k)


def _itself(own: npt.NDArray[np.bool_], k: int) -> npt.NDArray[np.int64]:
    """Which emitter each of the k elements of the rows' rings is `(N * k,)`."""
    # A sensor's emitters come in the order of its elements.
    return np.ascontiguousarray(np.argsort(~own, axis=1, kind="stable")[:, :k]).reshape(-1)


def _is_free(
    view: View, receivers: Array, path: Array, comes: npt.NDArray[np.bool_], limit: Array, base: Array, reach: Array
) -> npt.NDArray[np.bool_]:
    """Whether the straight lines to the emitters `(M,)` meet nothing but what carries these.

    What ends a line within `reach` [m] `(M,)` of the carrier's base point `(M, 3)` is the carrier.
    """
    start = np.where(comes[:, None], path[:, :2], receivers[:, :2])
    end = np.where(comes[:, None], path[:, 2:], receivers[:, :2])
    back = receivers[:, :2] - start
    way = np.sqrt(back[:, :1] ** 2 + back[:, 1:] ** 2)
    start = start + back * np.minimum(_OFF / np.where(way > 0.0, way, 1.0), 1.0)
    ahead = end - start
    way = np.sqrt(ahead[:, :1] ** 2 + ahead[:, 1:] ** 2)
    ahead = ahead / np.where(way > 0.0, way, 1.0)
    towards = np.concatenate((start, np.arctan2(ahead[:, 1:], ahead[:, :1])), axis=1)
    met = np.minimum(view.cast(towards, np.zeros((1, 1)), limit), way)
    apart = start + met * ahead - base[:, :2]
    is_carrier = apart[:, 0] ** 2 + apart[:, 1] ** 2 <= reach**2
    return np.asarray((met[:, 0] >= way[:, 0]) | is_carrier)
