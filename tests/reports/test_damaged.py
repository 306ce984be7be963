"""What lies damaged in a folder is a message with the file's name, and takes no memory."""

from __future__ import annotations

import io
import json
import shutil
import struct
import zlib
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

import amorsim as am
from amorsim.reports.report import report
from tests.sweeps.studies import tables


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    base = tmp_path_factory.mktemp("damaged")
    am.run(am.load("demo", ["recording.picture=false"]), base / "run", duration=0.2)
    am.sweep(tables(base / "s", duration=0.2), base / "study")
    am.analysis.compare(base / "study", axis="robots.rover.errors.drive.track.scale").save(base / "study")
    return base


@pytest.fixture
def run(made: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(made / "run", tmp_path / "run"))


@pytest.fixture
def study(made: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(made / "study", tmp_path / "study"))


def png() -> bytes:
    data = io.BytesIO()
    Image.new("RGB", (300, 200), "red").save(data, "PNG")
    return data.getvalue()


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def bomb(width: int) -> bytes:
    head = struct.pack(">IIBBBBB", width, width, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(100))) + chunk(b"IEND", b"")


GIF = (
    b"GIF89a\x01\x00\x01\x00\x80\x00\x00\x00\x00\x00\xff\xff\xff,\x00\x00\x00\x00\x01\x00\x01\x00\x00\x02\x02D\x01\x00;"
)


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"no picture", "it is not a PNG"),
        (b"", "it is not a PNG"),
        (GIF, "it is not a PNG"),
        (png()[:200], "it is damaged"),
        (bomb(9000), "has 9000 x 9000 pixels; expected 70000000 at most"),
        (bomb(100_000), "it is damaged"),
    ],
)
def test_a_damaged_picture_is_named(run: Path, data: bytes, problem: str) -> None:
    (run / "picture.png").write_bytes(data)
    with pytest.raises(am.RunError, match=rf"picture\.png: (cannot be read \()?{problem}"):
        report(run)
    assert not (run / "report.html").exists()


def test_a_picture_without_end_is_not_read(run: Path) -> None:
    (run / "picture.png").symlink_to("/dev/zero")
    with pytest.raises(am.RunError, match=r"picture\.png: cannot be read \(it is a device"):
        report(run)


def test_a_missing_study_file_is_named_and_comes_back(study: Path, made: Path) -> None:
    text = (study / "study.toml").read_text()
    (study / "study.toml").unlink()
    with pytest.raises(am.StudyError, match=r"study\.toml: cannot be read .*the study's command writes it again"):
        report(study)
    am.sweep(tables(made / "s", duration=0.2), study)
    assert (study / "study.toml").read_text() == text


@pytest.mark.parametrize("value", [10**400, -(10**400), "x", None, [], {}, True, 1.5, float("nan"), [[]], {"a": []}])
@pytest.mark.parametrize("name", ["study.json", "comparison.json"])
def test_any_value_under_any_key_is_read_or_named(
    study: Path, name: str, value: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("amorsim.reports.study._pictures", lambda page, study: None)
    if name == "comparison.json":
        (study / "study.json").unlink()
    about = json.loads((study / name).read_text())
    for key in about:
        (study / name).write_text(json.dumps({**about, key: value}))
        try:
            report(study)
        except am.StudyError as error:
            assert str(study) in str(error)  # noqa: PT017
    for part in ("differences", "summaries") if name == "comparison.json" else ():
        for key in about[part][0]:
            (study / name).write_text(json.dumps({**about, part: [{**about[part][0], key: value}]}))
            try:
                report(study)
            except am.StudyError as error:
                assert str(study) in str(error)  # noqa: PT017
