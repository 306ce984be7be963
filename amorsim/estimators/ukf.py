"""An unscented Kalman filter: the same as the extended one, with points in place of slopes."""

from __future__ import annotations

import math

import attrs

from amorsim.contracts import parameter
from amorsim.estimators.kalman import KalmanFilter
from amorsim.kernels.filters.unscented import Transform

__all__ = ["Ukf"]

_SIZE = 4  # of the state


@attrs.frozen(kw_only=True)
class Ukf(KalmanFilter):
    """Predicts with the nominal drive and corrects with what other sensors measure: an unscented Kalman filter.

    The same as `ekf`, sensor for sensor, but for one thing: where that takes slopes at the mean, this one carries
    points that stand for the covariance through the equations. So it sees how bearings and ways bend over what is not
    known. All other parameters are those of `ekf`.

    Parameters
    ----------
    alpha, kappa
        How far from the mean the points are: ``alpha * sqrt(4 + kappa)`` standard deviations.
    beta
        What is known of the distribution; 2 for a Gaussian.
    """

    alpha: float = parameter(1.0, gt=0, le=1, static=True, help="spread of the points")
    beta: float = parameter(2.0, ge=0, static=True, help="what is known of the distribution; 2: Gaussian")
    kappa: float = parameter(0.0, ge=0, static=True, help="further spread of the points")

    def transform(self) -> Transform:
        """Transforms by sigma points: two for each number of the state, and the mean."""
        scale = self.alpha**2 * (_SIZE + self.kappa)
        middle = 1.0 - _SIZE / scale + (1.0 - self.alpha**2 + self.beta)
        return Transform(by_points=True, reach=math.sqrt(scale), middle=middle, each=0.5 / scale)
