"""Whatever is read, it ends with a result or with an error of amorsim's own, within 10 s and 1 GB.

Of 20,000 inputs each. One that fails is tried again alone as `tests.fuzz.harness` tells.
"""

from __future__ import annotations

import random
import re
import sys
from pathlib import Path

import pytest

from tests.fuzz.inputs import FUZZERS, Faulty

COUNT = 20_000
SEED = 12


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="limits are set as Linux has them")
@pytest.mark.parametrize("name", [name for name in FUZZERS if name != "faulty"])
def test_every_input_ends_with_a_result_or_a_message(name: str, tmp_path: Path) -> None:
    from tests.fuzz.harness import fuzz

    found = fuzz(name, tmp_path, COUNT, SEED)
    assert not found, f"{len(found)} of {COUNT} inputs of {name}, seed {SEED}:\n" + "\n\n".join(found[:20])


@pytest.mark.skipif(sys.platform != "linux", reason="limits are set as Linux has them")
@pytest.mark.parametrize("name", ["maps", "bitmaps"])
def test_a_few_hundred_damaged_maps(name: str, tmp_path: Path) -> None:
    from tests.fuzz.harness import fuzz

    assert fuzz(name, tmp_path, 300, SEED) == []


@pytest.mark.skipif(sys.platform != "linux", reason="limits are set as Linux has them")
def test_the_fuzzers_tell_what_goes_wrong(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from tests.fuzz import harness

    monkeypatch.setattr(harness, "_COMPILING", 1.0)
    monkeypatch.setattr(harness, "SECONDS", 1.0)
    found = "\n".join(harness.fuzz("faulty", tmp_path, 12, SEED))
    assert "took more than 1 s of processor time" in found
    assert "was ended by SIGKILL" in found
    assert "ZeroDivisionError" in found
    assert "MemoryError" in found
    expected = [Faulty.HOW[random.Random(f"{SEED} faulty {number}").randrange(6)] for number in range(12)]
    assert set(expected) == set(Faulty.HOW)
    wrong = {number for number, how in enumerate(expected) if how not in ("well", "refused")}
    assert {int(number) for number in re.findall(r"^input (\d+) ", found, re.MULTILINE)} == wrong
