"""Runs every example of docs/examples and writes what it prints beside it, as ``<name>.out``.

Look at the difference before committing it: a test holds the examples to these files::

    python tools/make_example_outputs.py
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

__all__ = ["EXAMPLES", "output_of"]

EXAMPLES = Path(__file__).resolve().parents[1] / "docs" / "examples"


def output_of(example: Path) -> str:
    """What an example prints, run in a folder of its own."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, str(example)], cwd=folder, check=True, capture_output=True, encoding="utf-8"
        )
    return done.stdout


if __name__ == "__main__":
    for path in sorted(EXAMPLES.glob("*.py")):
        path.with_suffix(".out").write_text(output_of(path), encoding="utf-8")
