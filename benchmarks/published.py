"""Figures of peers that are not in the package index, and how they are brought to this machine.

They were measured by the project on one 2-core machine, headless, in a 50 m office of its own with 181 beams of 8 m
(`PEERS.md`). That office is not the one built here, so such a ratio is an estimate: it is scaled by how fast the plain
traversal runs here against there, and the table says so.
"""

from __future__ import annotations

import attrs
import numpy as np

__all__ = ["FLEETS", "PLAIN_FLOOR", "PLAIN_THERE", "RAYS", "Published", "here"]

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


FLEETS: dict[int, tuple[Published, ...]] = {
    1: (
        Published(name="Stage 4.3", figure=10_200.0, computes="office, 181 beams and 16 sonars without cones"),
        Published(name="f1tenth_gym", figure=27_800.0, computes="office, a distance field; no sonars"),
    ),
    10: (
        Published(name="Stage 4.3", figure=18_700.0, computes="office; robots see one another"),
        Published(name="f1tenth_gym", figure=8_200.0, computes="office, a distance field"),
    ),
    100: (
        Published(name="Stage 4.3", figure=11_200.0, computes="office; robots see one another"),
        Published(name="f1tenth_gym", figure=990.0, computes="office, a distance field"),
    ),
    1000: (Published(name="Stage 4.3", figure=8_000.0, computes="office; robots see one another"),),
}
"""Robot-steps a second, by number of robots."""

RAYS: dict[str, tuple[Published, ...]] = {
    "office": (
        Published(name="range_libc, Bresenham", figure=6.8e6, computes="approximate"),
        Published(name="range_libc, ray marching", figure=15e6, computes="approximate"),
        Published(name="range_libc, CDDT", figure=4.4e6, computes="approximate"),
        Published(name="f1tenth_gym", figure=5.8e6, computes="a distance field, approximate"),
    ),
}
"""Rays a second on 5 cm cells, 1000 x 1000."""


def here(figure: float, plain_here: tuple[float, ...]) -> tuple[float, ...]:
    """What a published figure would be on this machine, by the plain traversal in each round of this run."""
    return tuple((figure * np.array(plain_here) / PLAIN_THERE).tolist())
