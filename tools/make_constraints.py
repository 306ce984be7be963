"""Writes ``constraints.txt``: the versions of all packages that are installed here, with which the tests pass.

Run it in an environment with nothing but ``.[dev]``, after all tests.
"""

from __future__ import annotations

import re
from importlib import metadata
from pathlib import Path

HEAD = "# Versions with which all tests pass; see README.md. Written by tools/make_constraints.py.\n"
OWN = ("amorsim", "amorsim-example", "pip", "setuptools", "wheel")


def main() -> None:
    """Write the file."""
    found = {re.sub(r"[-_.]+", "-", each.metadata["Name"]).lower(): each.version for each in metadata.distributions()}
    lines = [f"{name}=={version}\n" for name, version in sorted(found.items()) if name not in OWN]
    (Path(__file__).parents[1] / "constraints.txt").write_text(HEAD + "".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
