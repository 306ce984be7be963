"""A plugin from nothing, as the how-to says it; controllers, as theirs does; and the example plugins from the tree."""

from __future__ import annotations

import importlib
import importlib.metadata
import itertools
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.plugins.manager import make_registry
from amorsim.plugins.registry import KINDS, Registry
from amorsim.testing import check_component
from tests.installed import write_info

ROOT = Path(__file__).parents[2]
HOW_TO = ROOT / "docs" / "how-to"
PLUGIN_PAGE = HOW_TO / "write-a-plugin.md"
CONTROLLER_PAGE = HOW_TO / "write-a-controller.md"
EXAMPLE = ROOT / "plugins_example" / "src"

IMPORTS = "import amorsim as am\nimport attrs\nimport numpy as np\n\n\n"


class Block(NamedTuple):
    """A block of code of a page: its language, what else its first line says, its text, the heading above it."""

    language: str
    about: str
    text: str
    heading: str


def blocks(page: Path) -> list[Block]:
    found, heading = [], ""
    lines = iter(page.read_text(encoding="utf-8").splitlines())
    for line in lines:
        if line.startswith("#"):
            heading = line.lstrip("# ")
        elif line.startswith("```"):
            language, _, about = line[3:].partition(" ")
            text = []
            for inner in lines:
                if inner == "```":
                    break
                text.append(inner)
            found.append(Block(language, about, "\n".join(text) + "\n", heading))
    return found


def write_files(page: Path, folder: Path) -> None:
    """Write each block that names a file; one that says ``more`` behind the name goes to the file's end."""
    for block in blocks(page):
        name, _, more = block.about.partition(" ")
        if re.fullmatch(r"[\w-]+\.(py|toml|wld)", name):
            path = folder / name
            before = path.read_text(encoding="utf-8") + "\n\n" if more else ""
            path.write_text(before + block.text, encoding="utf-8")


def install(folder: Path, site: Path) -> importlib.metadata.Distribution:
    """What pip does with a project of one module, as far as amorsim can see it."""
    project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    name, version = project["name"], project["version"]
    found = write_info(site, name, version, project["entry-points"]["amorsim"])
    for module in folder.glob("*.py"):
        (site / module.name).write_text(module.read_text(encoding="utf-8"), encoding="utf-8")
    return found


@pytest.fixture
def modules() -> Iterator[None]:
    """Modules imported in a test are forgotten after it."""
    known = set(sys.modules)
    yield
    for name in set(sys.modules) - known:
        if name.startswith("amorsim_"):
            del sys.modules[name]


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, modules: None) -> Path:
    """The how-to's project, installed in a place that Python looks into."""
    folder = tmp_path / "project"
    folder.mkdir()
    write_files(PLUGIN_PAGE, folder)
    install(folder, tmp_path / "site")
    monkeypatch.syspath_prepend(tmp_path / "site")
    monkeypatch.chdir(folder)
    return folder


def distribution(project: Path) -> importlib.metadata.Distribution:
    return importlib.metadata.Distribution.at(project.parent / "site" / "amorsim_gaps-0.1.0.dist-info")


def registry_with(project: Path, code: str) -> Registry:
    """The registry when the how-to's module says `code`."""
    (project.parent / "site" / "amorsim_gaps.py").write_text(code, encoding="utf-8")
    sys.modules.pop("amorsim_gaps", None)
    importlib.invalidate_caches()
    sys.dont_write_bytecode, before = True, sys.dont_write_bytecode
    try:
        return make_registry(entry_points=distribution(project).entry_points)
    finally:
        sys.dont_write_bytecode = before


def assert_says(text: str, answer: Block) -> None:
    """What a page leaves out, for it differs from time to time, it writes as three dots."""
    pattern = re.escape(" ".join(answer.text.split())).replace(re.escape("..."), ".+")
    assert re.fullmatch(pattern, " ".join(text.split())), text


def amorsim(*arguments: str, site: Path, cwd: Path) -> str:
    """What the program prints, run as a user would."""
    path = os.pathsep.join([str(site), str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(
        [sys.executable, "-m", "amorsim", *arguments],
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


# ---------------------------------------------------------------------------------------------- write-a-plugin.md


@pytest.mark.long
def test_the_plugin_is_found_and_its_manual_is_as_shown(project: Path) -> None:
    shown = [block for block in blocks(PLUGIN_PAGE) if block.text.startswith("$ amorsim plugins show")]
    assert len(shown) == 1
    command, first_line = shown[0].text.splitlines()
    printed = amorsim(*command.split()[2:], site=project.parent / "site", cwd=project)
    assert printed.splitlines()[0] == first_line
    assert "share of the values that are lost" in printed
    assert ">= 0 and <= 1" in printed


@pytest.mark.long
def test_the_scenario_runs_and_loses_a_fifth_of_the_laser_s_values(project: Path) -> None:
    amorsim("run", "scenario.toml", "--out", "run", site=project.parent / "site", cwd=project)
    rows = [line.split(",") for line in (project / "run/sensors/laser.csv").read_text().splitlines()]
    columns = [i for i, name in enumerate(rows[0]) if name.startswith("measured_")]
    measured = np.array([[float(row[i]) for i in columns] for row in rows[1:]])
    assert measured.shape == (51, 181)
    # The room is smaller than the laser's range, so inf is what was lost: a binomial number, five deviations.
    lost = np.isinf(measured).mean()
    assert lost == pytest.approx(0.2, abs=5.0 * np.sqrt(0.2 * 0.8 / measured.size))


def test_the_test_of_the_how_to_passes(project: Path) -> None:
    namespace: dict[str, object] = {}
    exec((project / "test_gaps.py").read_text(encoding="utf-8"), namespace)
    namespace["test_contract"]()  # type: ignore[operator]


def test_the_noise_with_state_keeps_its_contract_and_repeats_as_often_as_it_says(project: Path) -> None:
    stuck = importlib.import_module("amorsim_gaps").Stuck
    check_component(stuck(share=0.4), inf="changed")
    with pytest.raises(am.ComponentError, match="inf"):
        check_component(stuck(share=0.4))

    chain = tuple(
        am.NoiseElement(name=name, noise=noise)
        for name, noise in (("white", am.noise.Gaussian(std=0.1)), ("stuck", stuck(share=0.4)))
    )
    rover = attrs.evolve(
        am.load("demo").robots[0], sensors={"compass": am.MountedSensor(sensor=am.sensors.Compass(), noise=chain)}
    )
    rover = attrs.evolve(rover, controller=am.controllers.Manual(), estimators={}, errors={})
    sim = am.Simulation(attrs.evolve(am.load("demo"), robots=[rover]), replicas=200)
    read = []
    for _ in range(50):
        read.append(sim.readings["compass"].measured[:, 0])
        sim.step()
    # White noise is never the same twice: what repeats was stuck. A binomial number, five deviations.
    repeated = (np.diff(read, axis=0) == 0.0).mean()
    assert repeated == pytest.approx(0.4, abs=5.0 * np.sqrt(0.4 * 0.6 / (49 * 200)))


MISTAKES = [
    pytest.param(block, answer, id=block.heading)
    for block, answer in itertools.pairwise(blocks(PLUGIN_PAGE))
    if block.language == "python" and not block.about and answer.language == "text"
]


@pytest.mark.parametrize(("mistake", "answer"), MISTAKES)
def test_a_mistake_is_answered_as_the_how_to_says(project: Path, mistake: Block, answer: Block) -> None:
    stub = "" if "class Gaps" in mistake.text else "class Gaps(am.Noise): ...\n\n\n"
    registry = registry_with(project, IMPORTS + stub + mistake.text)
    assert_says(" ".join(registry.problems), answer)
    # The rest works.
    assert registry.get("noise", "gaussian") is am.noise.Gaussian


def test_there_are_mistakes() -> None:
    assert len(MISTAKES) >= 6


def test_a_field_that_is_given_nonsense_is_answered_as_the_how_to_says(project: Path) -> None:
    registry = make_registry(entry_points=distribution(project).entry_points)
    (answer,) = [block for block in blocks(PLUGIN_PAGE) if block.about == "nonsense"]
    text = Path("scenario.toml").read_text(encoding="utf-8")
    Path("scenario.toml").write_text(text.replace("share = 0.2", "share = 1.5"), encoding="utf-8")
    with pytest.raises(am.ScenarioError) as caught:
        am.load("scenario.toml", registry=registry)
    assert_says(str(caught.value), answer)


def test_components_in_a_file_run_and_are_carried_along(project: Path) -> None:
    am.run(am.load("in_file.toml"), "run")
    assert Path("run/count.txt").read_text(encoding="utf-8") == "50\n"
    assert Path("run/mine.py").read_bytes() == Path("mine.py").read_bytes()
    x = [line.split(",") for line in Path("run/obstacles.csv").read_text(encoding="utf-8").splitlines()]
    column = x[0].index("x")
    assert float(x[-1][column]) == pytest.approx(1.0 + 0.2 * 5.0)


BROKEN = [
    pytest.param(block, answer, id=str(number))
    for number, (block, answer) in enumerate(itertools.pairwise(blocks(PLUGIN_PAGE)))
    if block.about == "check"
]


@pytest.mark.parametrize(("mistake", "answer"), BROKEN)
def test_a_broken_promise_is_answered_as_the_how_to_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, modules: None, mistake: Block, answer: Block
) -> None:
    (tmp_path / "amorsim_broken.py").write_text(IMPORTS + mistake.text, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(am.ComponentError) as caught:
        check_component(importlib.import_module("amorsim_broken").Gaps)
    assert_says(str(caught.value), answer)


def test_there_are_broken_promises() -> None:
    assert len(BROKEN) == 2


# -------------------------------------------------------------------------------------------- the example plugins


@pytest.mark.long
def test_the_example_plugins_keep_their_contracts_and_run(
    monkeypatch: pytest.MonkeyPatch, modules: None, tmp_path: Path
) -> None:
    monkeypatch.syspath_prepend(EXAMPLE)
    registry = make_registry({"example": importlib.import_module("amorsim_example.plugin")}, entry_points=[])
    assert not registry.problems
    brought = [entry for entry in registry.entries() if entry.plugin.name == "example"]
    kinds = [entry.kind for entry in brought]
    assert sorted(kinds) == sorted([*KINDS, "robot", "scenario"])  # one of each
    for entry in brought:
        if entry.kind not in ("robot", "scenario"):
            check_component(registry.get(entry.kind, entry.name))
    scenario = am.load("example-maze", registry=registry)
    used = {type(part).__module__ for part in _parts(scenario.robots[0])}
    assert used >= {f"amorsim_example.{name}" for name in ("tricycle", "beacon", "drift", "compass_odometry")}
    simulation = am.Simulation(scenario)
    simulation.run(5.0)
    assert not simulation.events
    assert not np.array_equal(simulation.true_pose, simulation.estimated_pose)


def _parts(robot: am.Robot) -> list[object]:
    chains = [element.noise for unit in robot.sensors.values() for element in unit.noise]
    return [robot.drive, *(unit.sensor for unit in robot.sensors.values()), *chains, *robot.estimators.values()]


# ------------------------------------------------------------------------------------------ write-a-controller.md


@pytest.fixture
def controllers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, modules: None) -> Path:
    """A folder with the files of the how-to."""
    write_files(CONTROLLER_PAGE, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_function_drives_and_keeps_away_from_the_walls(controllers: Path) -> None:
    sim = am.Simulation(am.load("scenario.toml"))
    sim.run(60.0)
    assert not sim.events
    x, y, _ = sim.true_pose[0]
    assert 0.3 < x < 5.7
    assert 0.3 < y < 3.7
    assert np.hypot(x - 1.5, y - 1.5) > 0.2


def test_a_wrong_answer_is_answered_as_the_how_to_says(controllers: Path) -> None:
    page = blocks(CONTROLLER_PAGE)
    ((wrong, answer),) = [(b, a) for b, a in itertools.pairwise(page) if b.about == "wrong"]
    Path("controller.py").write_text(IMPORTS + wrong.text, encoding="utf-8")
    text = Path("scenario.toml").read_text(encoding="utf-8").replace(", speed = 0.25", "")
    Path("scenario.toml").write_text(text, encoding="utf-8")
    sim = am.Simulation(am.load("scenario.toml"))
    with pytest.raises(am.ControllerError) as caught:
        sim.step()
    assert_says(str(caught.value), answer)


def test_the_class_comes_by_all_its_places_and_each_replica_has_its_own(controllers: Path) -> None:
    sim = am.Simulation(am.load("patrol.toml"), replicas=2)
    path = []
    for _ in range(600):
        sim.step()
        path.append(sim.true_pose[:, :2])
    assert not sim.events
    for place in ((4.5, 1.5), (4.5, 2.5), (1.5, 2.5), (1.5, 1.5)):
        near = np.sqrt(((np.array(path) - place) ** 2).sum(axis=2)).min(axis=0)
        assert (near < 0.3).all()


def test_a_snapshot_takes_the_plan_with_it(controllers: Path) -> None:
    text = Path("patrol.toml").read_text(encoding="utf-8").replace("patrol.py:Patrol", "plan.py:Plan")
    Path("plan.toml").write_text(text, encoding="utf-8")
    sim = am.Simulation(am.load("plan.toml"))
    sim.run(2.5)
    middle = sim.snapshot()
    sim.run(4.0)
    end = sim.digest()
    sim.restore(middle)
    sim.run(4.0)
    assert sim.digest() == end

    source = Path("plan.py").read_text(encoding="utf-8")
    Path("plan.py").write_text(source.replace("get_state", "get").replace("set_state", "put"), encoding="utf-8")
    sim = am.Simulation(am.load("plan.toml"))
    sim.run(1.0)
    (answer,) = [block for block in blocks(CONTROLLER_PAGE) if block.about == "no-get-state"]
    with pytest.raises(am.SnapshotError) as caught:
        sim.snapshot()
    assert_says(str(caught.value), answer)


def test_the_script_drives_by_hand(controllers: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (script,) = [block for block in blocks(CONTROLLER_PAGE) if block.about == "script"]
    exec(script.text, {})
    x, y, _ = (float(number) for number in capsys.readouterr().out.strip(" []\n").split())
    # Five seconds at 0.3 m/s on an arc of 0.1 rad/s, less what it takes to get going.
    assert 1.0 < np.hypot(x - 1.5, y - 1.5) < 1.5


def test_the_component_over_rows_keeps_its_contract_and_keeps_away_from_the_walls(
    controllers: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(controllers)
    module = importlib.import_module("amorsim_bounce")
    check_component(module.Bounce())
    registry = make_registry({"bounce": module}, entry_points=[])
    assert not registry.problems
    text = Path("scenario.toml").read_text(encoding="utf-8")
    Path("file.toml").write_text(text.replace("controller.py:bounce", "amorsim_bounce.py:Bounce"), encoding="utf-8")
    assert type(am.Simulation(am.load("file.toml")).scenario.robots[0].controller).__name__ == "Bounce"
    text = text.replace("controller.py:bounce", "bounce")
    Path("rows.toml").write_text(text, encoding="utf-8")
    sim = am.Simulation(am.load("rows.toml", registry=registry), replicas=20)
    start = sim.true_pose[:, :2]
    sim.run(60.0)
    assert not sim.events
    assert (np.sqrt(((sim.true_pose[:, :2] - start) ** 2).sum(axis=1)) > 0.2).all()
