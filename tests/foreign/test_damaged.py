"""A few damaged files of every kind: each ends with a scenario or a message, and soon. Many are tried in `fuzz`."""

from __future__ import annotations

import random
import time
import warnings

import pytest

from amorsim.core.errors import AmorsimError
from tests.fuzz.foreign import FOREIGN


@pytest.mark.parametrize("name", FOREIGN)
def test_damaged_files_end_with_a_scenario_or_a_message(name: str, tmp_path) -> None:
    warnings.simplefilter("ignore")
    fuzzer = FOREIGN[name](tmp_path)
    read = 0
    for number in range(60):
        begin = time.process_time()
        try:
            fuzzer.attempt(random.Random(f"12 {name} {number}"))
            read += 1
        except AmorsimError:
            pass
        assert time.process_time() - begin < 10.0, fuzzer.said
    assert 0 < read < 60
