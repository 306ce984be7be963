"""A user's mistake ends with exit status 2 and one clear message; there is no traceback, and no folder."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import amorsim as amorsim_package
from tests.cli.conftest import Command
from tests.studies import make_study


def assert_refused(amorsim: Command, folder: Path, *arguments: object, says: tuple[str, ...]) -> None:
    before = {path for path in folder.rglob("*") if "__pycache__" not in path.parts}
    result = amorsim(*arguments)
    assert result.status == 2, result
    for part in says:
        assert part in result.err
    assert "Traceback" not in result.err
    assert {path for path in folder.rglob("*") if "__pycache__" not in path.parts} == before


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["nosuch.toml"], ("nosuch.toml: there is no such file",)),
        (["nosuch.wld"], ("nosuch.wld: there is no such file",)),
        (["demi"], ("demi: there is no such file", "Did you mean 'demo'?")),
        ([""], ("expected the name of a scenario",)),
        (["study"], ("study: it is a folder; expected a scenario, such as study/scenario.toml\n",)),
        (["study/scenario.toml", "--seed", "-1"], ("--seed: expected a whole number >= 0", "got -1")),
        (["study/scenario.toml", "--seed", "1.5"], ("--seed", "integer")),
        (["study/scenario.toml", "--duration", "0"], ("--duration: expected a number [s] > 0 and <= 1e+09, got 0.0",)),
        (
            ["study/scenario.toml", "--duration", "nan"],
            ("[s] > 0 and <= 1e+09, got nan",),
        ),
        (
            ["study/scenario.toml", "--duration", "1e300"],
            ("--duration: expected", "<= 1e+09, got 1e+300"),
        ),
        (["study/scenario.toml", "--replicas", "0"], ("--replicas: expected a whole number > 0, got 0",)),
        (["study/scenario.toml", "--replica", "-1"], ("expected", "-1")),
        (["study/scenario.toml", "--replica", "1", "--replicas", "2"], ("exclude each other",)),
        (["study/scenario.toml", "--resolution", "0.1"], ("--resolution is for a map alone",)),
        (["study/rooms.wld", "--resolution", "nan"], ("resolution: expected a number [m] > 0, got nan",)),
        (["study/rooms.wld", "--resolution", "-1"], ("resolution: expected a number [m] > 0, got -1.0",)),
        (["study/scenario.toml", "--set", "foo"], ("--set foo: expected PATH=VALUE",)),
        (["study/scenario.toml", "--set", "robots.5.name=x"], ("robots.5: no robot '5'; known robots: rover",)),
        (["study/scenario.toml", "--out", "study"], ("study: the folder holds files already",)),
        (["study/scenario.toml", "--out", "study/rooms.wld"], ("study/rooms.wld: is a file",)),
        (["study/scenario.toml", "--out", "study/rooms.wld/run"], ("cannot make this folder",)),
        (["study/scenario.toml", "--colour"], ("--colour",)),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_what_cannot_be_run(
    amorsim: Command, study: Path, tmp_path: Path, arguments: list[str], says: tuple[str, ...]
) -> None:
    assert_refused(amorsim, tmp_path, "run", *arguments, says=says)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("duration", "duratoin", ("simulation.duratoin", "Did you mean 'duration'?")),
        ("dt = 0.1 ", "dt = '0.1' ", ("simulation.dt: expected a number [s] >= 1e-06 and <= 10", "got '0.1'")),
        ("dt = 0.1 ", "dt = nan ", ("simulation.dt", "got nan")),
        ("seed = 1 ", "seed = 1.5 ", ("simulation.seed: expected a whole number", "got 1.5")),
        ("seed = 1 ", "seed = true ", ("simulation.seed: expected a whole number", "got True")),
        ("heading_deg", "heading", ("robots.rover.pose.heading", "write heading_deg")),
        ("rooms.wld", "romms.wld", ("world.map", "romms.wld: there is no such file")),
        ("pioneer2dx", "pionier2dx", ("robots.rover.model", "'pionier2dx'", "Did you mean 'pioneer2dx'?")),
        ("controller.py:drive", "controller.py:driv", ("controller.use", "no definition 'driv'", "'drive'?")),
        ("controller.py:drive", "wonder", ("no controller 'wonder'", "Did you mean 'wander'?")),
        ("x = 1.0", "x = 4.0", ("robots.rover.pose: at (4.000, 1.000) m the footprint overlaps a wall",)),
        ("track = {", "trak = {", ("errors.drive.trak", "Did you mean 'track'?")),
        ("format = 1", "format = 1 1", ("scenario.toml:5: not valid TOML",)),
        ("x = 1.0, ", "x = 1,0, ", ("scenario.toml:18: not valid TOML", "a decimal point is a dot: 1.0")),
        ('"rooms.wld"', "\N{LEFT DOUBLE QUOTATION MARK}rooms.wld\N{RIGHT DOUBLE QUOTATION MARK}", ("straight quotes",)),
        (
            "[[robots]]",
            "[[robots]]\nname = 'rover'\nmodel = 'pioneer2dx'\npose = { x = 3.0, y = 3.0 }\n[[robots]]",
            ("called 'rover' too",),
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_is_wrong_in_a_scenario(
    amorsim: Command, study: Path, tmp_path: Path, old: str, new: str, says: tuple[str, ...]
) -> None:
    text = study.read_text(encoding="utf-8")
    assert old in text
    study.write_text(text.replace(old, new, 1), encoding="utf-8")
    assert_refused(amorsim, tmp_path, "run", study, says=(str(study), *says))
    # The one that checks says the same.
    assert_refused(amorsim, tmp_path, "check", study, says=(*says, "1 fault found"))


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("noise.toml", bytes(range(128, 256)), ("noise.toml: not a text file",)),
        ("noise.wld", bytes(range(256)), ("noise.wld", "not a text file")),
        (
            "noise.bmp",
            bytes(range(256)),
            ("noise.bmp", "not a BMP, PNG, PNM, JPEG, GIF or TIFF image, or its header is damaged"),
        ),
        ("noise.xyz", b"abc", ("noise.xyz: no map of a known format",)),
        ("empty.toml", b"", ("empty.toml: format",)),
        ("empty.wld", b"", ("empty.wld: it has no wall",)),
    ],
)
def test_files_of_something_else(
    amorsim: Command, tmp_path: Path, name: str, content: bytes, says: tuple[str, ...]
) -> None:
    (tmp_path / name).write_bytes(content)
    assert_refused(amorsim, tmp_path, "run", name, says=says)


@pytest.mark.parametrize(
    ("code", "says"),
    [
        ("def drive(readings, estimate, clock, speed)\n    pass\n", ("line 1: SyntaxError",)),
        ("import numpyy\n\n\ndef drive(r, e, c, speed):\n    pass\n", ("line 1: ModuleNotFoundError", "'numpyy'")),
        ("def one():\n    return 1 / 0\n\n\ndrive = one()\n", ("line 2: ZeroDivisionError",)),
        ("def other():\n    pass\n", ("no definition 'drive'; known definitions: other",)),
        ("def drive(readings, speed):\n    pass\n", ("cannot be called as drive(readings, estimate, clock",)),
        ("def drive(r, e, c, speed):\n    return 'left'\n", ("returned 'left'", "am.Twist(forward, turn)")),
        ("def drive(r, e, c, speed):\n    return float('nan'), 1.0\n", ("nan is not finite",)),
        ("def drive(r, e, c, speed):\n    return 1.0, 2.0, 3.0\n", ("there are 2 channels",)),
        (
            "def deeper(x):\n    return x['sonnar']\n\n\ndef drive(r, e, c, speed):\n    return deeper(r)\n",
            # The user's own lines, and none of ours.
            ("'sonnar'", 'controller.py", line 6, in drive', 'controller.py", line 2, in deeper'),
        ),
    ],
)
def test_what_is_wrong_in_a_controller(amorsim: Command, tmp_path: Path, code: str, says: tuple[str, ...]) -> None:
    study = make_study(tmp_path / "study", code)
    assert_refused(amorsim, tmp_path, "run", study, says=("controller.py", *says))


def test_a_controller_that_fails_on_the_way_says_where_the_files_are(amorsim: Command, tmp_path: Path) -> None:
    code = "def drive(r, e, clock, speed):\n    return 1.0, 1.0 / (5 - clock.tick)\n"
    result = amorsim("run", make_study(tmp_path / "study", code), "--out", "run")
    assert result.status == 2
    assert "raised ZeroDivisionError" in result.err
    assert 'controller.py", line 2, in drive' in result.err
    assert str(Path(amorsim_package.__file__).parent) not in result.err  # the user's own lines, none of ours
    assert result.err.rstrip().endswith("the files up to 0.5 s are in run")
    assert len((tmp_path / "run" / "poses.csv").read_text().splitlines()) == 7


@pytest.mark.long
def test_checking_ends_a_controller_that_does_not(amorsim: Command, tmp_path: Path) -> None:
    """And says what else is wrong; nothing of the controller runs in this process."""
    path = make_study(tmp_path / "study", "while True:\n    pass\n\n\ndef drive(r, e, c, speed):\n    pass\n")
    says = ("loading the file did not finish within 0.5 s", "1 fault found")
    assert_refused(amorsim, tmp_path, "check", path, "--time-limit", 0.5, says=("controller.py", *says))
    wrong = ("--set", "robots.rover.errors.drive.track={ value = { normal = [-1.0, 0.001] } }")
    both = (says[0], "robots.rover.errors.drive.track", "2 faults found")
    assert_refused(amorsim, tmp_path, "check", path, "--time-limit", 0.5, *wrong, says=both)
    limit = ("--time-limit: expected a number of seconds > 0 and <= 1e+06, got 0.0",)
    assert_refused(amorsim, tmp_path, "check", path, "--time-limit", 0, says=limit)


def test_all_faults_are_reported_at_once(amorsim: Command, study: Path) -> None:
    text = study.read_text(encoding="utf-8")
    for old, new in (
        ("dt = 0.1 ", "dt = -1 "),
        ("rover", "9rover"),
        ("speed = 0.3", "sped = 0.3"),
        ("[1.0, 0.01]", "1"),
    ):
        assert old in text
        text = text.replace(old, new)
    study.write_text(text, encoding="utf-8")
    result = amorsim("check", study)
    assert result.status == 2
    for path in ("simulation.dt", "robots.0.name", "robots.0.controller", "robots.0.errors.drive.track.scale.normal"):
        assert re.search(rf"{re.escape(str(study))}:\d+: {re.escape(path)}", result.err)
    assert result.err.rstrip().endswith("4 faults found")


@pytest.mark.parametrize("command", ["plot", "reproduce"])
def test_a_folder_that_is_no_run(amorsim: Command, study: Path, tmp_path: Path, command: str) -> None:
    says = ("expected the folder of a run, with a run.json in it",)
    for folder in ("study", "nosuch", "study/rooms.wld"):
        assert_refused(amorsim, tmp_path, command, folder, says=(folder, *says))


def test_warnings_are_one_line_each(amorsim: Command, study: Path) -> None:
    result = amorsim("check", study, "--set", "robots.rover.sensors.laser.rate=30.0")
    assert result.status == 0
    assert result.err == (
        "warning: robots.rover.sensors.laser.rate: 30 Hz is faster than the steps (10 Hz); it reads once every step\n"
    )


def test_a_scenario_of_another_format_gets_a_message_of_what_one_is(amorsim: Command, tmp_path: Path) -> None:
    (tmp_path / "study.json").write_text('{"world": {"map": "rooms.wld"}}')
    result = amorsim("run", "study.json")
    assert (result.status, result.out) == (2, "")
    assert result.err.startswith("study.json: no map of a known format; known extensions: .bmp, ")
    assert result.err.endswith(".wld, .world, .yaml, .yml; a scenario is a .toml file\n")
    (tmp_path / "study.yaml").write_text("world:\n  map: rooms.wld\n")
    result = amorsim("run", "study.yaml")
    assert (result.status, result.out) == (2, "")
    assert "'image' is missing" in result.err
    assert result.err.endswith("a scenario is a .toml file\n")


@pytest.mark.parametrize(
    "arguments",
    [
        ("plan", "maze", "--from", "0.6,0.6", "--to", "5,5", "-o", "LONG.png"),
        ("convert", "study/rooms.wld", "LONG.toml"),
        ("convert", "study/scenario.toml", "LONG.world"),
        ("new", "LONG"),
        ("run", "study/scenario.toml", "--gif", "LONG.gif"),
    ],
    ids=lambda arguments: f"{arguments[0]} {arguments[-1]}",
)
def test_names_that_are_too_long_for_a_file(
    amorsim: Command, study: Path, tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    given = [part.replace("LONG", "n" * 300) for part in arguments]
    assert_refused(amorsim, tmp_path, *given, says=("n" * 300, "File name too long"))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("Dear student,\nplease run this.\nThe lecturer\n", "x.toml:1: not a file of TOML: none of its lines is KEY ="),
        ("a: 1\nb: 2\nc:\n  d: 3\n", "x.toml:1: not a file of TOML"),
        (
            "format = 1\nscenario = 'a.toml'\nreplicas = 3\n[metrics]\n",
            "x.toml: not a scenario: expected [world] and [[robots]], got the keys format, scenario, replicas, metrics"
            "; a study runs with `amorsim sweep`",
        ),
        ("[project]\nname = 'x'\n[tool.ruff]\nline-length = 3\n", "got the keys project, tool"),
    ],
)
def test_a_file_that_is_no_scenario_is_refused_once(amorsim, tmp_path, text, says):
    (tmp_path / "x.toml").write_text(text)
    done = amorsim("run", tmp_path / "x.toml")
    assert done.status == 2
    assert says in done.err
    assert len(done.err.splitlines()) == 1


LONG = "n" * 5000


@pytest.mark.parametrize(
    "arguments",
    [
        ["compare", LONG, LONG],
        ["compare", LONG, LONG, "--axis", "x"],
        ["compare", "demo", LONG],
        ["report", LONG],
        ["plan", LONG, "--from", "1,1", "--to", "2,2"],
        ["plan", "demo", "--from", "1,1", "--to", "2,2", "--out", f"{LONG}.png"],
        ["plot", LONG],
        ["export", LONG, "--to", "csv"],
        ["reproduce", LONG],
        ["replay", LONG, "--no-open"],
        ["sweep", LONG],
        ["new", LONG],
        ["convert", LONG, "x.png"],
        ["edit", LONG, "--no-open"],
        ["view", LONG, "--no-open"],
    ],
)
def test_names_of_thousands_of_letters_are_refused_everywhere(
    amorsim: Command, tmp_path: Path, arguments: list[str]
) -> None:
    result = amorsim(*arguments)
    assert result.status == 2
    assert LONG[:50] in result.err
    assert "Traceback" not in result.err
    assert list(tmp_path.iterdir()) == []
