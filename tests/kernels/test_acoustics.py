"""The first sounds against a slow and obvious twin, that lists all sounds by all rays and sorts them."""

import math

import numpy as np
import pytest

from amorsim.kernels.sensing import acoustics, earshot

SPEED = 343.0
TOGETHER = 3


def within(pose, half, point):
    dx, dy = point[0] - pose[0], point[1] - pose[1]
    if dx == dy == 0.0:
        return True
    off = math.atan2(dy, dx) - pose[2]
    return abs(math.atan2(math.sin(off), math.cos(off))) <= half


def end_of(case, m, f):
    """Where a ray of a listener ends."""
    x, y, heading = case["poses"][m]
    angle, way = heading + case["half"][m // case["each"]] * case["fan"][f], case["ranges"][m, f]
    return x + way * math.cos(angle), y + way * math.sin(angle)


def all_sounds(case, m):
    """(reading, number) of every sound that a listener can hear, in order."""
    n, j = divmod(m, case["each"])
    own = np.flatnonzero(case["own"][n])
    itself = own[j] if j < len(own) else -1
    found = []
    listener, half = case["poses"][m], case["half"][n]
    for i, emitter in enumerate(case["emitters"][n]):
        if not case["fired"][n, i] or i == itself:
            continue
        ahead = SPEED * (case["fires"][n, i] - case["listens"][n, j])
        ends = [(None, math.dist(emitter[:2], listener[:2]))]
        for f, (way, on) in enumerate(zip(case["ranges"][m], case["surface"][m], strict=True)):
            point = end_of(case, m, f) if math.isfinite(way) else (0.0, 0.0)
            reflects = math.isfinite(way) and on != case["body"][n, i]
            ends.append((point, way + math.dist(emitter[:2], point) if reflects else math.inf))
        for f, (point, way) in enumerate(ends):
            if point is None:
                fits = within(listener, half, emitter) and within(emitter, case["emitter_half"][n, i], listener)
            else:
                fits = math.isfinite(way) and within(emitter, case["emitter_half"][n, i], point)
            reading = 0.5 * (way + ahead)
            if fits and case["least"] <= reading <= case["most"]:
                found.append((reading, i * len(ends) + f))
    return sorted(found)


def some_case(seed, rows=3, each=4, count=5, fan=7, late=0.002):
    rng = np.random.default_rng(seed)
    m = rows * each
    case = {
        "each": each,
        "poses": rng.uniform((-1, -1, -3), (1, 1, 3), (m, 3)),
        "half": rng.uniform(0.2, 1.5, rows),
        "listens": rng.uniform(0.0, late, (rows, each)),
        "own": rng.random((rows, count)) < 0.6,
        "emitters": rng.uniform((-1, -1, -3), (1, 1, 3), (rows, count, 3)),
        "emitter_half": rng.uniform(0.2, 2.0, (rows, count)),
        "fires": rng.uniform(0.0, late, (rows, count)),
        "fired": rng.random((rows, count)) < 0.8,
        "least": 0.1,
        "most": 2.0,
    }
    ranges = rng.uniform(0.2, 2.0, (m, fan))
    case["ranges"] = np.where(rng.random(ranges.shape) < 0.2, np.inf, ranges)
    case["body"] = rng.integers(0, 3, (rows, count))
    case["surface"] = rng.integers(-1, 3, ranges.shape)
    case["fan"] = np.linspace(-1.0, 1.0, fan)
    return case


def laid(case):
    """What kernels take of a case: listeners, emitters, who faces whom, and the surfaces that their looks meet."""
    rows, each = case["listens"].shape
    m, f = case["ranges"].shape
    cones = np.stack((case["half"], np.full(rows, case["least"]), np.full(rows, case["most"])), axis=1)
    listeners = acoustics.Listeners(case["poses"], case["listens"], cones)
    emitters = acoustics.Emitters(
        case["emitters"], case["emitter_half"], case["fired"], case["own"], case["fires"], case["body"]
    )
    facing = acoustics.Facing(
        np.empty((m, 3)),
        np.empty((*case["fires"].shape, 4)),
        np.empty((m, case["fires"].shape[1]), dtype=np.bool_),
        np.empty((rows, 1)),
        np.empty((m, f), dtype=np.int64),
        np.empty(m, dtype=np.bool_),
    )
    looks = rows * earshot.face(listeners, emitters, case["fan"], SPEED, TOGETHER, facing)
    surfaces = acoustics.Surfaces(
        np.empty((looks, 3)),
        np.empty((looks, TOGETHER)),
        np.full((looks, TOGETHER), np.inf),
        np.full((looks, TOGETHER), -1, dtype=np.int64),
    )
    earshot.lay_rays(listeners, facing, case["fan"], surfaces)
    for n in range(rows):
        look = n * looks // rows
        for i in range(n * each, n * each + each):
            rays = facing.rays[i][facing.rays[i] >= 0]
            for first in range(0, len(rays), TOGETHER):
                those = rays[first : first + TOGETHER]
                assert (surfaces.poses[look] == case["poses"][i]).all()
                assert (surfaces.bearings[look, : len(those)] == case["half"][n] * case["fan"][those]).all()
                surfaces.ranges[look, : len(those)] = case["ranges"][i, those]
                surfaces.owner[look, : len(those)] = case["surface"][i, those]
                look += 1
    return listeners, emitters, facing, surfaces


@pytest.mark.parametrize("late", [0.002, 0.02])
@pytest.mark.parametrize("batch", [1, 3])
@pytest.mark.parametrize("seed", range(8))
def test_sounds_come_in_order_until_there_are_none(seed, batch, late):
    """By the rays that may carry a sound, all that any ray would; with cones of more than half a turn, too."""
    case = some_case(seed, late=late)
    listeners, emitters, facing, surfaces = laid(case)
    m = len(case["poses"])
    after, after_number = np.full(m, -np.inf), np.full(m, -1, dtype=np.int64)
    sounds = acoustics.Sounds(np.empty((m, batch)), np.empty((m, batch), dtype=np.int64), np.empty((m, batch, 2)))
    expected = [all_sounds(case, i) for i in range(m)]
    assert any(len(each) > (3 if late < 0.01 else 1) for each in expected)
    assert all(not each for each, done in zip(expected, facing.is_done, strict=True) if done)
    for turn in range(max(map(len, expected)) // batch + 1):
        most = acoustics.first_sounds(listeners, emitters, facing, surfaces, SPEED, after, after_number, sounds)
        assert most == (sounds.number.reshape(len(case["half"]), -1) >= 0).sum(axis=1).max()
        for i, each in enumerate(expected):
            for b, place in enumerate(range(turn * batch, turn * batch + batch)):
                if place >= len(each):
                    assert sounds.number[i, b] == -1
                    assert sounds.reading[i, b] == math.inf
                    continue
                reading, number = each[place]
                assert sounds.number[i, b] == number
                assert sounds.reading[i, b] == pytest.approx(reading, rel=1e-14)
                f = number % (len(case["fan"]) + 1)
                start = end_of(case, i, f - 1) if f else case["poses"][i, :2]
                assert sounds.place[i, b] == pytest.approx(start, abs=1e-12)
        # Who has heard everything stays silent.
        facing.is_done[:] |= sounds.number[:, -1] < 0
        after, after_number = sounds.reading[:, -1].copy(), sounds.number[:, -1].copy()


def test_a_ring_of_narrow_cones_casts_few_of_its_rays():
    """Of 16 cones of 30 degrees in their turns, 20 degrees apart and more, a tenth and more is spared."""
    case = some_case(0, rows=1, each=16, count=16, fan=61)
    heading = np.radians([90, 50, 30, 10, -10, -30, -50, -90, -90, -130, -150, -170, 170, 150, 130, 90])
    case["poses"] = np.stack((0.2 * np.cos(heading), 0.2 * np.sin(heading), heading), axis=1)
    case["emitters"], case["emitter_half"] = case["poses"][None], np.full((1, 16), math.radians(15.0))
    case["half"], case["own"], case["fired"] = np.array([math.radians(15.0)]), np.ones((1, 16), bool), True
    case["fired"] = np.ones((1, 16), bool)
    case["listens"] = case["fires"] = 0.04 * np.array([[0, 1, 2, 3, 4, 5, 6, 7] * 2])
    case["most"] = 5.0
    _, _, facing, _ = laid(case)
    assert (facing.rays >= 0).sum() < 0.5 * facing.rays.size
    assert not np.diagonal(facing.hears).any()
    assert facing.hears.sum() < 0.2 * facing.hears.size


def test_the_first_free_sound_is_heard():
    """Three listeners of a row: the first sound is free; the second one is; the last of a full batch is not."""
    number = np.array([[3, 5], [4, 6], [2, 7]])
    sounds = acoustics.Sounds(np.array([[1.0, 2.0], [1.5, 2.5], [0.5, 0.7]]), number, np.zeros((3, 2, 2)))
    lines = acoustics.Lines(np.zeros((6, 3)), np.tile((3.0, 4.0), (6, 1)), np.array([0, 1, 2, 0, 1, 2]))
    reach = np.array([[5.0], [np.inf], [4.9], [4.9], [4.9], [4.9]])
    met = np.array([[-1], [-1], [0], [0], [0], [-1]])
    heard, is_done = np.full((1, 3), np.inf), np.zeros(3, dtype=np.bool_)
    after, after_number = np.full(3, -np.inf), np.full(3, -1, dtype=np.int64)
    assert acoustics.take_free(sounds, lines, reach, met, is_done, heard, after, after_number)
    assert heard.tolist() == [[1.0, 2.5, np.inf]]  # the second meets but what carries its emitter
    assert is_done.tolist() == [True, True, False]
    assert (after[2], after_number[2]) == (0.7, 7)


def test_lines_begin_before_the_surface_and_end_at_the_emitter():
    case = some_case(3)
    listeners, emitters, facing, surfaces = laid(case)
    m, off = len(case["poses"]), 0.01
    sounds = acoustics.Sounds(np.empty((m, 2)), np.empty((m, 2), dtype=np.int64), np.empty((m, 2, 2)))
    after, after_number = np.full(m, -np.inf), np.full(m, -1, dtype=np.int64)
    each = acoustics.first_sounds(listeners, emitters, facing, surfaces, SPEED, after, after_number, sounds)
    rows = len(case["half"])
    lines = acoustics.Lines(
        np.empty((rows * each, 3)), np.empty((rows * each, 2)), np.empty(rows * each, dtype=np.int64)
    )
    acoustics.lay_lines(listeners, emitters, facing, sounds, off, lines)
    for n in range(rows):
        at = n * each
        for i in range(n * case["each"], (n + 1) * case["each"]):
            for number, place in zip(sounds.number[i], sounds.place[i], strict=True):
                if number < 0:
                    continue
                emitter = number // (len(case["fan"]) + 1)
                back = case["poses"][i, :2] - place
                way = math.hypot(*back)
                start = place + back * min(off / way, 1.0) if way else place
                assert lines.poses[at, :2] == pytest.approx(start, abs=1e-12)
                assert lines.poses[at, :2] + lines.ahead[at] == pytest.approx(
                    case["emitters"][n, emitter, :2], abs=1e-12
                )
                assert lines.carrier[at] == case["body"][n, emitter]
                at += 1
        assert (lines.carrier[at : (n + 1) * each] == -1).all()
