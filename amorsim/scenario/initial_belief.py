"""A robot's belief of its pose at the start."""

from __future__ import annotations

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import parameter
from amorsim.core.parameters import ParameterError

__all__ = ["InitialBelief"]

_UPPER = np.triu_indices(3)
_ROUNDING = 1e-12  # of the largest eigenvalue


@attrs.frozen(kw_only=True)
class InitialBelief:
    """A robot's belief of its pose at the start: exact, with a Gaussian error, or none.

    A robot with a Gaussian belief starts from a pose that is wrong by a draw from that Gaussian, and its estimators get
    the covariance. A robot that knows nothing needs an estimator that finds it on a map (global localization).

    Parameters
    ----------
    kind
        ``"exact"``, ``"gaussian"`` or ``"nothing"``.
    std, heading_std
        Standard deviations of a Gaussian belief, of each coordinate and of the heading.
    covariance
        Or its covariance: xx, xy, xh, yy, yh, hh, in m and rad.
    """

    kind: str = parameter("exact", choices=("exact", "gaussian", "nothing"), help="how much it knows of its start")
    std: float = parameter(0.0, unit="m", ge=0, help="standard deviation of x and of y, if Gaussian")
    heading_std: float = parameter(0.0, unit="rad", ge=0, help="standard deviation of the heading, if Gaussian")
    covariance: tuple[float, float, float, float, float, float] | None = parameter(
        None, help="in place of these: xx, xy, xh, yy, yh, hh, in m and rad"
    )

    def __attrs_post_init__(self) -> None:
        if self.kind != "gaussian":
            for name in ("std", "heading_std", "covariance"):
                if getattr(self, name):
                    raise ParameterError(name, f"expected it only with kind 'gaussian', got kind {self.kind!r}")
        if self.covariance is not None:
            if self.std or self.heading_std:
                raise ParameterError("covariance", "expected either standard deviations or a covariance, got both")
            least, *_, most = np.linalg.eigvalsh(self.matrix).tolist()
            if least < -_ROUNDING * most or most < 0.0:
                raise ParameterError(
                    "covariance",
                    f"expected xx, xy, xh, yy, yh, hh of a positive covariance, got {list(self.covariance)}, whose "
                    f"smallest eigenvalue is {least:g}",
                )

    @property
    def matrix(self) -> Array:
        """The covariance (3, 3) of x, y and heading [m, m, rad]."""
        if self.covariance is None:
            return np.diag([self.std**2, self.std**2, self.heading_std**2])
        found = np.zeros((3, 3))
        found[_UPPER] = self.covariance
        found.T[_UPPER] = self.covariance
        return found
