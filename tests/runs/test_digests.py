"""All bundled scenarios compute, bit by bit, what they computed before; see `tests/golden/digests.py`."""

from __future__ import annotations

import json

import pytest

from tests.golden.digests import KEPT, MAPS, SCENARIOS, SEEDS, digests_of, rays_of

KEPT_DIGESTS = json.loads(KEPT.read_text(encoding="utf-8"))


def _mark(name: str, seed: int) -> pytest.MarkDecorator:
    return pytest.mark.nightly if name == "swarm" and seed != SEEDS[0] else pytest.mark.long


@pytest.mark.parametrize(
    ("name", "seed"), [pytest.param(name, seed, marks=_mark(name, seed)) for name in SCENARIOS for seed in SEEDS]
)
def test_a_scenario_computes_the_same_bits(name: str, seed: int) -> None:
    found = digests_of(name, seed)
    assert found["alone: 0"] == found["eight: 0"] == found["eight, two threads: 0"]
    assert found["eight"] == found["eight, two threads"]
    assert found == KEPT_DIGESTS[f"{name}, seed {seed}"]


@pytest.mark.long
@pytest.mark.parametrize("name", MAPS)
def test_rays_have_the_same_bits(name: str) -> None:
    assert rays_of(name) == KEPT_DIGESTS["rays"][name]
