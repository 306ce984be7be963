"""Reports are whole, small, the same again, and load nothing."""

from __future__ import annotations

import math
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.algorithms.intervals import mean_interval
from amorsim.analysis import RunFiles, compare
from amorsim.reports.page import Page, interval_cell
from tests.sweeps.studies import TRACK, tables


def check(path: Path, *words: str) -> str:
    text = path.read_text(encoding="utf-8")
    assert len(text) < 5_000_000
    outside = re.sub(r"base64,[A-Za-z0-9+/=]*", "", text)
    assert "http" not in outside.replace("http-equiv", "")
    assert "<script" not in outside
    assert not re.search(r"(src|href)=\"(?!data:image/png;)", outside)
    assert outside.count("<table") == outside.count("</table>")
    for word in words:
        assert word in outside, word
    return text


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run, a study and a comparison."""
    folder = tmp_path_factory.mktemp("reports")
    am.run(am.load("demo"), folder / "run", duration=2.0)
    study = am.sweep(tables(folder / "s", replicas=5, axes={TRACK: [1.0, 1.05, -1.0]}), folder / "study")
    compare(study, axis=TRACK, metrics=["length"]).save(folder / "study")
    (folder / "comparison").mkdir()
    (folder / "study" / "comparison.json").rename(folder / "comparison" / "comparison.json")
    return folder


@pytest.mark.long
def test_a_run_has_a_report(made: Path) -> None:
    path = am.report(made / "run")
    assert path == made / "run" / "report.html"
    text = check(
        path,
        "Run run",
        "seed",
        "digest by replica",
        "amorsim reproduce run",
        "amorsim replay run",
        "position error at the end",
        "rover",
    )
    assert text.count("data:image/png") >= 5
    assert re.search(r"heading error at the end</td><td>[\d.]+ °</td>", text)


@pytest.mark.long
def test_a_run_has_the_same_report_in_another_place(made: Path, tmp_path: Path) -> None:
    path = am.report(made / "run", tmp_path / "one.html")
    shutil.copytree(made / "run", tmp_path / "run")
    assert am.report(tmp_path / "run").read_bytes() == path.read_bytes()
    assert str(made) not in path.read_text(encoding="utf-8")


@pytest.mark.long
def test_many_replicas_have_means(made: Path, tmp_path: Path) -> None:
    am.run(am.load("demo"), tmp_path / "many", duration=1.0, replicas=3)
    text = check(am.report(tmp_path / "many"), "3 replicas", "mean over replicas")
    files = RunFiles(tmp_path / "many")
    found = mean_interval(np.degrees(am.analysis.measure(files, am.metrics.HeadingError())))
    assert f"{interval_cell(*found[:3])} °" in re.sub(r"</?span[^>]*>", "", text)


def test_a_study_has_a_report(made: Path) -> None:
    path = am.report(made / "study")
    text = check(path, "final_error [m]", "Points that failed", "-1.0", "amorsim sweep study.toml", TRACK)
    assert text.count("data:image/png") == 2
    assert am.report(made / "study", made / "again.html").read_bytes() == path.read_bytes()


def test_a_comparison_has_a_report(made: Path) -> None:
    path = am.report(made / "comparison")
    command = f"amorsim compare study --axis {TRACK} --metric length"
    how = ("How it was made", "small.toml", "seeds", am.read_study(made / "study").about["amorsim"], command)
    title = f"<title>Comparison along {TRACK}: 1.0, 1.05, -1.0</title>"
    text = check(path, title, "What may be claimed", "gain of pairing", "1.05 - 1.0", "length [m]", *how)
    # Two digits of half the interval's width: path lengths of a second at 0.2 m/s scatter by millimetres.
    assert re.search(r">0\.\d{4,5} <span class=\"whole\">\[0\.\d{4,5}, 0\.\d{4,5}\]</span></td>", text)
    assert am.report(made / "comparison", made / "second.html").read_bytes() == path.read_bytes()


def test_what_a_file_says_is_no_markup() -> None:
    page = Page("<b>", "&")
    page.facts([("<i>", "<script>alert(1)</script>")])
    page.table(["<"], [[">"]])
    page.listing("a", "</pre><script>")
    assert "<script" not in page.text
    assert "&lt;script&gt;alert(1)" in page.text


def test_an_interval_is_rounded_to_what_it_can_tell() -> None:
    assert interval_cell(0.0302345, 0.0251234, 0.0360987) == "0.0302 [0.0251, 0.0361]"
    assert interval_cell(12.3456, 1.0, 25.0) == "12 [1, 25]"
    assert interval_cell(0.05, 0.0003, 0.11) == "0.050 [0.0003, 0.110]"  # an end that is not 0 is not shown as 0
    assert interval_cell(3.14e-7, 2.75e-7, 3.55e-7) == "3.14e-07 [2.75e-07, 3.55e-07]"
    assert interval_cell(0.0, 0.0, 0.0) == "0"
    assert interval_cell(1.25, math.nan, math.nan) == "1.250"


def test_long_paths_may_be_broken_and_intervals_not() -> None:
    page = Page(f"along {TRACK}")
    page.table(["of"], [["0.1 [0.05, 0.15]"]])
    assert "<h1>along robots.<wbr>rover.<wbr>errors.<wbr>drive.<wbr>track.<wbr>scale</h1>" in page.text
    assert '<td>0.1 <span class="whole">[0.05, 0.15]</span></td>' in page.text


def test_what_is_no_result_is_reported(tmp_path: Path, made: Path) -> None:
    with pytest.raises(am.AnalysisError, match=r"expected the folder of a run, a study or a comparison"):
        am.report(tmp_path)
    (tmp_path / "comparison.json").write_text("{}")
    with pytest.raises(am.StudyError, match=r"comparison.json: cannot be read"):
        am.report(tmp_path)
