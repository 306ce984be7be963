"""The first sounds against a slow and obvious twin, that lists all sounds by all rays and sorts them."""

import math

import numpy as np
import pytest

from amorsim.kernels.sensing import acoustics, earshot

SPEED = 343.0


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
    m = len(case["ranges"])
    cones = np.stack((case["half"], np.full(rows, case["least"]), np.full(rows, case["most"])), axis=1)
    listeners = acoustics.Listeners(case["poses"], case["listens"], cones)
    emitters = acoustics.Emitters(
        case["emitters"], case["emitter_half"], case["fired"], case["own"], case["fires"], case["body"]
    )
    facing = acoustics.Facing(
        np.empty((m, 3)),
        np.empty((*case["fires"].shape, 4)),
        np.empty((m, case["fires"].shape[1]), dtype=np.bool_),
        np.empty((m, len(case["fan"]))),
        np.empty(m),
        np.empty(m, dtype=np.bool_),
    )
    earshot.face(listeners, emitters, case["fan"], SPEED, facing)
    # As a look casts them: nothing beyond its limit, 0 where the end is too near to matter, and anything where there is
    # no limit.
    ranges = np.where(case["ranges"] <= facing.limit[:, None], case["ranges"], np.inf)
    ranges[ranges < facing.nearest] = 0.0
    ranges[facing.limit < 0.0] = np.random.default_rng(0).uniform(0.2, 2.0, len(case["fan"]))
    bearings = np.repeat(case["half"], each)[:, None] * case["fan"]
    surfaces = acoustics.Surfaces(bearings, ranges, case["surface"], np.arange(3))
    return listeners, emitters, facing, surfaces


def sounds_of(case, room=1000):
    listeners, emitters, facing, surfaces = laid(case)
    first = np.empty(len(case["poses"]) + 1, dtype=np.int64)
    sounds = acoustics.Sounds(first, np.empty(room), np.empty(room, dtype=np.int64))
    count = acoustics.sounds_in_order(listeners, emitters, facing, surfaces, SPEED, sounds)
    return (listeners, emitters, facing, surfaces), sounds, count


@pytest.mark.parametrize("late", [0.002, 0.02])
@pytest.mark.parametrize("seed", range(8))
def test_sounds_come_in_order(seed, late):
    """By the cones that may carry a sound, all that any ray would; with cones of more than half a turn, too."""
    case = some_case(seed, late=late)
    (_, _, facing, _), sounds, count = sounds_of(case)
    expected = [all_sounds(case, i) for i in range(len(case["poses"]))]
    assert any(len(each) > (3 if late < 0.01 else 1) for each in expected)
    assert all(not each for each, done in zip(expected, facing.is_done, strict=True) if done)
    assert sounds.first[0] == 0
    assert sounds.first[-1] == count == sum(map(len, expected))
    for i, each in enumerate(expected):
        mine = slice(sounds.first[i], sounds.first[i + 1])
        assert sounds.number[mine].tolist() == [number for _, number in each]
        assert sounds.reading[mine] == pytest.approx([reading for reading, _ in each], rel=1e-14)
    assert (facing.limit[facing.is_done] == -1.0).all()


def test_what_has_no_room_is_counted():
    case = some_case(1)
    *_, count = sounds_of(case)
    assert count > 3
    assert sounds_of(case, room=3)[2] == count


def test_of_a_ring_of_narrow_cones_some_are_not_looked_along():
    """Of 16 cones of 30 degrees in their turns, 20 degrees apart and more, and none beyond what a listener reads."""
    case = some_case(0, rows=1, each=16, count=16, fan=61)
    heading = np.radians([90, 50, 30, 10, -10, -30, -50, -90, -90, -130, -150, -170, 170, 150, 130, 90])
    case["poses"] = np.stack((0.2 * np.cos(heading), 0.2 * np.sin(heading), heading), axis=1)
    case["emitters"], case["emitter_half"] = case["poses"][None], np.full((1, 16), math.radians(15.0))
    case["half"], case["own"], case["fired"] = np.array([math.radians(15.0)]), np.ones((1, 16), bool), True
    case["fired"] = np.ones((1, 16), bool)
    case["listens"] = case["fires"] = 0.04 * np.array([[0, 1, 2, 3, 4, 5, 6, 7] * 2])
    case["most"] = 5.0
    _, _, facing, _ = laid(case)
    looks = facing.limit >= 0.0
    assert 0 < looks.sum() < 16
    # Most are next to one that fires a turn before, whose sound is 13.72 m ahead: half that way and what is read.
    assert np.median(facing.limit[looks]) == pytest.approx(0.5 * (10.0 + 0.04 * SPEED), abs=0.3)
    counts = facing.nearest[looks] < math.inf
    assert 0.2 < counts.mean() < 0.8
    assert np.median(facing.nearest[looks][counts]) == pytest.approx(0.5 * (0.2 + 0.04 * SPEED), abs=0.3)
    assert not np.diagonal(facing.hears).any()
    assert facing.hears.sum() < 0.2 * facing.hears.size


def test_the_first_free_sound_is_heard():
    """Three listeners of a row: the first sound is free; the second one is; the last of a full batch is not."""
    sounds = acoustics.Sounds(
        np.array([0, 2, 4, 7]), np.array([1.0, 2.0, 1.5, 2.5, 0.5, 0.7, 0.8]), np.array([3, 5, 4, 6, 2, 7, 8])
    )
    begin, is_done, heard = np.array([0, 2, 4]), np.zeros(3, dtype=np.bool_), np.full((1, 3), np.inf)
    assert acoustics.lines_wanted(sounds, begin, 2, is_done) == 6
    acoustics.take_free(sounds, begin, 2, np.array([True, True, False, True, False, False]), is_done, heard)
    assert heard.tolist() == [[1.0, 2.5, np.inf]]
    assert is_done.tolist() == [True, True, False]
    assert begin[2] == 6
    assert acoustics.lines_wanted(sounds, begin, 2, is_done) == 1
    begin[2] = 7
    assert acoustics.lines_wanted(sounds, begin, 2, is_done) == 0
    assert is_done.all()


@pytest.mark.parametrize("batch", [1, 3])
def test_lines_begin_before_the_surface_and_end_at_the_emitter(batch):
    case = some_case(3)
    (listeners, emitters, facing, surfaces), sounds, _ = sounds_of(case)
    off, rows = 0.01, len(case["half"])
    begin = sounds.first[:-1].copy()
    begin[0] += 1
    count = acoustics.lines_wanted(sounds, begin, batch, facing.is_done)
    row, carrier = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    lines = acoustics.Lines(row, np.empty((count, 3)), np.empty((count, 2)), carrier)
    acoustics.lay_lines(listeners, emitters, facing, surfaces, sounds, begin, batch, off, lines)
    at = 0
    for n in range(rows):
        for i in range(n * case["each"], (n + 1) * case["each"]):
            for number in sounds.number[begin[i] : min(begin[i] + batch, sounds.first[i + 1])]:
                emitter, way_of = divmod(int(number), len(case["fan"]) + 1)
                place = np.array(end_of(case, i, way_of - 1) if way_of else case["poses"][i, :2])
                back = case["poses"][i, :2] - place
                way = math.hypot(*back)
                start = place + back * min(off / way, 1.0) if way else place
                assert lines.poses[at, :2] == pytest.approx(start, abs=1e-12)
                assert lines.poses[at, :2] + lines.ahead[at] == pytest.approx(
                    case["emitters"][n, emitter, :2], abs=1e-12
                )
                assert lines.poses[at, 2] == math.atan2(lines.ahead[at, 1], lines.ahead[at, 0])
                assert lines.carrier[at] == case["body"][n, emitter]
                assert lines.row[at] == n
                at += 1
    assert at == count
