"""Recorders beside the text files, chosen in a scenario."""

import attrs
import pytest

import amorsim as am
from amorsim.core.errors import ScenarioError
from amorsim.core.parameters import ParameterError
from amorsim.scenario.files.resolved import resolved_table
from amorsim.scenario.spec import Recording

ROBOT = '[[robots]]\nname = "rover"\nmodel = "pioneer2dx"\n'


@pytest.fixture
def with_counter(registry, monkeypatch):
    @attrs.define(kw_only=True)
    class Counter(am.Recorder):
        factor: float = am.parameter(1.0, help="of the count")
        _file: object = attrs.field(default=None, init=False)

        def open(self, run, frames):
            self._file = run.folder / "count.txt"
            self._steps = 0

        def write(self, frames, events):
            self._steps += 1

        def close(self):
            if self._file is not None:
                self._file.write_text(f"{self.factor * self._steps:g}\n")

    from amorsim.plugins.manager import make_registry

    fresh = make_registry(entry_points=(), disabled="")
    fresh.recorder("counter", Counter)
    return fresh


def scenario_of(text, folder, registry):
    import tomllib

    from amorsim.scenario.reading.read import loads

    document = tomllib.loads(f'format = 1\n[world]\nmap = "room.wld"\n{text}')
    return loads(document, folder, (), name="test.toml", registry=registry)


def test_a_recorder_is_chosen_and_written_down_again(with_counter, folder):
    text = f"[recording]\npicture = false\nalso = [{{ use = 'counter', factor = 2 }}]\n{ROBOT}"
    scenario = scenario_of(text, folder, with_counter)
    (recorder,) = scenario.recording.also
    assert recorder.factor == 2.0
    assert not scenario.recording.picture
    written = resolved_table(scenario, registry=with_counter)["recording"]
    assert written["also"] == [{"use": "counter", "factor": 2.0}]


def test_each_run_has_one_of_its_own(with_counter, folder, tmp_path, monkeypatch):
    monkeypatch.setattr("amorsim.runs.session.default_registry", lambda: with_counter)
    monkeypatch.setattr("amorsim.scenario.files.resolved.default_registry", lambda: with_counter)
    text = f"[recording]\npicture = false\nalso = [{{ use = 'counter' }}]\n{ROBOT}"
    scenario = scenario_of(text, folder, with_counter)
    for name, duration, count in (("a", 0.5, "5"), ("b", 0.3, "3")):
        am.run(scenario, tmp_path / name, duration=duration)
        assert (tmp_path / name / "count.txt").read_text().strip() == count
        assert (tmp_path / name / "poses.csv").exists()


@pytest.mark.parametrize(
    ("also", "path", "words"),
    [
        ("'counter'", "recording.also", "expected a list of tables"),
        ("[{ use = 'conter' }]", "recording.also.0.use", "Did you mean 'counter'?"),
        ("[{ use = 'counter', fctor = 1 }]", "recording.also.0.fctor", "Did you mean 'factor'?"),
        ("[{ use = 'counter', factor = 'x' }]", "recording.also.0.factor", "expected a"),
    ],
)
def test_what_is_wrong_is_said(with_counter, folder, also, path, words):
    with pytest.raises(ScenarioError) as caught:
        scenario_of(f"[recording]\nalso = {also}\n{ROBOT}", folder, with_counter)
    (fault,) = caught.value.faults
    assert fault.path == path
    assert words in fault.message


def test_what_is_no_recorder_is_refused_in_python():
    with pytest.raises(ParameterError, match="expected a list of Recorder, got one with 3"):
        Recording(also=[3])
