"""Reports of the content of a folder."""

from __future__ import annotations

import os
from pathlib import Path

from amorsim.core.arguments import path_of
from amorsim.core.errors import AnalysisError
from amorsim.core.files.atomic_files import write_text
from amorsim.core.files.reading import is_file
from amorsim.reports.run import run_page
from amorsim.reports.study import comparison_page, study_page

__all__ = ["report"]

_KINDS = (("run.json", run_page), ("study.json", study_page), ("comparison.json", comparison_page))


def report(folder: str | os.PathLike[str], out: str | os.PathLike[str] | None = None) -> Path:
    """Write one HTML file about a run, a study or a comparison; returns its path.

    It holds its pictures, loads nothing, and is the same whenever it is made of the same files.

    Parameters
    ----------
    folder
        Of the run, study or comparison.
    out
        The file; without it, ``report.html`` in the folder.

    Raises
    ------
    AnalysisError
        If the folder is none of them.
    RunError
        If a file of the run is damaged, or the report cannot be written.
    StudyError
        If a file of the study is damaged.
    """
    folder = path_of(folder, "folder", "the folder of a run, a study or a comparison")
    for name, page in _KINDS:
        if is_file(folder / name):
            path = folder / "report.html" if out is None else path_of(out, "out")
            write_text(path, page(folder).text, within=folder if out is None else None)
            return path
    raise AnalysisError(
        f"{folder}: expected the folder of a run, a study or a comparison, with one of "
        f"{', '.join(name for name, _ in _KINDS)} in it"
    )
