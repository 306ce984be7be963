"""What small scenarios wrote once, they write again; `tests/golden/regenerate.py` makes the kept files."""

from __future__ import annotations

from pathlib import Path

import pytest

from amorsim.runs.compare import first_difference
from tests.golden.regenerate import FOLDER, SCENARIOS, run_scenario, tables


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_scenario_writes_what_was_kept(name: str, tmp_path: Path) -> None:
    run_scenario(name, tmp_path / "run")
    kept = FOLDER / name / "expected"
    assert tables(tmp_path / "run").keys() == tables(kept).keys()
    # Another processor may differ in the last bits, and so in the last digit that is written.
    difference = first_difference(kept, tmp_path / "run", dt=0.1)
    assert difference is None or difference.is_small, str(difference)
