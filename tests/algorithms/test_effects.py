"""Effect sizes, and p-values corrected for their number."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amorsim.algorithms.effects import holm, paired_effect


def test_the_effect_is_cohens_d() -> None:
    differences = np.array([1.0, 2.0, 3.0])
    assert paired_effect(differences) == pytest.approx(2.0)
    assert paired_effect(np.full(4, -2.0)) == -math.inf
    assert paired_effect(np.zeros(4)) == 0.0
    assert math.isnan(paired_effect(np.ones(1)))


def test_holm_multiplies_the_least_the_most() -> None:
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([0.5, 0.9]) == [1.0, 1.0]
    assert holm([]) == []
    assert holm([0.04, math.nan, 0.01]) == pytest.approx([0.04, math.nan, 0.02], nan_ok=True)
