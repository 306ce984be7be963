"""Whatever is read, it ends with a result or with an error of amorsim's own, within 10 s and 1 GB.

The readers of maps and of other programs' files get 200,000 inputs together, those of what runs, studies and recordings
leave as many as a minute is enough for, all others 20,000 each. One that fails is
tried again alone as `tests.fuzz.harness` tells.
"""

from __future__ import annotations

import random
import re
import sys
from pathlib import Path

import pytest

from tests.fuzz.inputs import FUZZERS, Faulty

COUNT = 10_000
SEED = 12
# As many as a minute is enough for: of what takes longer, fewer.
READERS = {
    "line_worlds": 26_000,
    "bitmaps": 22_000,
    "yaml": 30_000,
    "map": 65_000,
    "geojson": 4_500,
    "maz": 28_000,
    "svg": 8_000,
    "dxf": 1_200,
    "stage": 3_000,
    "mobilesim": 10_000,
    "khepera": 2_300,
}
OTHERS = dict.fromkeys(("scenarios", "numbers", "tracks"), COUNT)
CALLS = {"api": 10_000}  # of all that is public
# What runs, studies and recordings leave: a minute, too.
RECORDED = {"runs": 1_500, "chunks": 1_500, "logs": 3_000}
EVERY = READERS | OTHERS | RECORDED | CALLS


def test_readers_get_two_hundred_thousand_inputs() -> None:
    assert sum(READERS.values()) >= 200_000
    assert set(EVERY) | {"maps", "faulty"} == set(FUZZERS)


def check(name: str, count: int, folder: Path) -> None:
    from tests.fuzz.harness import fuzz

    found = fuzz(name, folder, count, SEED)
    assert not found, f"{len(found)} of {count} inputs of {name}, seed {SEED}:\n" + "\n\n".join(found[:20])


@pytest.mark.nightly
@pytest.mark.skipif(sys.platform != "linux", reason="limits are set as Linux has them")
@pytest.mark.parametrize(("name", "count"), EVERY.items())
def test_every_input_ends_with_a_result_or_a_message(name: str, count: int, tmp_path: Path) -> None:
    check(name, count, tmp_path)


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="limits are set as Linux has them")
@pytest.mark.parametrize(("name", "count"), EVERY.items())
def test_one_in_thirty_inputs_ends_with_a_result_or_a_message(name: str, count: int, tmp_path: Path) -> None:
    check(name, count // 30, tmp_path)


@pytest.mark.skipif(sys.platform != "linux", reason="limits are set as Linux has them")
@pytest.mark.parametrize("name", ["maps", "bitmaps", "api"])
def test_some_inputs(name: str, tmp_path: Path) -> None:
    from tests.fuzz.harness import fuzz

    assert fuzz(name, tmp_path, 60, SEED) == []


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="limits are set as Linux has them")
def test_the_fuzzers_tell_what_goes_wrong(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from tests.fuzz import harness

    count, seed = 6, 98  # each fault once; a process has to be started for few of them
    monkeypatch.setattr(harness, "_COMPILING", 0.3)
    monkeypatch.setattr(harness, "SECONDS", 0.3)
    found = "\n".join(harness.fuzz("faulty", tmp_path, count, seed))
    assert "took more than 0.3 s of processor time" in found
    assert "was ended by SIGKILL" in found
    assert "ZeroDivisionError" in found
    assert "MemoryError" in found
    expected = [Faulty.HOW[random.Random(f"{seed} faulty {number}").randrange(6)] for number in range(count)]
    assert set(expected) == set(Faulty.HOW)
    wrong = {number for number, how in enumerate(expected) if how not in ("well", "refused")}
    assert {int(number) for number in re.findall(r"^input (\d+) ", found, re.MULTILINE)} == wrong
