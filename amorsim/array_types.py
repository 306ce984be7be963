"""Types of NumPy arrays for annotations, by what they hold; docstrings tell the shapes."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["AnyArray", "Array", "Bools", "Ints", "Ints32"]

AnyArray = npt.NDArray[Any]
Array = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Ints = npt.NDArray[np.int64]
Ints32 = npt.NDArray[np.int32]
