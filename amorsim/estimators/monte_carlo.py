"""Monte Carlo localization: a cloud of poses, moved with the wheels, weighed by what a laser sees on a known map."""

from __future__ import annotations

import functools
import math
import statistics
from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array, Bools, Ints
from amorsim.contracts import (
    Beliefs,
    Context,
    Draws,
    Estimate,
    Estimator,
    LazyBeliefs,
    Measurement,
    RobotModel,
    State,
    parameter,
)
from amorsim.core.errors import ComponentError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.estimators.ages import check_fresh
from amorsim.estimators.known_map import Ends, field_of, free_of, maps_of, no_field, nowhere, place_of
from amorsim.estimators.wheels import angles_of, carry, check_encoder, check_keeps_up, is_current, sensor_of, step_of
from amorsim.kernels.filters import modes, particles
from amorsim.kernels.filters.beams import Field, Mixture, Scan
from amorsim.kernels.kinematics.poses import compose

__all__ = ["HYPOTHESES", "MonteCarlo"]


HYPOTHESES = 6  # modes that are kept, at most


@attrs.frozen(kw_only=True)
class MonteCarlo(Estimator):
    """Localizes the robot on the map that it knows by a cloud of weighted poses: Monte Carlo localization.

    Wheels move the particles, each with an error of its own. After `update_distance` or `update_angle` the next scan
    weighs them by how likely it is from each. The estimate is the mean of the heaviest mode, not of all particles;
    `beliefs` has the other modes as hypotheses, and the particles.

    A robot that knows nothing of its start (``initial_belief = { kind = "nothing" }``) begins with `particles_max` all
    over the map.

    Parameters
    ----------
    encoder
        Name of the sensor that counts the joints.
    wheel_variance
        Variance of the travel of each rolling joint per metre, as the robot assumes it [m^2/m].
    laser
        Name of the range sensor.
    beams
        How many of its beams are used, spread evenly.
    model
        How likely a range is: ``"likelihood_field"``, by the distance from its end to the nearest wall, or ``"beam"``,
        by the range to the wall that the beam would meet.
    weighting
        ``"likelihood"``, the product over the beams, or ``"cubed"``, 1 plus the sum of the cubes, as Nav2's AMCL does.
    tempering
        Exponent of the likelihood, for beams whose errors are not independent: 1 trusts all of them, 0.1 as if they
        were a tenth as many.
    z_hit, z_short, z_max, z_random
        Shares of what a range can be: the wall, something unexpected before it, no return, anything. The likelihood
        field knows the first and the last.
    hit_std
        Standard deviation of a range to the wall [m].
    short_rate
        How fast unexpected returns get rarer with the range [1/m].
    distance_max, field_resolution
        Of the likelihood field: the longest distance to a wall that counts, and its cells [m].
    particles_min, particles_max
        Bounds on the number of particles.
    kld_error, kld_probability
        As many particles are kept as hold the distance of Kullback and Leibler from the true belief below this error,
        with this probability.
    bin_size, bin_angle
        Bins of poses, which that number and the modes are counted by [m, rad].
    resample_below
        Resample at an effective sample size below this share of the particles.
    recovery_slow, recovery_fast
        Gains of the slow and the fast average of the mean weight. When the fast one falls below the slow one, particles
        are drawn anywhere on the map. 0: never.
    update_distance, update_angle
        How far the robot moves between updates [m, rad].
    age_max
        The oldest reading [s] that is used as if it were taken now; an older one is an error.
    on_failure
        When a scan is possible from no particle, which is an event: ``"continue"`` with all of them, as likely as each
        other, or ``"end"`` the robot's controller.
    """

    encoder: str = parameter("encoder", refers="sensors", help="name of the sensor that counts the joints")
    wheel_variance: float = parameter(
        unit="m", ge=0, help="variance of a rolling joint's travel [m^2] per metre of it, as the robot believes"
    )
    laser: str = parameter("laser", refers="sensors", help="name of the range sensor")
    beams: int = parameter(60, ge=1, static=True, help="beams of a scan that are used")
    model: str = parameter(
        "likelihood_field", choices=("likelihood_field", "beam"), static=True, help="how likely a range is"
    )
    weighting: str = parameter(
        "likelihood", choices=("likelihood", "cubed"), static=True, help="how beams make a weight; cubed: as Nav2"
    )
    tempering: float = parameter(1.0, gt=0, le=1, help="exponent of the likelihood, for beams that err alike")
    z_hit: float = parameter(0.5, ge=0, le=1, help="share of ranges that are of the wall")
    z_short: float = parameter(0.05, ge=0, le=1, help="share of ranges to something unexpected; beam model only")
    z_max: float = parameter(0.05, ge=0, le=1, help="share of beams that do not return; beam model only")
    z_random: float = parameter(0.5, gt=0, le=1, help="share of ranges that may be anything")
    hit_std: float = parameter(0.2, unit="m", gt=0, static=True, help="standard deviation of a range to the wall")
    short_rate: float = parameter(0.1, unit="1/m", gt=0, help="how fast unexpected returns get rarer with the range")
    distance_max: float = parameter(2.0, unit="m", gt=0, static=True, help="distance beyond which no wall counts")
    field_resolution: float = parameter(0.05, unit="m", gt=0, static=True, help="side of the likelihood field's cells")
    particles_min: int = parameter(500, ge=1, static=True, help="fewest particles")
    particles_max: int = parameter(2000, ge=1, le=10**7, static=True, help="most particles")
    kld_error: float = parameter(0.05, gt=0, lt=1, static=True, help="error of the belief that particles hold")
    kld_probability: float = parameter(0.99, gt=0.5, lt=1, static=True, help="probability with which they hold it")
    bin_size: float = parameter(0.5, unit="m", gt=0, static=True, help="side of the bins that belief is counted in")
    bin_angle: float = parameter(
        math.radians(10.0), unit="rad", gt=0, le=2.0 * math.pi, static=True, help="angle of these bins"
    )
    resample_below: float = parameter(0.5, ge=0, le=1, static=True, help="effective share below which to resample")
    recovery_slow: float = parameter(0.0, ge=0, lt=1, help="gain of the slow average of weights; 0: no recovery")
    recovery_fast: float = parameter(0.0, ge=0, le=1, help="gain of the fast average of weights; 0: no recovery")
    update_distance: float = parameter(0.25, unit="m", ge=0, help="distance moved between updates")
    update_angle: float = parameter(0.2, unit="rad", ge=0, help="angle turned between updates")
    age_max: float = parameter(0.0, unit="s", ge=0, help="age at which a reading still counts as taken now")

    on_failure: str = parameter(
        "continue", choices=("continue", "end"), static=True, help="what it does when no particle fits a scan"
    )

    def __attrs_post_init__(self) -> None:
        if self.particles_min > self.particles_max:
            raise ParameterError(
                "particles_min", f"expected at most particles_max {self.particles_max}, got {self.particles_min}"
            )
        if bool(self.recovery_slow) != bool(self.recovery_fast) or self.recovery_slow > self.recovery_fast:
            raise ParameterError(
                "recovery_slow",
                f"expected a gain above 0 and below recovery_fast {self.recovery_fast}, or both 0, "
                f"got {self.recovery_slow}",
            )

    def sources(self) -> Sequence[tuple[str, str, str]]:
        """The sources that move the particles and those that weigh them."""
        model = "its likelihood field" if self.model == "likelihood_field" else "the beam model"
        return [
            (f"sensor {self.encoder!r}", "moves the particles", f"{self.wheel_variance:g} m² of travel per m"),
            (f"sensor {self.laser!r}", "weighs x, y, heading", f"{self.beams} beams, {model}, {self.hit_std:g} m"),
            ("knowledge.map", "is what it looks for", f"{self.particles_min} to {self.particles_max} particles"),
        ]

    # ------------------------------------------------------------------------------------------------------- starting

    def start(self, context: Context) -> State:
        """An empty cloud; the particles are drawn at the first update.

        Raises
        ------
        ComponentError
            If a sensor is missing or of another kind, or the robot knows no map.
        """
        robot, rows = context.robot, context.rows
        check_encoder("monte_carlo", robot, self.encoder)
        sensor = sensor_of("monte_carlo", robot, self.laser, "laser", "range sensor")
        if sensor.unit != "m" or not hasattr(sensor, "range_max") or sensor.bearings() is None:
            raise ComponentError(
                f"monte_carlo weighs particles by the sensor {self.laser!r}, but a {type(sensor).__name__} measures no "
                "ranges along beams [m], as a laser does"
            )
        check_keeps_up("monte_carlo", robot, self.encoder, self.laser)
        is_lost = bool(np.isnan(context.pose).any())
        self._sensing(robot, np.zeros((rows, sensor.bearings().shape[1])), np.arange(rows), is_lost)
        most = self.particles_max
        return {
            "pose": np.nan_to_num(context.pose),
            "covariance": np.zeros((rows, 3, 3)) if context.covariance is None else np.nan_to_num(context.covariance),
            "lost": np.full(rows, is_lost),
            "begun": np.zeros(rows, dtype=bool),
            "joints": np.full((rows, len(robot.drive.joints)), np.nan),
            "current": np.ones((rows, 1), dtype=bool),
            "moved": np.zeros((rows, 3)),
            "doubt": np.zeros((rows, 3, 3)),
            "particles": np.zeros((rows, most, 3)),
            "weights": np.zeros((rows, most)),
            "count": np.zeros(rows, dtype=np.int64),
            "averages": np.full((rows, 2), np.nan),
            "figures": np.zeros((rows, 3)),
            "hypotheses": np.full((rows, HYPOTHESES, 3), np.nan),
            "hypotheses_covariance": np.full((rows, HYPOTHESES, 3, 3), np.nan),
            "hypotheses_weight": np.full((rows, HYPOTHESES), np.nan),
        }

    # ------------------------------------------------------------------------------------------------------- updating

    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        """The estimate after this step's motion, and after weighing if the robot has moved far enough for a scan."""
        for name in (self.laser, self.encoder):
            check_fresh("monte_carlo", robot, name, readings[name], self.age_max)
        state["figures"][:, 2] = 0.0
        before, after = angles_of(robot, self.encoder, readings[self.encoder].measured, state["joints"])
        state["joints"] = after
        state["current"] = is_current(robot, self.encoder, readings[self.encoder], after, state["current"])
        begins = ~state["begun"]
        if not begins.all():
            step = step_of(robot.drive, before, after)
            for pose, covariance in (("moved", "doubt"), ("pose", "covariance")):
                found = carry(step, state[pose], state[covariance], self.wheel_variance)
                state[pose], state[covariance] = found.pose, found.covariance
        moved_by = state["moved"]
        far = np.sqrt(moved_by[:, :1] ** 2 + moved_by[:, 1:2] ** 2) >= self.update_distance
        far |= np.abs(moved_by[:, 2:]) >= self.update_angle
        fresh = readings[self.laser].fresh & state["current"]
        seen = fresh[:, 0].copy()
        rows = np.flatnonzero(begins | (far[:, 0] & seen)).astype(np.int64)
        if len(rows):
            self._update(rows, begins, seen, robot, readings[self.laser].measured, state, draws)
        return Estimate(state["pose"].copy(), state["covariance"].copy())

    def _update(
        self,
        rows: Ints,
        begins: Bools,
        seen: Bools,
        robot: RobotModel,
        ranges: Array,
        state: State,
        draws: Draws,
    ) -> None:
        """Update the particles of some rows, and take their heaviest modes as the estimates."""
        cloud = particles.Cloud(
            state["particles"], state["weights"], state["count"], state["averages"], state["figures"]
        )
        motion = particles.Motion(
            begins, state["lost"], state["pose"], state["covariance"], state["moved"], state["doubt"]
        )
        groups = self._sensing(robot, ranges, rows, bool(state["lost"].any()))
        sizes = particles.Sizes(
            self.particles_min,
            self.kld_error,
            _quantile(self.kld_probability),
            self.bin_size,
            max(1, round(2.0 * math.pi / self.bin_angle)),
            self.resample_below,
        )
        slow, fast = self.recovery_slow, self.recovery_fast
        keys, counter, block = draws.reserve(2 * (4 * self.particles_max + 2))
        numbers = particles.Numbers(keys, counter, block, slow, fast)
        found = modes.Modes(state["hypotheses"], state["hypotheses_covariance"], state["hypotheses_weight"])

        def work(first: int, end: int) -> None:
            for some, sensing, free in groups:
                some = some[np.searchsorted(some, first) : np.searchsorted(some, end)]
                particles.update(some, cloud, motion, seen, sensing, sizes, free, numbers, found)

        draws.share(int(cloud.counts.max(initial=self.particles_min)) * self.beams // 20, work)
        # In place: nobody else has these arrays.
        state["begun"][rows] = True
        state["moved"][rows] = 0.0
        state["doubt"][rows] = 0.0
        state["pose"][rows] = found.poses[rows, 0]
        state["covariance"][rows] = found.covariances[rows, 0]

    def _sensing(
        self, robot: RobotModel, ranges: Array, rows: Ints, is_lost: bool
    ) -> list[tuple[Ints, particles.Sensing, particles.Free]]:
        """The arrays that weigh particles, with the beams that are used, and where particles are drawn at random.

        A group of rows for each map that robots know, and each likelihood field of it.
        """
        model = robot.sensors[self.laser]
        sensor: Any = model.sensor
        mount: Any = model.mount
        bearings = sensor.bearings()
        which = _spread(self.beams, bearings.shape[1])
        scan = Scan(
            ranges.take(which, axis=1),
            bearings.take(which, axis=1),
            mount.x,
            mount.y,
            mount.heading,
            _column(sensor.range_max, robot.rows),
        )
        mixture = Mixture(self.z_hit, self.z_short, self.z_max, self.z_random, float(self.hit_std), self.short_rate)
        draws_anywhere = is_lost or np.any(np.asarray(self.recovery_fast) > 0.0)
        groups = []
        for known, knowing in maps_of("monte_carlo", robot):
            free = free_of(known) if draws_anywhere else nowhere()
            for field, which_rows in self._fields(known, len(which), mixture, scan, np.intersect1d(rows, knowing)):
                sensing = particles.Sensing(
                    scan,
                    mixture,
                    self.tempering,
                    self.model == "beam",
                    self.weighting == "cubed",
                    field,
                    known.grid,
                    place_of(known),
                )
                groups.append((which_rows, sensing, free))
        return groups

    def _fields(self, known: Map, count: int, mixture: Mixture, scan: Scan, rows: Ints) -> list[tuple[Field, Ints]]:
        """The likelihood fields of a map for scans of `count` beams, each with those of some rows that use it."""
        if self.model == "beam":
            return [(no_field(), rows)]
        hit, rest = mixture.hit[rows, 0], mixture.random[rows, 0] / scan.range_max[rows, 0]
        is_cubed = self.weighting == "cubed"
        return [
            (
                field_of(known, self.field_resolution, Ends(self.hit_std, self.distance_max, *kind, count, is_cubed)),
                rows[(hit == kind[0]) & (rest == kind[1])],
            )
            for kind in sorted({*zip(hit.tolist(), rest.tolist(), strict=True)})
        ]

    def failed(self, state: State) -> Bools:
        """Rows in which no particle could explain the last scan; all were kept, with equal weights."""
        failed: Bools = state["figures"][:, 2] > 0.0
        return failed

    # -------------------------------------------------------------------------------------------------------- beliefs

    def beliefs(self, state: State) -> Beliefs:
        """``particles`` with ``weights``; ``hypotheses``, the modes, heaviest first, with covariance and weight.

        And ``effective_size``, ``count``, and ``recovery``, the probability of a particle at random, of the last
        update. nan where there are no more particles or modes. All are moved on with the wheels since that update.
        """
        most = state["weights"].shape[1]
        is_there = np.arange(most) < state["count"][:, None]

        def particles() -> Array:
            return np.where(is_there[:, :, None], _moved(state["particles"], state["moved"]), np.nan)

        return LazyBeliefs(
            {
                "particles": particles,
                "weights": lambda: np.where(is_there, state["weights"], np.nan),
                "hypotheses": _moved(state["hypotheses"], state["moved"]),
                "hypotheses_covariance": state["hypotheses_covariance"].copy(),
                "hypotheses_weight": state["hypotheses_weight"].copy(),
                "effective_size": state["figures"][:, 0].copy(),
                "count": state["count"].copy(),
                "recovery": state["figures"][:, 1].copy(),
            }
        )


@functools.cache
def _spread(wanted: int, offered: int) -> npt.NDArray[np.intp]:
    """The indices of the used beams of a sensor."""
    return np.round(np.linspace(0, offered - 1, min(wanted, offered))).astype(np.intp)


@functools.cache
def _quantile(probability: float) -> float:
    """The quantile of the normal distribution."""
    return statistics.NormalDist().inv_cdf(probability)


def _column(value: Any, rows: int) -> Array:
    """A parameter of every row `(N, 1)`."""
    found = np.array(value, dtype=np.float64)
    return found if found.shape == (rows, 1) else np.array(np.broadcast_to(found, (rows, 1)))


def _moved(poses: Array, displacement: Array) -> Array:
    """Poses `(N, k, 3)` after each row's displacement `(N, 3)`; nan where they are nan."""
    flat = np.nan_to_num(poses.reshape(-1, 3))
    out = np.empty_like(flat)
    compose(flat, np.repeat(displacement, poses.shape[1], axis=0), out)
    moved: Array = np.where(np.isnan(poses), np.nan, out.reshape(poses.shape))
    return moved
