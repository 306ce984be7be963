"""Figures of peers that are not in the package index, and how they are brought to this machine.

They were measured by the project on one 2-core machine, headless, in a 50 m office of its own with 181 beams of 8 m
(`PEERS.md`). That office is not the one built here, so such a ratio is an estimate: it is scaled by how fast the plain
traversal runs here against there, and the table says so.
"""

from __future__ import annotations

import attrs
import numpy as np

__all__ = ["BESIDE", "PLAIN_FLOOR", "PLAIN_THERE", "RAYS", "Published", "here"]

PLAIN_THERE = 6.8e6
"""Rays a second of the plain traversal on 5 cm cells of that machine: the middle of 6.3 to 7.3 million."""
PLAIN_FLOOR = 5e6
"""What the plain traversal must do on such a machine, so that nobody wins by slowing the yardstick."""


@attrs.frozen(kw_only=True)
class Published:
    """A peer's figure on that machine."""

    name: str
    figure: float
    computes: str


RAYS: dict[str, tuple[Published, ...]] = {
    "office": (
        Published(name="range_libc, Bresenham", figure=6.8e6, computes="approximate"),
        Published(name="range_libc, ray marching", figure=15e6, computes="approximate"),
        Published(name="range_libc, CDDT", figure=4.4e6, computes="approximate"),
    ),
}
"""Rays a second on 5 cm cells, 1000 x 1000."""

BESIDE = (
    "Stage and f1tenth_gym are not in the package index. Run next to amorsim on one machine, before its step became a "
    "schedule, they were ahead of it with one Pioneer in an office, by 1.3 and by 2.0, and in an open field by 1.5 and "
    "by 2.2. With 100 discs in an open field amorsim was ahead, by 17 and by 158.",
    "A fleet of ten models in Stage made about 5000 robot-steps a second there.",
    "With one Pioneer, a C++ program written on Box2D is ahead of amorsim by 1.3 in an office and by 7 in an open "
    "field; in a furnished office amorsim is, by 1.7, and with 100 discs in an open field by 4.5.",
    "range_libc's look-up table was 2.8 times as fast as amorsim on cells of 5 cm; it is approximate.",
)
"""What was measured next to amorsim on one machine in 2026, and is not measured here."""


def here(figure: float, plain_here: tuple[float, ...]) -> tuple[float, ...]:
    """What a published figure would be on this machine, by the plain traversal in each round of this run."""
    return tuple((figure * np.array(plain_here) / PLAIN_THERE).tolist())
