"""The first sound against a slow and obvious twin, that lists all sounds and sorts them."""

import math

import numpy as np
import pytest

from amorsim.kernels.sensing import acoustics as sounds

SPEED = 343.0


def within(pose, half, point):
    dx, dy = point[0] - pose[0], point[1] - pose[1]
    if dx == dy == 0.0:
        return True
    off = math.atan2(dy, dx) - pose[2]
    return abs(math.atan2(math.sin(off), math.cos(off))) <= half


def all_sounds(case, m):
    """(reading, number) of every sound that a receiver can hear, in order."""
    n = m // case["each"]
    found = []
    receiver = case["receivers"][m]
    for i, emitter in enumerate(case["emitters"][n]):
        if not case["fired"][n, i] or i == case["itself"][m]:
            continue
        ahead = SPEED * (case["fires"][n, i] - case["listens"][m])
        ends = [(None, math.dist(emitter[:2], receiver[:2]))]
        for point, way, on in zip(case["points"][m], case["ranges"][m], case["surface"][m], strict=True):
            reflects = math.isfinite(way) and on != case["carrier"][n, i]
            ends.append((point, way + math.dist(emitter[:2], point) if reflects else math.inf))
        for f, (point, way) in enumerate(ends):
            if point is None:
                fits = within(receiver, case["half"][m], emitter) and within(
                    emitter, case["emitter_half"][n, i], receiver
                )
            else:
                fits = math.isfinite(way) and within(emitter, case["emitter_half"][n, i], point)
            reading = 0.5 * (way + ahead)
            if fits and case["least"][m] <= reading <= case["most"][m]:
                found.append((reading, i * len(ends) + f))
    return sorted(found)


def some_case(seed, rows=3, each=4, count=5, fan=7):
    rng = np.random.default_rng(seed)
    m = rows * each
    case = {
        "each": each,
        "receivers": rng.uniform((-1, -1, -3), (1, 1, 3), (m, 3)),
        "half": rng.uniform(0.2, 1.5, m),
        "listens": rng.uniform(0.0, 0.002, m),
        "itself": rng.integers(-1, count, m),
        "emitters": rng.uniform((-1, -1, -3), (1, 1, 3), (rows, count, 3)),
        "emitter_half": rng.uniform(0.2, 1.5, (rows, count)),
        "fires": rng.uniform(0.0, 0.002, (rows, count)),
        "fired": rng.random((rows, count)) < 0.8,
        "least": np.full(m, 0.1),
        "most": np.full(m, 2.0),
    }
    ranges = rng.uniform(0.2, 2.0, (m, fan))
    case["ranges"] = np.where(rng.random(ranges.shape) < 0.2, np.inf, ranges)
    case["carrier"] = rng.integers(0, 3, (rows, count))
    case["surface"] = rng.integers(-1, 3, ranges.shape)
    case["fan"] = np.linspace(-1.0, 1.0, fan)
    case["points"] = np.empty((m, fan, 2))
    sounds.surface_points(case["receivers"], case["half"], case["fan"], case["ranges"], case["points"])
    return case


def test_points_are_where_rays_end():
    case = some_case(0)
    for m, (x, y, heading) in enumerate(case["receivers"]):
        for f, part in enumerate(case["fan"]):
            angle, way = heading + case["half"][m] * part, case["ranges"][m, f]
            if math.isfinite(way):
                expected = [x + way * math.cos(angle), y + way * math.sin(angle)]
                assert case["points"][m, f] == pytest.approx(expected, abs=1e-12)
            else:
                assert np.isinf(case["points"][m, f]).all()


def axes(poses, half_angle):
    out = np.empty((len(poses), 3))
    sounds.axes(poses, half_angle, out)
    return out


@pytest.mark.parametrize("batch", [1, 3])
@pytest.mark.parametrize("seed", range(6))
def test_sounds_come_in_order_until_there_are_none(seed, batch):
    case = some_case(seed)
    m = len(case["receivers"])
    after, after_which = np.full(m, -np.inf), np.full(m, -1, dtype=np.int64)
    heard, which, path = np.empty((m, batch)), np.empty((m, batch), dtype=np.int64), np.empty((m, batch, 4))
    emitters = case["emitters"]
    expected = [all_sounds(case, i) for i in range(m)]
    assert any(len(each) > 3 for each in expected)
    for turn in range(max(map(len, expected)) // batch + 1):
        sounds.first_sounds(
            case["receivers"],
            axes(case["receivers"], case["half"]),
            case["listens"],
            case["itself"],
            case["points"],
            case["ranges"],
            case["surface"],
            emitters,
            axes(emitters.reshape(-1, 3), case["emitter_half"].reshape(-1)).reshape(emitters.shape),
            case["carrier"],
            case["fires"],
            case["fired"],
            SPEED,
            case["least"],
            case["most"],
            after,
            after_which,
            heard,
            which,
            path,
        )
        for i, each in enumerate(expected):
            for b, place in enumerate(range(turn * batch, turn * batch + batch)):
                if place >= len(each):
                    assert which[i, b] == -1
                    assert heard[i, b] == math.inf
                    continue
                reading, number = each[place]
                assert which[i, b] == number
                assert heard[i, b] == pytest.approx(reading, rel=1e-14)
                emitter, f = divmod(number, case["points"].shape[1] + 1)
                start = case["points"][i, f - 1] if f else case["receivers"][i, :2]
                assert path[i, b].tolist() == [*start, *emitters[i // case["each"], emitter, :2]]
        # Who has heard everything stays silent.
        case["most"] = np.where(which[:, -1] < 0, -np.inf, case["most"])
        after, after_which = heard[:, -1].copy(), which[:, -1].copy()
