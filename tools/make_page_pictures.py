"""Makes the pictures that pages end in: runs a page as its reader and the tests do, and keeps what it leaves.

They are looked at and not compared, so make them again only where they should look different::

    python tools/make_page_pictures.py [PAGE ...]
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tools")]
from make_pictures import PICTURES, save_small  # noqa: E402 - beside us, not installed

from tests.first_hour.conftest import Page, blocks_of  # noqa: E402

__all__ = ["make"]

# Of each page, the picture that it leaves.
LEFT = {
    "how-to/a-robot-of-your-own": "first/picture.png",
    "how-to/come-from-another-simulator": "hall-run/picture.png",
    "how-to/compare-and-report": "comparison/comparison.png",
    "how-to/plan-a-path": "rooms.png",
    "how-to/write-a-planner": "plan.png",
    "how-to/write-an-estimator": "run/picture.png",
    "tutorials/from-a-log-to-a-map": "monday-map/map.pgm",
    "tutorials/from-a-question-to-a-figure": "slip.png",
    "tutorials/from-here-to-there": "plan.png",
}


def make(page: str) -> None:
    """Run a page, and write its picture among those of the docs."""
    with pytest.MonkeyPatch.context() as monkeypatch, tempfile.TemporaryDirectory() as folder:
        monkeypatch.chdir(folder)
        monkeypatch.syspath_prepend(folder)
        reader = Page(monkeypatch)
        for block in blocks_of(ROOT / "docs" / f"{page}.md"):
            reader.run(block)
        save_small(Path(LEFT[page]), PICTURES / f"{Path(page).name}.png", width=900, colours=64)


if __name__ == "__main__":
    for name in sys.argv[1:] or LEFT:
        make(name)
