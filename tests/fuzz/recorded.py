"""What runs, studies and recordings leave, damaged at random: what readers of files are tried with."""

from __future__ import annotations

import copy
import io
import json
import math
import shutil
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from PIL import Image

import amorsim as am
from amorsim.analysis import export_run, read_log, read_mcap
from amorsim.analysis.run_files import RunFiles
from amorsim.core.errors import AmorsimError
from amorsim.reports.run import run_page
from amorsim.reports.study import comparison_page, study_page
from amorsim.runs.array_files import read_arrays
from amorsim.sweeps.folder import StudyFolder
from amorsim.sweeps.read import read_plan
from amorsim.sweeps.table import read_study, write_tables
from tests.fuzz.damage import damaged

__all__ = ["RECORDED"]

DEMO = ["recording.picture=false", "robots.0.sensors.laser.beams=3"]
ODD: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1, 1.5, 2**53, 2**63, 2**64, 10**400, -(10**400), 1e308, 1e-300, math.nan, math.inf),
    *(
        "",
        "x",
        "Infinity",
        "\ud800",
        "../x",
        "/dev/zero",
        "n" * 300,
        [],
        {},
        [[]],
        [None],
        [1, "x"],
        {"x": 1},
        {"a": {}},
    ),
)


def _odd(value: Any, rng: Random) -> Any:
    """A value of JSON in which one part is something else, is missing, or is named otherwise."""
    if isinstance(value, dict) and value and rng.random() < 0.85:
        key = rng.choice(list(value))
        how = rng.random()
        if how < 0.1:
            return {name: each for name, each in value.items() if name != key}
        if how < 0.15:
            return {name if name != key else f"{name}s": each for name, each in value.items()}
        return {**value, key: _odd(value[key], rng)}
    if isinstance(value, list) and value and rng.random() < 0.85:
        place = rng.randrange(len(value))
        how = rng.random()
        if how < 0.15:
            return value[:place] + value[place + 1 :]
        if how < 0.25:
            return value[:place] + [value[place]] * 2 + value[place + 1 :]
        return [*value[:place], _odd(value[place], rng), *value[place + 1 :]]
    return copy.deepcopy(rng.choice(ODD))


def _damage_json(path: Path, rng: Random) -> None:
    if rng.random() < 0.2:
        path.write_bytes(damaged(path.read_bytes(), rng))
        return
    value = json.loads(path.read_text())
    for _ in range(rng.choice((1, 1, 2))):
        value = _odd(value, rng)
    path.write_text(json.dumps(value))


def _damage(path: Path, rng: Random) -> None:
    """Damage a file, or put something else in its place."""
    how = rng.random()
    if how < 0.05:
        path.unlink()
        path.symlink_to(rng.choice(("/dev/zero", "/nowhere", path.name)))
    elif how < 0.08:
        path.unlink()
    elif path.suffix == ".json":
        _damage_json(path, rng)
    else:
        path.write_bytes(damaged(path.read_bytes(), rng))


class _Folders:
    """A folder of which one or two files are damaged, and then mended again."""

    def __init__(self, folder: Path) -> None:
        self.whole, self.folder, self.said = folder / "whole", folder / "damaged", ""
        if not self.whole.exists():
            self.make()
            shutil.copytree(self.whole, self.folder)
        self.files = sorted(path.relative_to(self.whole) for path in self.whole.rglob("*") if path.is_file())
        self.mend(self.files)

    def make(self) -> None:
        """Make the whole folder."""
        raise NotImplementedError

    def mend(self, files: list[Path]) -> None:
        """Put whole files back."""
        for file in files:
            (self.folder / file).unlink(missing_ok=True)
            shutil.copy(self.whole / file, self.folder / file)

    def tried(self, *reads: Callable[[], Any]) -> None:
        """Read in all ways: one that is refused hides no other."""
        problem = None
        for read in reads:
            try:
                read()
            except AmorsimError as error:
                str(error).encode()  # it can be printed
                problem = error
        if problem is not None:
            raise problem

    def attempt(self, rng: Random) -> None:
        """Damage files and read them."""
        chosen = rng.sample(self.files, rng.choice((1, 1, 2)))
        if rng.random() < 0.4:
            chosen[0] = rng.choice([file for file in self.files if file.suffix in (".json", ".npz", ".png")])
        self.said = ", ".join(map(str, chosen))
        try:
            for file in set(chosen):
                _damage(self.folder / file, rng)
            self.read(rng)
        finally:
            self.mend(chosen)

    def read(self, rng: Random) -> None:
        """Read the folder."""
        raise NotImplementedError


class Runs(_Folders):
    """The folder of a run: its tables, arrays, picture and ``run.json``."""

    def make(self) -> None:
        am.run(am.load("demo", [*DEMO, 'recording.also=[{use="arrays"}]']), self.whole, duration=0.3, replicas=2)
        for folder in sorted((self.whole / "beliefs").glob("*")):
            np.savez_compressed(folder / "000000009.npz", robot=np.array(["rover"]), replica=np.array([0]))
        beliefs = self.whole / "beliefs" / "cloud"
        beliefs.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(beliefs / "000000000.npz", robot=np.array(["rover"]), cloud=np.zeros((1, 9, 3)))
        Image.new("RGB", (40, 30), "red").save(self.whole / "picture.png")

    def read(self, rng: Random) -> None:
        import amorsim.reports.run as reports

        reports._pictures = _only_picture  # what else it draws is of the tables, which are read below
        files = [path for path in self.files if path.suffix == ".csv"]

        name = rng.choice(files).with_suffix("").as_posix()

        def read_arrays_of_all() -> None:
            self.tried(
                *(lambda path=path: read_arrays(self.folder / path) for path in self.files if path.suffix == ".npz")
            )

        reads: tuple[Callable[[], Any], ...] = (
            lambda: RunFiles(self.folder).table(name, replica="all"),
            read_arrays_of_all,
            lambda: RunFiles(self.folder).arrays(name),  # which reads the scenario too
            lambda: run_page(self.folder),
        )
        self.tried(*reads[:2], rng.choices((reads[0], *reads[2:]), (8, 1, 1))[0])


def _only_picture(page: Any, files: RunFiles) -> None:
    from amorsim.render.picture_file import read_png

    if (files.folder / "picture.png").exists():
        page.picture(read_png(files.folder / "picture.png"), "map and paths")


class Chunks(_Folders):
    """The folder of a study, and of a comparison: gone on with, its table made again, and reported."""

    def make(self) -> None:
        axes = {"robots.rover.errors.drive.track.scale": [1.0, 1.1]}
        metrics = {"final": {"use": "position_error"}, "length": {"use": "path_length"}}
        tables = {"format": 1, "scenario": "demo", "replicas": 2, "duration": 0.2, "axes": axes, "metrics": metrics}
        am.sweep(tables, self.whole)
        am.analysis.compare(self.whole, axis="robots.rover.errors.drive.track.scale").save(self.whole)
        (self.whole.parent / "study.json").write_text(json.dumps(tables))

    def read(self, rng: Random) -> None:
        import amorsim.reports.study as reports

        reports._pictures = lambda page, study: None
        if not hasattr(self, "_plan"):
            self._plan = read_plan(json.loads((self.whole.parent / "study.json").read_text()))
            self._scenario = am.load("demo")

        def go_on() -> None:
            folder = StudyFolder(self.folder, self._plan, self._scenario)
            folder.missing(range(2))
            write_tables(self.folder, self._plan, 0, folder.outcomes())

        others = (lambda: study_page(self.folder), lambda: comparison_page(self.folder), go_on)
        self.tried(lambda: read_study(self.folder), rng.choice(others))

    def mend(self, files: list[Path]) -> None:
        super().mend(sorted({*files, Path("table.parquet"), Path("study.toml"), Path("study.json")} & set(self.files)))


class Logs:
    """MCAP files whose messages have odd JSON, or whose bytes are damaged."""

    def __init__(self, folder: Path) -> None:
        self.path, self.said = folder / "log.mcap", ""
        if not (folder / "run").exists():
            am.run(am.load("demo", DEMO), folder / "run", duration=0.3)
            export_run(folder / "run", "mcap", folder / "whole")
        (whole,) = (folder / "whole").glob("*.mcap")
        self.whole = whole.read_bytes()
        self.robot = am.load("demo", DEMO).robots[0]
        self.messages = list(self._read(whole))

    @staticmethod
    def _read(path: Path) -> Any:
        from mcap.reader import make_reader

        with path.open("rb") as stream:
            for schema, channel, message in make_reader(stream).iter_messages():
                yield schema.name, channel.topic, message.log_time, json.loads(message.data)

    def attempt(self, rng: Random) -> None:
        """Damage the file or its messages, and read it."""
        data = damaged(self.whole, rng) if rng.random() < 0.2 else self._odd(rng)
        self.path.write_bytes(data)
        problem = None
        for read in (
            lambda: list(read_log(self.path, self.robot)),
            lambda: read_mcap(self.path, "/rover/true_pose"),
            lambda: read_mcap(self.path, "/tf/rover", frame=rng.choice((None, "rover", "x"))),
        ):
            try:
                read()
            except AmorsimError as error:
                str(error).encode(errors="surrogatepass")
                problem = error
        if problem is not None:
            raise problem

    def _odd(self, rng: Random) -> bytes:
        from mcap.writer import Writer

        stream = io.BytesIO()
        writer = Writer(stream)
        writer.start(profile="", library="fuzz")
        channels: dict[tuple[str, str], int] = {}
        wrong = set(rng.sample(range(len(self.messages)), rng.choice((1, 3, 10))))
        said = []
        for number, (kind, topic, time, content) in enumerate(self.messages):
            if (kind, topic) not in channels:
                named = kind if rng.random() < 0.97 else rng.choice(self.messages)[0]
                schema = writer.register_schema(name=named, encoding="jsonschema", data=b"{}")
                channels[kind, topic] = writer.register_channel(topic=topic, message_encoding="json", schema_id=schema)
            text = json.dumps(content)
            if number in wrong:
                text = json.dumps(_odd(content, rng))
                said.append(f"{topic}: {text[:80]}")
            data = text.encode(errors="surrogatepass")
            data = damaged(data, rng) if number in wrong and rng.random() < 0.1 else data
            writer.add_message(channels[kind, topic], log_time=time, data=data, publish_time=time)
        writer.finish()
        self.said = "; ".join(said)
        return stream.getvalue()


RECORDED: dict[str, Callable[[Path], Any]] = {"runs": Runs, "chunks": Chunks, "logs": Logs}
