"""Components over rows."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

from amorsim.core.parameters import parameter
from amorsim.core.poses import Mount
from amorsim.core.rows import signature, stack, take


@attrs.frozen(kw_only=True)
class Device:
    """Numbers, a static one, a nested table, a ring of tables, a tuple of numbers."""

    gain: float = parameter(1.0)
    step: int = parameter(2)
    beams: int = parameter(3, static=True)
    mode: str = parameter("a")
    limit: float | None = parameter(None)
    mount: Mount = parameter(Mount())
    ring: tuple[Mount, ...] = parameter(())
    weights: tuple[float, ...] = parameter((1.0, 2.0))
    points: tuple[tuple[float, float], ...] = parameter(())


def devices(count: int) -> list[Device]:
    return [
        Device(
            gain=float(i),
            step=i,
            mount=Mount(x=float(i)),
            ring=(Mount(y=float(i)), Mount(heading=1.0)),
            weights=(float(i), 5.0),
        )
        for i in range(count)
    ]


def test_numbers_become_columns_and_the_rest_stays() -> None:
    made = stack(devices(3))
    assert made.gain.tolist() == [[0.0], [1.0], [2.0]]
    assert made.step.dtype == np.int64
    assert made.mount.x.tolist() == [[0.0], [1.0], [2.0]]
    assert made.ring.y.tolist() == [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]  # type: ignore[attr-defined]
    assert made.ring.heading.tolist() == [[0.0, 1.0]] * 3  # type: ignore[attr-defined]
    assert made.weights.tolist() == [[0.0, 5.0], [1.0, 5.0], [2.0, 5.0]]  # type: ignore[attr-defined]
    assert (made.beams, made.mode, made.limit) == (3, "a", None)


def test_a_whole_number_given_for_a_float_is_a_float() -> None:
    made = stack([Device(gain=1), Device(gain=2)])
    assert made.gain.dtype == np.float64
    assert stack([Device(weights=(1, 2))]).weights.dtype == np.float64  # type: ignore[attr-defined]


def test_arrays_are_read_only() -> None:
    made = stack(devices(2))
    for array in (made.gain, made.mount.x, take(made, np.array([1])).gain):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 5.0  # type: ignore[index]


def test_take_gives_the_rows_asked_for() -> None:
    made = take(stack(devices(4)), np.array([3, 1, 1]))
    assert made.gain.tolist() == [[3.0], [1.0], [1.0]]
    assert made.mount.x.tolist() == [[3.0], [1.0], [1.0]]
    assert made.beams == 3


def test_one_signature_a_group() -> None:
    base = devices(2)[1]
    assert signature(base) == signature(attrs.evolve(base, gain=9.0, mount=Mount(y=3.0), weights=(3.0, 3.0)))
    for change in (
        {"beams": 4},
        {"mode": "b"},
        {"limit": 1.0},
        {"weights": (1.0, 2.0, 3.0)},
        {"ring": (Mount(),)},
    ):
        assert signature(base) != signature(attrs.evolve(base, **change)), change


def test_points_become_an_array_of_rows() -> None:
    pairs = [((1.0, 2.0), (3.0, 4.0)), ((5, 6.0), (7.0, 8.0))]
    made = stack([Device(points=points) for points in pairs])
    assert made.points.tolist() == [[list(point) for point in points] for points in pairs]  # type: ignore[attr-defined]
    assert made.points.dtype == np.float64  # type: ignore[attr-defined]
    one, other = (signature(Device(points=points)) for points in pairs)
    assert one == other
    assert signature(Device(points=pairs[0][:1])) != one
    assert signature(Device(points=())) != one
