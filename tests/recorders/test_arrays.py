import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.recorders.arrays import Arrays
from amorsim.testing import check_component
from tests.simulation.test_beliefs import Counting, scenario


def written(folder, recorder, replicas, duration):
    """A run's arrays: the files in order."""
    sim = am.Simulation(scenario(Counting()), replicas=replicas)
    folder.mkdir()
    recorder.open(am.RunInfo(folder, sim.dt, sim.replicas, True), sim.frames())
    for _ in range(sim.steps_of(duration)):
        sim.step()
        recorder.write(sim.frames(), [])
    recorder.close()
    return sorted((folder / "beliefs" / "who").glob("*.npz"))


def test_beliefs_are_written_at_their_times(tmp_path):
    files = written(tmp_path / "run", Arrays(every=0.25), 2, 1.0)
    assert [int(file.stem) for file in files] == [0, 3, 5, 8, 10]
    with np.load(files[1]) as found:
        assert found["large"].shape == (2, 65)
        assert found["count"].tolist() == [4.0, 4.0]
        assert found["time"].tolist() == pytest.approx([0.3, 0.3])
        assert found["robot"].tolist() == ["rover", "rover"]
        assert found["replica"].tolist() == [0, 1]


def test_the_same_run_gives_the_same_bytes(tmp_path):
    one, two = (written(tmp_path / name, Arrays(), 1, 0.2) for name in ("one", "two"))
    assert one[0].read_bytes() == two[0].read_bytes()


def test_beliefs_of_some_are_written_alone(tmp_path):
    made = scenario(Counting())
    both = attrs.evolve(made.robots[0], estimators={"who": Counting(), "other": Counting()})
    sim = am.Simulation(attrs.evolve(made, robots=[both]))
    info = am.RunInfo(tmp_path, sim.dt, sim.replicas, True)
    Arrays(of=("other",)).open(info, sim.frames())
    (file,) = (tmp_path / "beliefs").rglob("*.npz")
    assert file.parent.name == "other"
    with pytest.raises(am.RunError, match=r"'othr' has no beliefs; those that have: other, who. Did you mean 'other'"):
        Arrays(of=("othr",)).open(info, sim.frames())


def test_it_keeps_the_contract():
    check_component(Arrays())


def test_a_file_names_it():
    assert am.Recording(also=[Arrays(every=2.0)]).also[0].every == 2.0
    with pytest.raises(ValueError, match="every"):
        Arrays(every=0.0)
