"""An unscented Kalman filter: the same as the extended one, with points in place of slopes."""

from __future__ import annotations

import math

import attrs

from amorsim.contracts import parameter
from amorsim.estimators.kalman import KalmanFilter
from amorsim.kernels.filters import ekf

__all__ = ["Ukf"]

_SIZE = 4  # of the state


@attrs.frozen(kw_only=True)
class Ukf(KalmanFilter):
    """Predicts with the nominal drive and corrects with what other sensors measure: an unscented Kalman filter.

    The same as `ekf`, sensor for sensor, but for one thing: where that takes slopes at the mean, this one carries
    points that stand for the covariance through the equations. So it sees how bearings and ways bend over what is not
    known.

    Parameters
    ----------
    prediction
        What moves the pose: ``"encoder"``, or ``"command"`` for the nominal drive's response to the commands.
    encoder
        Name of the sensor that counts the joints. It must read in every step.
    wheel_variance
        Variance of the travel of each rolling joint per metre, as the robot assumes it [m^2/m].
    landmarks
        Name of the sensor of ranges, bearings and identities (a ``fiducial``), of the landmarks in the robot's
        ``knowledge.landmarks``. Empty: none; and so for the other sensors.
    range_std, bearing_std
        Standard deviations of its ranges [m] and bearings [rad].
    association
        Which landmark a sighting is of: ``"identity"``, the one with the identity read; ``"nearest"``, the one with the
        smallest NIS, each at most once in a reading; ``"joint"``, those of most sightings that fit all together (joint
        compatibility).
    gps
        Name of the sensor of places, and of its two coordinates the standard deviation [m] and their correlation.
    compass, compass_std
        Name of the sensor of the heading, and its standard deviation [rad].
    gyro, gyro_std
        Name of the sensor of the rate of turn, and its standard deviation [rad/s].
    gyro_bias_std
        Standard deviation of the gyro's bias at the start [rad/s].
    gyro_bias_walk
        Standard deviation by which that bias changes in a second [rad/s].
    start_std, start_heading_std
        Standard deviations [m, rad] that are added, as variances, to the covariance of the robot's initial belief.
    gate
        Probability with which a correction passes if the filter's noise is right; 1 lets everything pass.
    age_max
        The oldest reading [s] that is used as if it were taken now. An older one is an error, as the filter keeps no
        history.
    on_failure
        What happens when its numbers explode, which is an event: ``"continue"`` from the last valid state, or
        ``"end"``, by which it stays there and the robot's controller ends.
    alpha, kappa
        How far from the mean the points are: ``alpha * sqrt(4 + kappa)`` standard deviations.
    beta
        What is known of the distribution; 2 for a Gaussian.
    """

    alpha: float = parameter(1.0, gt=0, le=1, static=True, help="spread of the points")
    beta: float = parameter(2.0, ge=0, static=True, help="what is known of the distribution; 2: Gaussian")
    kappa: float = parameter(0.0, ge=0, static=True, help="further spread of the points")

    def transform(self) -> ekf.Transform:
        """By points: two for each number of the state, and the mean."""
        scale = self.alpha**2 * (_SIZE + self.kappa)
        middle = 1.0 - _SIZE / scale + (1.0 - self.alpha**2 + self.beta)
        return ekf.Transform(by_points=True, reach=math.sqrt(scale), middle=middle, each=0.5 / scale)
