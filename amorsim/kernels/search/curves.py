"""The shortest curves of cars: words of arcs of least radius and straight lines, forwards or also backwards.

A word is at most five pieces, rows (bend, length) of an array (5, 2), in units of the least turning radius: bend is 1
to the left, -1 to the right, 0 straight on; a negative length is driven backwards. The goal of a word is seen from its
start: `x` ahead, `y` to the left, in radii, and the heading `phi`.

L. E. Dubins, "On curves of minimal length with a constraint on average curvature", American Journal of Mathematics 79,
1957. J. A. Reeds and L. A. Shepp, "Optimal paths for a car that goes both forwards and backwards", Pacific Journal of
Mathematics 145, 1990; their section 8 gives the words below, numbered as there.
"""

from __future__ import annotations

import math

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel, part

__all__ = ["MOST_WORDS", "dubins_words", "moved", "reeds_shepp_words", "trace_word", "word_length"]


MOST_WORDS = 48
"""No goal has more words than this."""

_TURN = 2.0 * math.pi
_HALF = 0.5 * math.pi
_TINY = 1e-10
_L, _S, _R = 1.0, 0.0, -1.0


@part
def _positive(angle: float) -> float:
    """The angle in [0, 2 pi); 0 if it is less than a full turn by rounding alone."""
    angle = angle % _TURN
    return 0.0 if angle > _TURN - 1e-11 else angle


@part
def _wrapped(angle: float) -> float:
    """The angle in (-pi, pi]."""
    angle = angle % _TURN
    return angle - _TURN if angle > math.pi else angle


@part
def word_length(word: Array) -> float:
    """The length of a word, in radii."""
    total = 0.0
    for i in range(word.shape[0]):
        total += abs(word[i, 1])
    return total


@part
def _write3(words: Array, at: int, bends: tuple[float, float, float], t: float, p: float, q: float) -> int:
    """Write a word of three pieces of lengths t, p and q [radii]; returns how many words there are then."""
    words[at] = 0.0
    words[at, 0, 0], words[at, 1, 0], words[at, 2, 0] = bends
    words[at, 0, 1], words[at, 1, 1], words[at, 2, 1] = t, p, q
    return at + 1


@kernel
def dubins_words(x: float, y: float, phi: float, words: Array) -> int:
    """Write the words of Dubins, (n, 5, 2), that lead forwards to a goal; returns how many, at most 6."""
    d = math.sqrt(x * x + y * y)
    theta = math.atan2(y, x)
    a, b = -theta, phi - theta
    sa, ca, sb, cb = math.sin(a), math.cos(a), math.sin(b), math.cos(b)
    cab = math.cos(a - b)
    n = 0
    # Between circles of one side the line goes as from centre to centre: by its two parts, which keep a short one.
    ahead, aside = d + sa - sb, cb - ca
    way = math.atan2(aside, ahead)
    line = math.sqrt(ahead * ahead + aside * aside)
    n = _write3(words, n, (_L, _S, _L), _positive(way - a), line, _positive(b - way))
    ahead, aside = d - sa + sb, ca - cb
    way = math.atan2(aside, ahead)
    line = math.sqrt(ahead * ahead + aside * aside)
    n = _write3(words, n, (_R, _S, _R), _positive(a - way), line, _positive(way - b))
    square = d * d - 2.0 + 2.0 * cab - 2.0 * d * (sa + sb)
    if square >= 0.0:
        p = math.sqrt(square)
        way = math.atan2(ca + cb, d - sa - sb) - math.atan2(2.0, p)
        n = _write3(words, n, (_R, _S, _L), _positive(a - way), p, _positive(b - way))
    square = d * d - 2.0 + 2.0 * cab + 2.0 * d * (sa + sb)
    if square >= 0.0:
        p = math.sqrt(square)
        way = math.atan2(-ca - cb, d + sa + sb) - math.atan2(-2.0, p)
        n = _write3(words, n, (_L, _S, _R), _positive(way - a), p, _positive(way - b))
    # Three circles in touch: by the way between the outer ones, which a cosine near 1 would not keep where it is short.
    ahead, aside = d - sa + sb, ca - cb
    way = math.sqrt(ahead * ahead + aside * aside)
    if way <= 4.0:
        p = _TURN - 2.0 * math.asin(0.25 * way)
        t = _positive(a - math.atan2(aside, ahead) + 0.5 * p)
        n = _write3(words, n, (_R, _L, _R), t, p, _positive(a - b - t + p))
    ahead, aside = d + sa - sb, cb - ca
    way = math.sqrt(ahead * ahead + aside * aside)
    if way <= 4.0:
        p = _TURN - 2.0 * math.asin(0.25 * way)
        t = _positive(math.atan2(aside, ahead) - a + 0.5 * p)
        n = _write3(words, n, (_L, _R, _L), t, p, _positive(b - a - t + p))
    return n


@part
def _put(
    words: Array, at: int, bends: tuple[float, float, float, float, float], way: int, lengths: tuple[float, ...]
) -> int:
    """Write a word; `way` tells whether its directions (1), its sides (2) or both (3) are exchanged."""
    side = -1.0 if way >= 2 else 1.0
    direction = -1.0 if way % 2 == 1 else 1.0
    for i in range(5):
        words[at, i, 0] = side * bends[i]
        words[at, i, 1] = direction * lengths[i]
    return at + 1


@part
def _tau_omega(u: float, v: float, xi: float, eta: float, phi: float) -> tuple[float, float]:
    """The first and the last turn [rad] of the words 8.7 and 8.8, from the two turns between them."""
    delta = _wrapped(u - v)
    a = math.sin(u) - math.sin(delta)
    b = math.cos(u) - math.cos(delta) - 1.0
    tau = math.atan2(eta * a - xi * b, xi * a + eta * b)
    if 2.0 * (math.cos(delta) - math.cos(v) - math.cos(u)) + 3.0 < 0.0:
        tau += math.pi
    tau = _wrapped(tau)
    return tau, _wrapped(tau - u + v - phi)


@part
def _forward_words(x: float, y: float, phi: float, way: int, words: Array, n: int) -> int:
    """The words whose pieces come in the order of the formulas; returns how many words there are then."""
    sin, cos = math.sin(phi), math.cos(phi)
    # Centres of the goal's circle on the start's side, and on the other, from that of the start's.
    xi, eta = x - sin, y - 1.0 + cos
    rho, theta = math.sqrt(xi * xi + eta * eta), math.atan2(eta, xi)
    # 8.1: L+ S+ L+
    if theta >= -_TINY:
        v = _wrapped(phi - theta)
        if v >= -_TINY:
            n = _put(words, n, (_L, _S, _L, _S, _S), way, (theta, rho, v, 0.0, 0.0))
    # 8.3: L+ R- L
    if rho <= 4.0:
        u = -2.0 * math.asin(0.25 * rho)
        t = _wrapped(theta + 0.5 * u + math.pi)
        v = _wrapped(phi - t + u)
        if t >= -_TINY:
            n = _put(words, n, (_L, _R, _L, _S, _S), way, (t, u, v, 0.0, 0.0))
    # 8.9: L+ R- S- L-
    if rho >= 2.0:
        r = math.sqrt(rho * rho - 4.0)
        t = _wrapped(theta + math.atan2(r, -2.0))
        v = _wrapped(phi - _HALF - t)
        if t >= -_TINY and v <= _TINY:
            n = _put(words, n, (_L, _R, _S, _L, _S), way, (t, -_HALF, 2.0 - r, v, 0.0))
    xi, eta = x + sin, y - 1.0 - cos
    rho, theta = math.sqrt(xi * xi + eta * eta), math.atan2(eta, xi)
    # 8.2: L+ S+ R+
    if rho >= 2.0:
        u = math.sqrt(rho * rho - 4.0)
        t = _wrapped(theta + math.atan2(2.0, u))
        v = _wrapped(t - phi)
        if t >= -_TINY and v >= -_TINY:
            n = _put(words, n, (_L, _S, _R, _S, _S), way, (t, u, v, 0.0, 0.0))
    # 8.7: L+ R+ L- R-
    quarter = 0.25 * (2.0 + rho)
    if quarter <= 1.0:
        u = math.acos(quarter)
        t, v = _tau_omega(u, -u, xi, eta, phi)
        if t >= -_TINY and v <= _TINY:
            n = _put(words, n, (_L, _R, _L, _R, _S), way, (t, u, -u, v, 0.0))
    # 8.8: L+ R- L- R+
    cosine = (20.0 - rho * rho) / 16.0
    if 0.0 <= cosine <= 1.0:
        u = -math.acos(cosine)
        t, v = _tau_omega(u, u, xi, eta, phi)
        if t >= -_TINY and v >= -_TINY:
            n = _put(words, n, (_L, _R, _L, _R, _S), way, (t, u, u, v, 0.0))
    if rho >= 2.0:
        # 8.10: L+ R- S- R-
        t = math.atan2(xi, -eta)
        v = _wrapped(t + _HALF - phi)
        if t >= -_TINY and v <= _TINY:
            n = _put(words, n, (_L, _R, _S, _R, _S), way, (t, -_HALF, 2.0 - rho, v, 0.0))
        # 8.11: L+ R- S- L- R+
        u = 4.0 - math.sqrt(rho * rho - 4.0)
        if u <= _TINY:
            t = _wrapped(math.atan2((4.0 - u) * xi - 2.0 * eta, -2.0 * xi + (u - 4.0) * eta))
            v = _wrapped(t - phi)
            if t >= -_TINY and v >= -_TINY:
                n = _put(words, n, (_L, _R, _S, _L, _R), way, (t, -_HALF, u, -_HALF, v))
    return n


@part
def _backward_words(x: float, y: float, phi: float, way: int, words: Array, n: int) -> int:
    """The words whose pieces come in the reverse order, from the goal to the start."""
    sin, cos = math.sin(phi), math.cos(phi)
    xb, yb = x * cos + y * sin, x * sin - y * cos
    xi, eta = xb - sin, yb - 1.0 + cos
    rho, theta = math.sqrt(xi * xi + eta * eta), math.atan2(eta, xi)
    if rho <= 4.0:
        u = -2.0 * math.asin(0.25 * rho)
        t = _wrapped(theta + 0.5 * u + math.pi)
        v = _wrapped(phi - t + u)
        if t >= -_TINY:
            n = _put(words, n, (_L, _R, _L, _S, _S), way, (v, u, t, 0.0, 0.0))
    if rho >= 2.0:
        r = math.sqrt(rho * rho - 4.0)
        t = _wrapped(theta + math.atan2(r, -2.0))
        v = _wrapped(phi - _HALF - t)
        if t >= -_TINY and v <= _TINY:
            n = _put(words, n, (_L, _S, _R, _L, _S), way, (v, 2.0 - r, -_HALF, t, 0.0))
    xi, eta = xb + sin, yb - 1.0 - cos
    rho = math.sqrt(xi * xi + eta * eta)
    if rho >= 2.0:
        t = math.atan2(xi, -eta)
        v = _wrapped(t + _HALF - phi)
        if t >= -_TINY and v <= _TINY:
            n = _put(words, n, (_R, _S, _R, _L, _S), way, (v, 2.0 - rho, -_HALF, t, 0.0))
    return n


@kernel
def reeds_shepp_words(x: float, y: float, phi: float, words: Array) -> int:
    """Write words of Reeds and Shepp that lead to a goal, (n, 5, 2), the shortest among them; returns how many."""
    n = 0
    phi = _wrapped(phi)
    for way in range(4):
        ahead = -x if way % 2 == 1 else x
        aside = -y if way >= 2 else y
        turn = -phi if way in (1, 2) else phi
        n = _forward_words(ahead, aside, turn, way, words, n)
        n = _backward_words(ahead, aside, turn, way, words, n)
    return n


@part
def moved(x: float, y: float, heading: float, ahead: float, turn: float) -> tuple[float, float, float]:
    """The pose after an arc of a length [m] that turns by an angle [rad]."""
    half = 0.5 * turn
    chord = ahead if half == 0.0 else ahead * math.sin(half) / half
    return x + chord * math.cos(heading + half), y + chord * math.sin(heading + half), heading + turn


@kernel
def trace_word(x: float, y: float, heading: float, word: Array, radius: float, spacing: float, out: Array) -> int:
    """Write poses along a word, at most `spacing` [m] apart, (M, 3), with the ends of its pieces; returns how many.

    The first is the start (x, y, heading). Writes as many as there is room for.
    """
    count = 0
    if out.shape[0] > 0:
        out[0, 0], out[0, 1], out[0, 2] = x, y, heading
        count = 1
    for i in range(word.shape[0]):
        length = word[i, 1] * radius
        if length == 0.0:
            continue
        bend = word[i, 0] / radius
        pieces = max(1, math.ceil(abs(length) / spacing - 1e-9))
        ahead, turn = 0.0, 0.0
        for k in range(1, pieces + 1):
            ahead = length * (k / pieces)
            turn = bend * ahead
            if count < out.shape[0]:
                out[count, 0], out[count, 1], out[count, 2] = moved(x, y, heading, ahead, turn)
                count += 1
        x, y, heading = moved(x, y, heading, ahead, turn)
    return count
