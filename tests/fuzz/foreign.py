"""Other programs' files, each wrong at random: what scenario loaders are tried with."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from random import Random

from PIL import Image

import amorsim as am
from amorsim.plugins.manager import make_registry
from tests.fuzz.damage import damaged

__all__ = ["FOREIGN"]

STAGE = """\
include "lab.inc"
resolution 0.05
interval_sim 100
quit_time 5
floorplan( size [6 4 1] bitmap "lab.png" pose [0 0 0 10] )
bot( name "a" pose [-2 0 0 0] localization "odom" )
bot( pose [2 0 0 180] drive "omni" ctrl "other" )
position( pose [0 -1 0 90] drive "car" wheelbase 0.3 odom_error [0.1 0 0 0.1] fiducial_return 2 )
model( name "box" pose [0 1 0 20] size [0.5 0.5 0.5] color "gray30"
  block( points 3 point[0] [0 0] point[1] [1 0] point[2] [0 1] ) )
zone( pose [1 1 0 0] size [1 1 0.1] ) window( size [1 1] ) gripper()
"""
INCLUDED = """\
define eye sensor( range [0 5] fov 30 noise [0.01 0.01 1] )
define bot position( size [0.4 0.3 0.2] origin [0.1 0 0 0] velocity_bounds [-1 1 0 0 0 0 -90 90]
  ranger( pose [0.1 0 0 0] eye( pose [0 0 0 90] ) eye() eye( samples 31 fov 180 ) )
  bumper( bcount 1 bpose[0] [0.2 0 0 0] )
  fiducial( range_max 3 ) ctrl "wander" )
"""
ARIA = """\
2D-Map
NumLines: 4
Resolution: 20
Cairn: RobotHome 1000 1500 90 "" ICON "Home"
Cairn: Goal 3000 2000 180 "" ICON "door"
Cairn: ForbiddenArea 0 0 30 "" ICON "pit" 2000 500 3000 1000
Cairn: Sim.BoxObstacle 0 0 0 "" ICON "box" 3200 200 3600 500
LINES
0 0 4000 0
4000 0 4000 3000
4000 3000 0 3000
0 3000 0 0
DATA
100 100
200 2000
"""
KHEPERA = (
    "1,0\nbrick\n0\nlamp\n0\ncork\n0\n" + "7ff," * 500 + "0," * 7500 + "0,300,300,30,1\n1,500,500,0,1\n2,700,700,0,0\n"
)


_NUMBER = re.compile(r"-?[0-9.]+")
_EXTREMES = (
    *("0", "-0", "-1", "1e-320", "1e-9", "0.001", "0.5", "17", "1000", "1e5", "1e6", "1e9", "-1e9", "1e10", "1e300"),
    *("nan", "inf", "1_0", "0x1f", "999999999", "123456789012345678901234567890", "", "x"),
)


class _Foreign:
    """Files of one kind, damaged, read as scenarios."""

    def __init__(self, folder: Path, name: str, text: str) -> None:
        self.path, self.text = folder / name, text
        self.said = ""
        self.registry = make_registry(entry_points=(), disabled="")
        (folder / "lab.inc").write_text(INCLUDED)
        Image.new("L", (30, 20), 255).save(folder / "lab.png")

    def attempt(self, rng: Random) -> None:
        """Damage the file, or what it includes, and read it."""
        text = self.text if rng.random() < 0.5 else _with_numbers(self.text, rng)
        data = damaged(text.encode(), rng) if text is self.text else text.encode()
        self.said = repr(data)
        self.path.write_bytes(data)
        if self.path.suffix == ".world" and self.text is STAGE:
            included = damaged(INCLUDED.encode(), rng, 2) if rng.random() < 0.5 else INCLUDED.encode()
            self.said += f" with {included!r}"
            self.path.with_name("lab.inc").write_bytes(included)
        am.load(self.path, registry=self.registry)


def _with_numbers(text: str, rng: Random) -> str:
    """The text with one to three numbers too large, too small or no whole ones."""
    for _ in range(rng.choice((1, 1, 2, 3))):
        number = rng.choice(list(_NUMBER.finditer(text)))
        text = text[: number.start()] + rng.choice(_EXTREMES) + text[number.end() :]
    return text


FOREIGN: dict[str, Callable[[Path], _Foreign]] = {
    "stage": lambda folder: _Foreign(folder, "lab.world", STAGE),
    "mobilesim": lambda folder: _Foreign(folder, "lab.map", ARIA),
    "khepera": lambda folder: _Foreign(folder, "maze.world", KHEPERA),
}
