"""Frames, packed and unpacked."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from amorsim.ui.simulator.frames.packing import (
    FRAME_HEADER,
    Bundle,
    Dynamic,
    FrameFlag,
    Selected,
    pack_bundle,
    pack_frame,
    unpack_frame,
)

SIZES = st.integers(0, 5)


def moment(
    robots: int, obstacles: int, values: int, sensors: int, joints: int, channels: int, parts: int = 0
) -> Dynamic:
    numbers = iter(np.random.default_rng(1).normal(size=10**5).astype(np.float32).astype(float))

    def some(*shape: int) -> Any:
        return np.array([next(numbers) for _ in range(int(np.prod(shape)))]).reshape(shape)

    return Dynamic(
        version=3,
        number=2**32 - 1,
        epoch=7,
        time=12.34,
        speed=float("inf"),
        achieved=4.5,
        tick=123,
        newest=456,
        oldest=1,
        flags=int(FrameFlag.RUNNING | FrameFlag.SCRUBBED),
        events=9,
        selected_robot=-1,
        true_pose=some(robots, 3),
        estimated_pose=some(robots, 3),
        covariance=some(robots, 6),
        obstacle_pose=some(obstacles, 3),
        robot_flags=np.arange(robots, dtype=np.uint8),
        selected=Selected(
            some(values),
            some(values),
            some(sensors),
            some(joints),
            some(joints),
            some(3),
            some(3),
            some(channels),
            some(3 * parts),
            some(4 * parts),
            some(10 * parts),
        ),
    )


@given(SIZES, SIZES, SIZES, SIZES, SIZES, SIZES, SIZES)
def test_a_frame_comes_back_as_it_was(
    robots: int, obstacles: int, values: int, sensors: int, joints: int, channels: int, parts: int
) -> None:
    before = moment(robots, obstacles, values, sensors, joints, channels, parts)
    after = unpack_frame(pack_frame(before))
    for name, was in before._asdict().items():
        now = getattr(after, name)
        if name == "selected":
            for part, other in zip(was, now, strict=True):
                np.testing.assert_array_equal(part, other)
        else:
            np.testing.assert_array_equal(now, was, err_msg=name)


def test_sections_lie_where_a_script_may_view_them() -> None:
    # Views of float64 in a browser must begin at a multiple of 8, of float32 at one of 4.
    assert FRAME_HEADER.size == 96
    # Written down once by hand, for the script in the browser reads it by these places.
    data = pack_frame(moment(2, 1, 3, 2, 2, 2, 1))
    whole = unpack_frame(data)
    assert np.frombuffer(data, "<u4", 3, 4).tolist() == [3, 2**32 - 1, 7]
    assert np.frombuffer(data, "<f8", 1, 16)[0] == 12.34
    assert np.frombuffer(data, "<f4", 2, 24).tolist() == [np.inf, 4.5]
    assert np.frombuffer(data, "<u4", 6, 32).tolist() == [123, 456, 5, 9, 2, 1]
    assert np.frombuffer(data, "<i4", 6, 56).tolist() == [-1, 3, 2, 2, 2, 1]
    np.testing.assert_array_equal(np.frombuffer(data, "<f8", 3, 96 + 8 * 3), whole.selected.measured)
    first = 96 + 8 * (3 + 3 + 2 + 2 + 2 + 3 + 3 + 2 + 3 + 4 + 10)
    assert np.frombuffer(data, "<u4", 3, 80).tolist() == [1, 1, 1]
    np.testing.assert_array_equal(np.frombuffer(data, "<f4", 6, first + 24), whole.estimated_pose.ravel())


def test_a_thousand_robots_stay_below_64_kilobytes() -> None:
    assert len(pack_frame(moment(1000, 20, 200, 5, 4, 4))) < 64_000


@given(st.lists(st.tuples(SIZES, SIZES, SIZES, SIZES, SIZES), min_size=1, max_size=4), SIZES, SIZES)
def test_a_bundle_gives_each_window_its_frame(
    parts: list[tuple[int, int, int, int, int]], robots: int, obstacles: int
) -> None:
    first = moment(robots, obstacles, *parts[0])
    moments = [
        first._replace(selected_robot=i, selected=moment(robots, obstacles, *sizes).selected)
        for i, sizes in enumerate(parts)
    ]
    bundle = Bundle(pack_bundle(moments))
    assert bundle.robots == list(range(len(parts)))
    assert (bundle.epoch, bundle.newest, bundle.flags) == (7, 456, FrameFlag.RUNNING | FrameFlag.SCRUBBED)
    for i, one in enumerate(moments):
        assert bundle.frame(i, 41) == pack_frame(one._replace(number=41))
        assert bundle.frame(i, 41, 16) == pack_frame(one._replace(number=41, flags=16))
    assert bundle.frame(len(parts), 41) is None
    # Of a robot that nobody looked at there is what there is of all.
    bare = unpack_frame(bundle.bare_frame(9, 41, 16))
    assert (bare.selected_robot, bare.number, bare.flags, bare.tick) == (9, 41, 16, first.tick)
    assert [len(part) for part in bare.selected] == [0, 0, 0, 0, 0, 3, 3, 0, 0, 0, 0]
    np.testing.assert_array_equal(bare.true_pose, first.true_pose)
    np.testing.assert_array_equal(bare.robot_flags, first.robot_flags)


@pytest.mark.parametrize("data", [b"", b"amb1", b"nope" + bytes(200)])
def test_bytes_that_are_no_bundle_are_refused(data: bytes) -> None:
    with pytest.raises(ValueError, match="expected a bundle"):
        Bundle(data)


@pytest.mark.parametrize("data", [b"", b"amf1", b"nope" + bytes(200), None])
def test_other_bytes_are_refused(data: bytes | None) -> None:
    if data is None:
        data = pack_frame(moment(2, 0, 3, 1, 2, 2))[:-1]
    with pytest.raises(ValueError, match="expected a frame"):
        unpack_frame(data)
