"""The response of a motor against the midpoint rule in very many steps, and against itself in two halves."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from amorsim.kernels.kinematics.actuation import respond

INF = math.inf


def naive(value: float, target: float, limit: float, lag: float, dt: float, n: int = 50_000) -> tuple[float, float]:
    total, step = 0.0, dt / n
    for _ in range(n):
        half = value + 0.5 * step * min(max((target - value) / lag, -limit), limit)
        value += step * min(max((target - half) / lag, -limit), limit)
        total += half * step
    return value, total


@pytest.mark.parametrize("target", [3.0, -2.0, 0.5])
@pytest.mark.parametrize("limit", [INF, 4.0])
@pytest.mark.parametrize("dt", [0.1, 1.0])
def test_it_is_the_solution_of_its_equation(target: float, limit: float, dt: float) -> None:
    found = respond(0.5, target, limit, 0.3, dt)
    assert found == pytest.approx(naive(0.5, target, limit, 0.3, dt), abs=1e-8)


def test_without_lag_it_is_a_ramp_or_there_at_once() -> None:
    assert respond(1.0, 5.0, INF, 0.0, 0.1) == (5.0, 0.5)
    assert respond(1.0, 5.0, 2.0, 0.0, 0.5) == pytest.approx((2.0, 0.75))
    assert respond(1.0, 2.0, 2.0, 0.0, 1.0) == pytest.approx((2.0, 0.75 + 1.0))


numbers = st.floats(-20.0, 20.0)


@given(
    value=numbers,
    target=numbers,
    limit=st.sampled_from([INF, 0.5, 7.0]),
    lag=st.sampled_from([0.0, 0.02, 0.7]),
    dt=st.floats(1e-3, 3.0),
    cut=st.floats(0.01, 0.99),
)
def test_two_parts_of_a_step_end_where_it_does(
    value: float, target: float, limit: float, lag: float, dt: float, cut: float
) -> None:
    middle, first = respond(value, target, limit, lag, dt * cut)
    end, second = respond(middle, target, limit, lag, dt - dt * cut)
    whole, total = respond(value, target, limit, lag, dt)
    assert end == pytest.approx(whole, abs=1e-11)
    assert first + second == pytest.approx(total, abs=1e-10)
    assert min(value, target) - 1e-12 <= whole <= max(value, target) + 1e-12
