"""Links in the folder of a run, which may be somebody else's, lead no file out of it."""

from __future__ import annotations

from pathlib import Path

import pytest

import amorsim as am
from amorsim.analysis import export_run
from amorsim.analysis.export import FORMATS
from amorsim.reports.report import report


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("links") / "run"
    am.run(am.load("demo", ["recording.picture=false"]), folder, duration=0.2)
    return folder


@pytest.fixture
def precious(tmp_path: Path) -> Path:
    """A folder of the user's, which no command was given."""
    folder = tmp_path / "precious"
    folder.mkdir()
    return folder


def linked(made: list[Path], precious: Path) -> None:
    """Replace files that were made by links to files of the user's."""
    for path in made:
        target = precious / path.name
        target.write_text("mine")
        path.unlink()
        path.symlink_to(target)


def is_untouched(precious: Path) -> bool:
    return all(path.read_text() == "mine" for path in precious.iterdir())


@pytest.mark.long
def test_a_report_replaces_a_link(run: Path, precious: Path) -> None:
    linked([report(run)], precious)
    assert report(run).read_text().startswith("<!doctype html>")
    assert not (run / "report.html").is_symlink()
    assert is_untouched(precious)


@pytest.mark.long
def test_plots_replace_links(run: Path, precious: Path) -> None:
    plot_run = pytest.importorskip("amorsim.analysis.plots.plot").plot_run
    linked(plot_run(run)[:2], precious)
    assert not [path for path in plot_run(run) if path.is_symlink()]
    assert is_untouched(precious)


@pytest.mark.parametrize("kind", FORMATS)
def test_exports_replace_links(kind: str, run: Path, precious: Path) -> None:
    for module in {"parquet": ("pyarrow",), "mcap": ("mcap",), "rosbag": ("rosbags",)}.get(kind, ()):
        pytest.importorskip(module)
    made = export_run(run, kind)
    if kind == "rosbag":
        made[0].rename(precious / "bag")
        made[0].symlink_to(precious / "bag")
        before = {path: path.read_bytes() for path in (precious / "bag").iterdir()}
        assert not export_run(run, kind)[0].is_symlink()
        assert before == {path: path.read_bytes() for path in (precious / "bag").iterdir()}
        return
    linked(made, precious)
    assert not [path for path in export_run(run, kind) if path.is_symlink()]
    assert is_untouched(precious)


def test_a_folder_that_is_a_link_is_replaced_too(run: Path, precious: Path) -> None:
    if (run / "export").exists():
        (run / "export").rename(precious.parent / "before")
    (run / "export").symlink_to(precious)
    assert all(path.is_file() for path in export_run(run, "csv"))
    assert not (run / "export").is_symlink()
    assert list(precious.iterdir()) == []


@pytest.mark.long
def test_a_file_that_the_user_names_may_be_a_link(run: Path, precious: Path, tmp_path: Path) -> None:
    (precious / "page.html").write_text("old")
    (tmp_path / "page.html").symlink_to(precious / "page.html")
    report(run, tmp_path / "page.html")
    assert (precious / "page.html").read_text().startswith("<!doctype html>")
