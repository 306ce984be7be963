"""An extended Kalman filter: wheels predict; landmarks, satellites, a compass and a gyro correct."""

from __future__ import annotations

import attrs

from amorsim.estimators.kalman import KalmanFilter
from amorsim.kernels.filters.unscented import Transform

__all__ = ["Ekf"]

_SLOPES = Transform(by_points=False, reach=1.0, middle=0.0, each=0.0)


@attrs.frozen(kw_only=True)
class Ekf(KalmanFilter):
    """Predicts with the nominal drive and corrects with what other sensors measure: an extended Kalman filter.

    The state is the pose and the bias of the gyro. Wheels predict: by their encoder, or by the commands through the
    drive's nominal dynamics. Each sensor that is named corrects: landmarks by range and bearing, a GPS, a compass, a
    gyro. A sensor that is not named is not used. The noise of each that is named must be stated.

    Each correction must pass a chi-squared gate. `beliefs` has each sensor's innovation, its covariance, the
    normalised innovation squared (NIS), and whether the gate let it pass.

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
    """

    def transform(self) -> Transform:
        """Transforms by slopes at the mean."""
        return _SLOPES
