"""Run folders at random edited and damaged: all that is read of them ends well or in an `AmorsimError`, and soon."""

from __future__ import annotations

import functools
import json
import random
import resource
import shutil
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

import amorsim as am
from amorsim.analysis.run_files import RunFiles
from amorsim.runs.compare import first_difference
from tests.studies import make_study

LONGEST = 10  # [s] of the processor's time; a machine may be busy with other things
WAITING = 120  # [s] of the clock on the wall: nothing waits for ever
ROOM = 1 << 30  # [bytes] beyond what the process has at the beginning
PLOTTED = 60  # of how many one is also drawn
REPEATED = 8  # of how many in which results alone are damaged one is run again; the others' files are compared
RESULTS = ("poses", "velocities", "sensors/", "estimates/")

NUMBERS = [
    "nan",
    "inf",
    "-inf",
    "1e400",
    "1e308",
    "-1",
    "0",
    "1e-320",
    "9" * 30,
    "9" * 5000,
    "1.5",
    "",
    "1_0",
    "0x1",
    "³",
]
VALUES: list[Any] = [
    *(None, True, False, 0, -1, 1.5, 2**70, 1e308, float("nan"), float("inf"), "", "x", "1", "../run.json", "\0"),
    *(
        [],
        {},
        [[]],
        [0, 0],
        {"a": []},
        ["scenario.toml"],
        {"scenario.toml": 1},
        {"../../x": "y"},
        {"kind": 1, "values": 2},
    ),
]

CONTROLLER = "import amorsim as am\n\n\ndef drive(readings, estimate, clock, speed):\n    return am.Twist(speed, 0.1)\n"
SCENARIO = ["recording.picture=false", "robots.0.sensors.laser=false", "robots.0.sensors.sonar=false"]


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of four steps in two replicas, driven by hand, in which all that can be changed was changed."""
    base = tmp_path_factory.mktemp("fuzzed")
    simulation = am.Simulation(am.load(make_study(base / "study", CONTROLLER), SCENARIO), replicas=[3, 7])
    with am.record(simulation, base / "run") as session:
        for step in range(4):
            if step == 1:
                simulation.hand_over("rover", replica=3)
                simulation.set("rover", "errors.drive.track.scale", 1.05, replica=7)
                simulation.set("rover", "errors.drive.track", {"scale": 1.01, "add": 0.01}, replica=7)
                simulation.set_pose("rover", (5.5, 1.0, 0.25), replica=7)
            if step >= 1:
                simulation.robot("rover", 3).drive(forward=0.2, turn=0.1 * step)
            simulation.step()
            session.keep()
    assert am.reproduce(base / "run").is_exact
    return base / "run"


# ----------------------------------------------------------------------------------------------------- mutations


def change_cell(draw: random.Random, path: Path) -> None:
    lines = path.read_bytes().split(b"\n")
    row = draw.randrange(min(len(lines), 12))
    cells = lines[row].split(b",")
    place = draw.randrange(len(cells))
    cells[place] = draw.choice([*NUMBERS, *map(str, VALUES), "rover", "pose_set", '"', '"[" ', "[" * 3000]).encode()
    lines[row] = b",".join(cells)
    path.write_bytes(b"\n".join(lines))


def change_bytes(draw: random.Random, path: Path) -> None:
    data = bytearray(path.read_bytes())
    for _ in range(draw.choice([1, 1, 1, 2, 20])):
        if data:
            data[draw.randrange(len(data))] = draw.randrange(256)
    path.write_bytes(data)


def cut(draw: random.Random, path: Path) -> None:
    data = path.read_bytes()
    path.write_bytes(data[: draw.randrange(len(data) + 1)])


def put_in(draw: random.Random, path: Path) -> None:
    data = path.read_bytes()
    at = draw.randrange(len(data) + 1)
    what = draw.choice(
        [b"\xff", b"\0", b"\n", b",", b'"', b"\xef\xbb\xbf", b"\r", b"[" * 2000, b"9" * 6000, b"\x1b[2J"]
    )
    path.write_bytes(data[:at] + what + data[at:])


def mix_lines(draw: random.Random, path: Path) -> None:
    lines = path.read_bytes().splitlines(keepends=True) or [b""]
    one, other = draw.randrange(len(lines)), draw.randrange(len(lines))
    how = draw.randrange(3)
    if how == 0:
        del lines[one]
    elif how == 1:
        lines.insert(one, lines[other])
    else:
        lines[one], lines[other] = lines[other], lines[one]
    path.write_bytes(b"".join(lines))


def remove(draw: random.Random, path: Path) -> None:
    path.unlink()
    how = draw.randrange(5)
    if how == 0:
        path.mkdir()
    elif how == 1:
        path.symlink_to(draw.choice(["/dev/zero", "/nowhere", path.name]))
    elif how == 2:
        path.touch()


def change_key(draw: random.Random, path: Path) -> None:
    about = json.loads(path.read_text())
    key = draw.choice(list(about))
    if isinstance(about[key], dict) and about[key] and draw.random() < 0.5:
        about[key][draw.choice(list(about[key]))] = draw.choice(VALUES)
    elif draw.random() < 0.1:
        del about[key]
    else:
        about[key] = draw.choice(VALUES)
    path.write_text(json.dumps(about))


def change_value(draw: random.Random, path: Path) -> None:
    lines = path.read_text().splitlines()
    row = draw.randrange(1, len(lines))
    cells = lines[row].split(",", 9)
    rest = cells[9].rpartition(",")
    value = json.dumps(draw.choice(VALUES)).replace('"', '""')
    lines[row] = ",".join([*cells[:9], f'"{value}"', rest[2]])
    path.write_text("\n".join(lines) + "\n")


ANY: list[Callable[[random.Random, Path], None]] = [change_bytes, cut, put_in, mix_lines, remove]


def mutate(draw: random.Random, folder: Path) -> str:
    """Damage one or two files of a folder, and tell which and how."""
    done: dict[str, str] = {}
    names = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    for name in draw.sample(names, draw.choice([1, 1, 1, 2])):
        if draw.random() < 0.3:
            name = draw.choice(["run.json", "events.csv", "commands.csv", "poses.csv"])
        ways = [*ANY]
        if name.endswith(".csv"):
            ways += [change_cell] * 6
        if name == "run.json":
            ways += [change_key] * 20
        if name == "events.csv":
            ways += [change_value] * 12
        if name == "controller.py":  # code that anyone may change does what it does
            ways = [cut, remove]
        path = folder / name
        if path.is_file() and name not in done:
            way = draw.choice(ways)
            way(draw, path)
            done[name] = f"{way.__name__} {name}"
    return ", ".join(done.values())


# ------------------------------------------------------------------------------------------------------ the trial


@pytest.fixture
def limits() -> Iterator[None]:
    """Takes more memory than there should be for an error, and a call that takes too long."""

    def too_long(number: int, frame: FrameType | None) -> None:
        raise TimeoutError(f"took more than {LONGEST} s")

    pages = int(Path("/proc/self/statm").read_text().split()[0])
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + ROOM, before[1]))
    handlers = {number: signal.signal(number, too_long) for number in (signal.SIGALRM, signal.SIGPROF)}
    yield
    for number, handler in handlers.items():
        signal.signal(number, handler)
    resource.setrlimit(resource.RLIMIT_AS, before)


def read_back(folder: Path) -> None:
    """All tables and arrays, each by itself: one that is damaged hides no other."""
    names = [path.relative_to(folder).as_posix().removesuffix(".csv") for path in folder.rglob("*.csv")]
    files = RunFiles(folder)
    no_robots = tried(lambda: files.robots)  # asked for once: it reads the scenario
    for name in names:
        tried(functools.partial(files.table, name, replica="all"))
        if no_robots:
            continue
        tried(functools.partial(files.table, name, replica=7, robot="rover"))
        tried(functools.partial(files.arrays, name))


def tried(what: Callable[[], Any]) -> str:
    """What came of it: nothing, or what was complained of."""
    signal.alarm(WAITING)
    signal.setitimer(signal.ITIMER_PROF, LONGEST)
    try:
        what()
    except am.AmorsimError as error:
        text = str(error)
        assert text.strip()
        assert len(text) < 20_000
        text.encode()  # can be printed
        return text
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.alarm(0)
    return ""


@pytest.mark.parametrize(
    "count", [pytest.param(200, marks=pytest.mark.long), pytest.param(800, marks=pytest.mark.nightly)]
)
def test_what_is_read_of_a_damaged_folder_ends_well_or_in_a_message(
    driven: Path, tmp_path: Path, limits: None, count: int
) -> None:
    plot = pytest.importorskip("amorsim.analysis.plots.plot")
    refused = again = 0
    for number in range(count):
        draw = random.Random(number)
        folder = tmp_path / "run"
        shutil.copytree(driven, folder)
        how = mutate(draw, folder)
        try:
            tried(functools.partial(read_back, folder))
            if number % REPEATED and all(each.split()[1].startswith(RESULTS) for each in how.split(", ")):
                tried(functools.partial(first_difference, folder, driven, 0.1))
            else:
                again += 1
                refused += bool(tried(functools.partial(am.reproduce, folder)))
            if number % PLOTTED == 0:
                tried(functools.partial(plot.plot_run, folder, out=tmp_path / "plots", replica=7))
        except BaseException as error:
            error.add_note(f"folder {number}: {how}")
            raise
        shutil.rmtree(folder)
    # Neither is everything taken nor everything refused.
    assert again // 10 < refused < again - again // 10
