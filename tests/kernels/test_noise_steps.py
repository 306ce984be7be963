"""What steps make of values, against the same said plainly, value by value."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import amorsim as am
from amorsim.core.draws import Medians
from amorsim.core.noise_steps import NoiseProgram, NoiseStep
from tests.examples import settings

COUNTER = np.array([[4, 1, 17], [5, 0, 18], [6, 2, 2**32 - 1]], dtype=np.uint32)
ROWS = len(COUNTER)

numbers = st.floats(-1e6, 1e6) | st.sampled_from([0.0, -0.0])
sizes = st.floats(1e-3, 1e3)
steps = st.one_of(
    st.builds(NoiseStep.scatter, st.floats(0.0, 10.0), st.floats(0.0, 1.0)),
    st.builds(NoiseStep.add, numbers),
    st.builds(NoiseStep.multiply, sizes),
    st.builds(NoiseStep.round, sizes),
    st.builds(NoiseStep.floor, sizes),
    st.builds(NoiseStep.clip, st.floats(-5.0, 0.0), st.floats(0.0, 5.0)),
    st.builds(NoiseStep.replace, st.floats(0.0, 1.0), numbers | st.just(math.inf)),
)
devices = st.lists(st.tuples(st.integers(1, 5), st.lists(steps, max_size=4)), min_size=1, max_size=3)


def draws(device: int) -> am.Draws:
    return am.Draws(np.arange(ROWS, dtype=np.uint64) + np.uint64(100 * device), COUNTER)


def plainly(step: NoiseStep, values: np.ndarray, its: am.Draws) -> np.ndarray:
    """What a step makes of the values of a device `(N, k)`, by its words."""
    k = values.shape[1]
    numbers = {0: its.normal, 6: its.uniform}.get(step.kind, lambda k: np.zeros((ROWS, k)))(k)
    out = values.copy()
    for place, value in np.ndenumerate(values):
        if step.kind == NoiseStep.scatter(1.0).kind:
            if math.isfinite(value) and step.a + step.b * abs(value) > 0.0:
                out[place] = value + (step.a + step.b * abs(value)) * numbers[place]
        elif step.kind == NoiseStep.add(1.0).kind:
            out[place] = value if step.a == 0.0 else value + step.a
        elif step.kind == NoiseStep.multiply(1.0).kind:
            out[place] = value * step.a
        elif step.kind == NoiseStep.round(1.0).kind:
            out[place] = np.rint(value / step.a) * step.a
        elif step.kind == NoiseStep.floor(1.0).kind:
            out[place] = np.floor(value / step.a) * step.a
        elif step.kind == NoiseStep.clip(0.0, 1.0).kind:
            out[place] = value if value == math.inf else min(max(value, step.a), step.b)
        else:
            out[place] = step.b if numbers[place] < step.a else value
    return out


@given(devices, st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=150)
def test_a_program_does_what_its_steps_say(devices_steps: list[tuple[int, list[NoiseStep]]], seed: int) -> None:
    rng = np.random.default_rng(seed)
    given_, expected = [], []
    for device, (size, its) in enumerate(devices_steps):
        values = rng.normal(0.0, 3.0, (ROWS, size))
        values[rng.random(values.shape) < 0.2] = math.inf
        given_.append(values)
        plain = draws(device)
        for step in its:
            values = plainly(step, values, plain)
        expected.append(values)
    programs = [draws(device) for device in range(len(devices_steps))]
    program = NoiseProgram(
        [size for size, _ in devices_steps],
        [[(step, its) for step in steps_] for (_, steps_), its in zip(devices_steps, programs, strict=True)],
    )
    found = applied(program, np.concatenate([values.ravel() for values in given_]))
    np.testing.assert_array_equal(found, np.concatenate([values.ravel() for values in expected]))


def applied(program: NoiseProgram, values: Any) -> Any:
    out = np.empty_like(values)
    program.apply(values, out)
    return out


def test_medians_scatter_nothing_and_lose_the_lower_half() -> None:
    medians = Medians(np.zeros(ROWS, dtype=np.uint64), COUNTER)
    values = np.ones(2 * ROWS)
    kept = NoiseProgram([2], [[(NoiseStep.scatter(1.0), medians), (NoiseStep.replace(0.5, 7.0), medians)]])
    assert (applied(kept, values) == 1.0).all()
    lost = NoiseProgram([2], [[(NoiseStep.replace(0.51, 7.0), medians)]])
    assert (applied(lost, values) == 7.0).all()


def test_parameters_may_differ_from_row_to_row() -> None:
    factor = np.array([[1.0], [2.0], [-3.0]])
    program = NoiseProgram([2], [[(NoiseStep.multiply(factor), draws(0))]])
    np.testing.assert_array_equal(applied(program, np.ones(2 * ROWS)), [1.0, 1.0, 2.0, 2.0, -3.0, -3.0])
