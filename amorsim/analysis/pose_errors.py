"""Absolute and relative pose errors (APE, RPE) of estimated trajectories in the plane."""

from __future__ import annotations

import math
from typing import Annotated

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.algorithms.trajectories import (
    Transform,
    absolute_errors,
    associate,
    first_pose_transform,
    interpolated,
    nearest,
    pairs_by_distance,
    pairs_by_steps,
    pairs_by_time,
    path_lengths,
    relative_errors,
    umeyama,
)
from amorsim.analysis.trajectory import Trajectory
from amorsim.array_types import Array, Ints
from amorsim.core.arguments import check_kind, check_text, checked, numbers, real
from amorsim.core.error_text import in_words
from amorsim.core.errors import AnalysisError
from amorsim.core.parameters import ParameterError

__all__ = ["PoseErrors", "Statistics", "ape", "relation_errors", "rpe"]


_ALIGN = ("none", "first", "umeyama", "umeyama_scale")
_A_TRAJECTORY = "a Trajectory, as am.analysis.read_tum('true.tum')"
_UNITS = ("m", "steps", "s")
_SAME_TIME = 1e-6  # [s] by which two times differ that are the same


@attrs.frozen(kw_only=True)
class Statistics:
    """Figures of a series of errors; `std` is over all of them, as evo's."""

    rmse: float
    mean: float
    median: float
    std: float
    min: float
    max: float
    count: int

    @classmethod
    def of(cls, errors: Array) -> Statistics:
        """The statistics of errors `(n,)`; nan if there are none."""
        errors = numbers(errors, "errors", ("n",))
        if not len(errors):
            return cls(**dict.fromkeys(("rmse", "mean", "median", "std", "min", "max"), math.nan), count=0)
        return cls(
            rmse=math.sqrt(float(np.mean(errors**2))),
            mean=float(np.mean(errors)),
            median=float(np.median(errors)),
            std=float(np.std(errors)),
            min=float(np.min(errors)),
            max=float(np.max(errors)),
            count=len(errors),
        )


@attrs.frozen(kw_only=True, eq=False)
class PoseErrors:
    """The errors of an estimated trajectory, pose by pose or pair by pair.

    Attributes
    ----------
    what
        Which errors these are, in words.
    time
        When, `(n,)` [s]: of the pose, or of the later one of a pair.
    travelled
        Distance [m] along the reference up to then, `(n,)`.
    position
        `(n,)` [m], >= 0.
    heading
        `(n,)` [rad], in [0, pi].
    transform
        What was done to the estimate before; the identity without alignment.
    dropped
        How many poses of the shorter trajectory have no partner in the other; with interpolation, of the estimate.
    """

    what: str
    time: Array
    travelled: Array
    position: Array
    heading: Array
    transform: Transform
    dropped: int

    def __len__(self) -> int:
        return len(self.time)

    def __str__(self) -> str:
        position, heading = self.statistics, self.heading_statistics
        return (
            f"{self.what}: position rmse {position.rmse:.6f} m, mean {position.mean:.6f}, "
            f"median {position.median:.6f}, max {position.max:.6f}; heading rmse {math.degrees(heading.rmse):.4f} "
            f"degrees; {position.count} values, {self.dropped} poses without a partner; alignment: {self._aligned()}"
        )

    def _aligned(self) -> str:
        return "none" if self.transform == Transform() else str(self.transform)

    @property
    def statistics(self) -> Statistics:
        """Figures of `position` [m]."""
        return Statistics.of(self.position)

    @property
    def heading_statistics(self) -> Statistics:
        """Figures of `heading` [rad]."""
        return Statistics.of(self.heading)

    def by_time(self, width: float) -> list[tuple[float, Statistics]]:
        """Figures of `position` in each `width` [s] of time since the first: when each begins, and its figures."""
        return self._by(self.time - self.time[:1], width)

    def by_distance(self, width: float) -> list[tuple[float, Statistics]]:
        """The same for each `width` [m] of the way travelled."""
        return self._by(self.travelled, width)

    def _by(self, values: Array, width: float) -> list[tuple[float, Statistics]]:
        if not width > 0.0:
            raise AnalysisError(f"width: expected a number > 0, got {in_words(width)}")
        bins = np.floor(values / width).astype(np.int64)
        return [(number * width, Statistics.of(self.position[bins == number])) for number in np.unique(bins).tolist()]


@checked
def ape(
    reference: Trajectory,
    estimate: Trajectory,
    *,
    align: str = "none",
    most_apart: float | None = None,
    interpolate: bool = False,
) -> PoseErrors:
    """The absolute pose error: how far each estimated pose is from the one of the reference at the same time.

    Parameters
    ----------
    align
        How the estimate is moved as a whole before: ``"none"``, because a simulated estimate begins where the robot
        does; ``"first"``, its first pose onto that of the reference; ``"umeyama"``, the best fit of all positions;
        ``"umeyama_scale"``, with a scale too.
    most_apart
        How far apart in time two poses may be that are compared [s]; without it, half the reference's median step.
    interpolate
        Compare with the reference between its poses at the estimate's times, instead of with the nearest pose.

    Raises
    ------
    AnalysisError
        If no two poses are close enough in time, or an alignment is asked for that these poses do not determine.
    """
    true, believed, time, travelled, dropped = _together(reference, estimate, most_apart, interpolate)
    transform = _alignment(true, believed, align, estimate)
    position, heading = absolute_errors(true, transform.apply(believed) if align != "none" else believed)
    return PoseErrors(
        what="absolute pose error",
        time=time,
        travelled=travelled,
        position=position,
        heading=heading,
        transform=transform,
        dropped=dropped,
    )


@checked
def rpe(
    reference: Trajectory,
    estimate: Trajectory,
    *,
    delta: float = 1.0,
    unit: str = "m",
    every: bool = True,
    align: str = "none",
    most_apart: float | None = None,
    interpolate: bool = False,
) -> PoseErrors:
    """The relative pose error: how far estimated motions over a stretch end from the true ones.

    Parameters
    ----------
    delta, unit
        The stretch: ``"m"`` of estimated path, ``"steps"`` from pose to pose, or ``"s"``, rounded to whole steps. A
        pose that has none at the end of its seconds begins no stretch.
    every
        From every pose, or else one stretch after another.
    align, most_apart, interpolate
        As for `ape`. Of these alignments only a scale changes a relative error.

    Raises
    ------
    AnalysisError
        As for `ape`, and if there is no such stretch.
    """
    size = _number(delta, "delta", "a number > 0")
    if unit not in _UNITS:
        raise AnalysisError(f"unit: expected one of {', '.join(_UNITS)}, got {unit!r}")
    if not size > 0.0 or (unit == "steps" and size != int(size)):
        what = "a whole number > 0" if unit == "steps" else f"a number > 0 [{unit}]"
        raise AnalysisError(f"delta: expected {what}, got {in_words(delta)}")
    true, believed, time, travelled, dropped = _together(reference, estimate, most_apart, interpolate)
    transform = _alignment(true, believed, align, estimate)
    if align != "none":
        believed = transform.apply(believed)
    if unit == "m":
        pairs = pairs_by_distance(believed, delta, every=every)
    elif unit == "steps":
        pairs = pairs_by_steps(len(time), int(delta), every=every)
    else:
        pairs = pairs_by_time(time, size, every=every)
    if not len(pairs[0]):
        raise AnalysisError(
            f"{estimate.name}: there is no stretch of {delta:g} {unit} in it; it has {len(time)} poses over "
            f"{path_lengths(believed)[-1]:.3g} m; take a smaller delta"
        )
    position, heading = relative_errors(true, believed, pairs)
    return PoseErrors(
        what=f"relative pose error over {delta:g} {unit}",
        time=time[pairs[1]],
        travelled=travelled[pairs[1]],
        position=position,
        heading=heading,
        transform=transform,
        dropped=dropped,
    )


@checked
def relation_errors(
    estimate: Trajectory, relations: npt.ArrayLike, *, most_apart: Annotated[float, "a number of seconds"] = 0.05
) -> PoseErrors:
    """The errors of an estimated trajectory in known relations between its poses (Kümmerle et al. 2009).

    For data without a true trajectory, experts have stated how far apart the robot was at two times, from scans matched
    by hand. Nothing is aligned: only motions are compared. If one scan of two is missing, the times of both may be
    nearest to the pose of the other. Unless one of these is the pose's own to a microsecond, nothing tells which it is,
    and the relations of both are left out.

    Parameters
    ----------
    relations
        (M, 5): two times [s], and the true motion (x [m], y [m], heading [rad]) from the pose at the first to that at
        the second, in the frame of the first.
    most_apart
        How far from these times a pose may be [s].

    Raises
    ------
    AnalysisError
        If these are not relations, or none has poses at its times.
    """
    try:
        given = numbers(relations, "relations", ("M", 5))
    except ParameterError as error:
        raise AnalysisError(f"{error}; they are two times and x, y, heading") from None
    if len(estimate) < 1:
        raise AnalysisError(f"{estimate.name}: expected poses, got none")
    moments, which = np.unique(given[:, :2], return_inverse=True)
    places = _own_poses(estimate.time, moments, most_apart)[which].reshape(-1, 2)
    there = np.flatnonzero((places >= 0).all(axis=1) & (places[:, 0] != places[:, 1]))
    if not len(there):
        raise AnalysisError(f"{estimate!r} has no poses at the times of these relations, to {most_apart:g} s")
    first, last = places[there].T
    count = len(there)
    # The true motions as poses seen from the origin.
    reference = np.concatenate((np.zeros((count, 3)), given[there, 2:5]))
    believed = np.concatenate((estimate.poses[first], estimate.poses[last]))
    pairs = np.arange(count), count + np.arange(count)
    position, heading = relative_errors(reference, believed, pairs)
    return PoseErrors(
        what="error of known relations",
        time=estimate.time[last],
        travelled=path_lengths(estimate.poses)[last],
        position=position,
        heading=heading,
        transform=Transform(),
        dropped=len(given) - count,
    )


def _own_poses(time: Array, moments: Array, most_apart: float) -> Ints:
    """The pose of each moment `(Q,)`: the nearest to it. It is -1 if that is too far, or may be another moment's."""
    place = np.abs(time[:, None] - moments).argmin(axis=0)
    apart = np.abs(time[place] - moments)
    is_near = apart <= most_apart + 1e-9
    is_alone = np.bincount(place[is_near], minlength=len(time))[place] == 1
    return np.where(is_near & (is_alone | (apart <= _SAME_TIME)), place, -1)


def _number(given: object, name: str, expected: str) -> float:
    try:
        return real(given, name, expected)
    except ParameterError as error:
        raise AnalysisError(str(error)) from None


def _together(
    reference: Trajectory, estimate: Trajectory, most_apart: float | None, interpolate: bool
) -> tuple[Array, Array, Array, Array, int]:
    """True and estimated poses at equal times, these times, the way travelled, and how many have no partner."""
    check_kind(reference, Trajectory, "reference", _A_TRAJECTORY)
    check_kind(estimate, Trajectory, "estimate", _A_TRAJECTORY)
    if most_apart is None:
        most_apart = 0.5 * float(np.median(np.diff(reference.time))) if len(reference) > 1 else 0.0
    if not _number(most_apart, "most_apart", "a number >= 0 [s]") >= 0.0:
        raise AnalysisError(f"most_apart: expected a number >= 0 [s], got {in_words(most_apart)}")
    # Times that were written with fewer digits are still those of the same step.
    if interpolate:  # between poses of the reference there may be many of the estimate
        second, first = nearest(estimate.time, reference.time, most_apart + 1e-9)
    else:
        first, second = associate(reference.time, estimate.time, most_apart + 1e-9)
    if not len(second):
        raise AnalysisError(
            f"{reference!r} and {estimate!r} have no poses less than {most_apart:g} s apart; give most_apart, or bring "
            "their clocks together"
        )
    time, believed = estimate.time[second], estimate.poses[second]
    lengths = path_lengths(reference.poses)
    if not interpolate:
        return (
            reference.poses[first],
            believed,
            time,
            lengths[first],
            min(len(reference), len(estimate)) - len(first),
        )
    inside = (time >= reference.time[0]) & (time <= reference.time[-1])
    time, believed = time[inside], believed[inside]
    true = interpolated(reference.time, reference.poses, time)
    dropped = len(estimate) - len(time)
    return true, believed, time, np.interp(time, reference.time, lengths), dropped


def _alignment(true: Array, believed: Array, align: str, estimate: Trajectory) -> Transform:
    check_text(align, "align")
    if align not in _ALIGN:
        raise AnalysisError(f"align: expected one of {', '.join(_ALIGN)}, got {align!r}")
    try:
        if align == "first":
            return first_pose_transform(believed, true)
        if align.startswith("umeyama"):
            return umeyama(believed[:, :2], true[:, :2], with_scale=align == "umeyama_scale")
    except ValueError as error:
        raise AnalysisError(f"{estimate.name}: cannot be aligned: {error}") from None
    return Transform()
