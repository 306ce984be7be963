"""Grading of controllers in files: each runs in a process that has no truth, with limits of time and memory."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from amorsim.grading.results import Grade

__all__ = ["score"]


def score(lab: int | str | os.PathLike[str], submission: str | os.PathLike[str], *, fence: bool | None = None) -> Grade:
    """Grade one submission, as in a test cell of nbgrader or otter.

    ``assert amorsim.grading.score(6, "filter.py").total >= 6`` is a test.

    Parameters
    ----------
    lab
        The number of a lab that comes with amorsim, or the path of a rubric.
    submission
        The path of a Python file.
    fence
        Whether to fence the submission in by bubblewrap; by default where that is allowed.

    Raises
    ------
    StudyError
        If the lab, the rubric or the submission is missing or wrong.
    """
    # Imported here, for the process of a submission imports this package too, and must not load the engine with it.
    from amorsim.grading.fence import is_fence_there
    from amorsim.grading.grade import grade
    from amorsim.labs import find_lab

    rubric = find_lab(lab).rubric if isinstance(lab, int) else Path(lab)
    if fence is None:
        fence = is_fence_there()
    with tempfile.TemporaryDirectory(prefix="amorsim-score-") as folder:
        return grade(rubric, [submission], Path(folder) / "grades", fence=fence)[0]
