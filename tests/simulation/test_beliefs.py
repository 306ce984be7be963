import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.analysis.run_files import RunFiles
from amorsim.contracts import LazyBeliefs
from amorsim.recorders.text import Text
from amorsim.runs.tables import read_columns
from amorsim.testing import check_component


@attrs.frozen(kw_only=True)
class Counting(am.Estimator):
    """Believes that it stands, and counts its updates."""

    scale: float = am.parameter(1.0, help="by which counts are multiplied")

    def start(self, context):
        return {"pose": context.pose.copy(), "count": np.zeros((context.rows, 1))}

    def update(self, robot, readings, command, elapsed, state, draws):
        state["count"] = state["count"] + 1.0
        return am.Estimate(state["pose"].copy(), np.zeros((robot.rows, 3, 3)))

    def beliefs(self, state):
        count = state["count"] * self.scale
        pair = np.concatenate((count, np.full_like(count, np.nan)), axis=1)
        return {
            "count": count[:, 0],
            "pair": pair,
            "table": np.stack((pair, pair + 1.0), axis=1),
            "even": state["count"][:, 0] % 2 == 0,
            "large": np.zeros((len(count), 65)),
        }


def scenario(estimator, scale=1.0):
    room = am.Map.from_segments([(-5, -5, 5, -5), (5, -5, 5, 5), (5, 5, -5, 5), (-5, 5, -5, -5)])
    robot = am.load_robot("khepera", name="rover", pose=am.Pose(), estimators={"who": estimator})
    return am.Scenario(map=room, robots=[robot])


def test_a_frame_has_the_beliefs_of_its_step():
    sim = am.Simulation(scenario(Counting(scale=2.0)), replicas=3)
    sim.step()
    beliefs = sim.frames()[0].beliefs["who"]
    np.testing.assert_array_equal(beliefs["count"], [4.0] * 3)  # the start counts too
    assert beliefs["table"].shape == (3, 2, 2)


def test_nobody_is_asked_who_has_none_and_none_before_somebody_asks():
    asked = []

    @attrs.frozen(kw_only=True)
    class Telling(Counting):
        def beliefs(self, state):
            asked.append(1)
            return super().beliefs(state)

    sim = am.Simulation(scenario(Telling()))
    frame = sim.frames()[0]
    sim.step()
    assert list(frame.beliefs) == ["who"]
    assert not asked
    assert "who" in sim.frames()[0].beliefs
    sim.frames()[0].beliefs["who"]
    assert len(asked) == 1
    with pytest.raises(am.AmorsimError, match="after their step"):
        frame.beliefs["who"]
    assert not am.Simulation(scenario(am.estimators.DeadReckoning())).frames()[0].beliefs


def test_asking_changes_no_bit():
    plain, asked = am.Simulation(scenario(Counting())), am.Simulation(scenario(Counting()))
    for _ in range(5):
        plain.step()
        asked.step()
        asked.frames()[0].beliefs["who"]
    assert plain.digest() == asked.digest()
    np.testing.assert_array_equal(plain.frames()[0].beliefs["who"]["pair"], asked.frames()[0].beliefs["who"]["pair"])


def test_a_snapshot_brings_them_back():
    sim = am.Simulation(scenario(Counting()))
    sim.step()
    kept = sim.snapshot()
    sim.step()
    assert sim.frames()[0].beliefs["who"]["count"][0] == 3.0
    sim.restore(kept)
    assert sim.frames()[0].beliefs["who"]["count"][0] == 2.0


def recorded(estimator, folder, steps=4, with_sensors=True):
    """What a text recorder writes of a few steps of two replicas."""
    sim = am.Simulation(scenario(estimator), replicas=2)
    recorder = Text()
    recorder.open(am.RunInfo(folder=folder, dt=sim.dt, replicas=[0, 1], with_sensors=with_sensors), sim.frames())
    for _ in range(steps):
        sim.step()
        recorder.write(sim.frames(), [])
    recorder.close()
    return folder / "beliefs" / "who.csv"


def test_small_ones_are_written(tmp_path):
    path = recorded(Counting(), tmp_path)
    header = path.read_text().splitlines()[0]
    assert header == "replica,time,robot,count,pair_0,pair_1,table_0_0,table_0_1,table_1_0,table_1_1,even"
    columns = read_columns(path, "beliefs/who", with_replicas=True)
    np.testing.assert_array_equal(columns["count"], np.repeat(np.arange(1.0, 6.0), 2))
    np.testing.assert_array_equal(columns["table_1_0"], columns["count"] + 1.0)
    assert np.isnan(columns["table_0_1"]).all()
    np.testing.assert_array_equal(columns["even"], np.repeat([0.0, 1.0, 0.0, 1.0, 0.0], 2))


def test_files_of_beliefs_are_read_as_arrays(tmp_path):
    folder = tmp_path / "run"
    plain = scenario(am.estimators.DeadReckoning())
    am.run(plain, folder, duration=4 * plain.dt, replicas=2)
    recorded(Counting(), folder)
    files = RunFiles(folder)
    assert files.believers == ["who"]
    found = files.arrays("beliefs/who")
    np.testing.assert_array_equal(found["count"], np.tile(np.arange(1.0, 6.0)[:, None], 2))
    assert found["table"].shape == (5, 2, 2, 2)
    np.testing.assert_array_equal(found["table"][:, :, 1, 0], found["count"] + 1.0)
    assert np.isnan(found["table"][..., 1]).all()


def test_they_are_left_out_with_the_sensors(tmp_path):
    assert not recorded(Counting(), tmp_path, with_sensors=False).exists()


def test_no_file_is_made_where_nothing_is_believed(tmp_path):
    assert not recorded(am.estimators.DeadReckoning(), tmp_path).exists()


@pytest.mark.parametrize(
    ("found", "problem"),
    [
        ([], "got a list"),
        ({"a b": np.zeros(1)}, "'a b'"),
        ({"n_1": np.zeros(1)}, "'n_1'"),
        ({"n": [0.0]}, "got list"),
        ({"n": np.zeros(1, dtype=np.float32)}, "float32"),
        ({"n": np.zeros(2)}, r"shape \(2,\)"),
        ({"n": np.array([np.inf])}, "got inf"),
    ],
)
def test_what_are_no_beliefs_is_refused(found, problem):
    @attrs.frozen(kw_only=True)
    class Wrong(Counting):
        def beliefs(self, state):
            return found

    sim = am.Simulation(scenario(Wrong()))
    with pytest.raises(am.ComponentError, match=problem) as error:
        sim.frames()[0].beliefs["who"]
    assert "rover" in str(error.value)
    assert "who" in str(error.value)


def test_the_check_knows_them():
    check_component(Counting())


@attrs.frozen(kw_only=True)
class Changing(Counting):
    """Counts its being asked."""

    def beliefs(self, state):
        state["count"] += 1.0
        return super().beliefs(state)


@attrs.frozen(kw_only=True)
class Mixing(Counting):
    """Believes something of all rows."""

    def beliefs(self, state):
        return {"mean": np.full(len(state["count"]), float((state["count"] * self.scale).sum()))}


@attrs.frozen(kw_only=True)
class Growing(Counting):
    """Believes more from step to step."""

    def beliefs(self, state):
        return {"count": np.zeros((len(state["count"]), int(state["count"][0, 0])))}


@attrs.frozen(kw_only=True)
class Lending(Counting):
    """Returns an array that it writes into later."""

    def update(self, robot, readings, command, elapsed, state, draws):
        state["count"] += 1.0
        return am.Estimate(state["pose"].copy(), np.zeros((robot.rows, 3, 3)))

    def beliefs(self, state):
        return {"count": state["count"]}


@pytest.mark.parametrize(
    ("wrong", "problem"),
    [(Changing, "after beliefs"), (Mixing, "belief mean"), (Growing, "later step"), (Lending, "kept")],
)
def test_the_check_finds_beliefs_that_break_the_contract(wrong, problem):
    with pytest.raises(am.ComponentError, match=problem):
        check_component(wrong())


def test_a_recorder_of_text_asks_for_small_beliefs_alone_in_each_step(tmp_path):
    looked_up = []

    @attrs.frozen(kw_only=True)
    class Large(Counting):
        def beliefs(self, state):
            def map_():
                looked_up.append(1)
                return np.zeros((len(state["count"]), 65))

            return LazyBeliefs({**super().beliefs(state), "large": map_})

    files = []
    for estimator in (Large(), Counting()):
        (tmp_path / type(estimator).__name__).mkdir()
        files.append(recorded(estimator, tmp_path / type(estimator).__name__).read_bytes())
    assert files[0] == files[1]
    assert len(looked_up) == 1  # at the start, for its shape
    sim = am.Simulation(scenario(Large()))
    frame = sim.frames()[0]
    assert frame.some_beliefs("who", ["count"]).keys() == {"count"}
    assert frame.beliefs["who"]["large"].shape == (1, 65)
    sim.step()
    assert frame.beliefs["who"]["large"].shape == (1, 65)  # what was looked up in its step is kept
    frame = sim.frames()[0]
    sim.step()
    with pytest.raises(am.AmorsimError, match="after their step"):
        frame.some_beliefs("who", ["count"])
