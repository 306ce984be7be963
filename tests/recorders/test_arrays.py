import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.recorders.arrays import Arrays
from amorsim.testing import check_component
from tests.simulation.test_beliefs import Counting, scenario


def test_beliefs_are_written_at_their_times(tmp_path):
    given = scenario(Counting())
    given = attrs.evolve(given, recording=am.Recording(also=[Arrays(every=0.25)]))
    am.run(given, tmp_path / "run", replicas=2, duration=1.0)
    files = sorted((tmp_path / "run" / "beliefs" / "who").glob("*.npz"))
    assert [int(file.stem) for file in files] == [0, 3, 5, 8, 10]
    with np.load(files[1]) as found:
        assert found["large"].shape == (2, 65)
        assert found["count"].tolist() == [4.0, 4.0]
        assert found["time"].tolist() == pytest.approx([0.3, 0.3])
        assert found["robot"].tolist() == ["rover", "rover"]
        assert found["replica"].tolist() == [0, 1]


def test_the_same_run_gives_the_same_bytes(tmp_path):
    given = attrs.evolve(scenario(Counting()), recording=am.Recording(also=[Arrays()]))
    written = []
    for name in ("one", "two"):
        am.run(given, tmp_path / name, duration=0.2)
        written.append((tmp_path / name / "beliefs" / "who" / "000000000.npz").read_bytes())
    assert written[0] == written[1]


def test_it_keeps_the_contract():
    check_component(Arrays())


def test_a_file_names_it():
    assert am.Recording(also=[Arrays(every=2.0)]).also[0].every == 2.0
    with pytest.raises(ValueError, match="every"):
        Arrays(every=0.0)
