"""The finished cases of a grading, kept in its folder as they come, so that the same command goes on."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import RunError, StudyError
from amorsim.core.files.atomic_files import write_text
from amorsim.grading.handed_in import HandedIn
from amorsim.grading.questions import Question
from amorsim.grading.results import Case, CaseGrade
from amorsim.grading.seeds import Seed

__all__ = ["KeptCases", "digest_of"]

_FILE = "cases.jsonl"
SEEDS = "seeds.toml"


class KeptCases:
    """The file of the finished cases in a folder.

    Its first line holds what the cases depend on, and each other one a submission's label and digest, the number of a
    case, and its result. A line that was being written when the grading was killed does not count.
    """

    def __init__(self, folder: Path) -> None:
        self._folder, self._path = folder, folder / _FILE
        has_seeds = (folder / SEEDS).is_file()
        # Seeds alone: it was killed before it had begun to grade.
        self.goes_on = has_seeds and (self._path.is_file() or len(list(folder.iterdir())) == 1)
        """Whether there is a grading to go on with."""

    def open(self, rubric: Path, questions: Sequence[Question], seeds: Sequence[Seed], fence: str) -> None:
        """Begin the file, or check that it is of this grading.

        Raises
        ------
        StudyError
            If the grading that is there has another rubric, other seeds, or another fence.
        RunError
            If the file cannot be written.
        """
        rest = [*map(attrs.astuple, questions), *map(attrs.astuple, seeds)]
        head = {"rubric": hashlib.sha256(rubric.read_bytes() + repr(rest).encode()).hexdigest(), "fence": fence}
        lines = self._lines() or [head]
        if lines[:1] == [head]:
            write_text(self._path, "".join(json.dumps(line) + "\n" for line in lines))
        else:
            raise StudyError(
                f"{self._folder}: there is a grading by another rubric, with other seeds or another fence in it; name "
                "another folder with --out"
            )

    def read(self, cases: Iterable[Case]) -> dict[tuple[str, int], CaseGrade]:
        """The finished cases, by the digests of their submissions and the numbers of the cases."""
        by_number = {case.number: case for case in cases}
        return {
            (line["submission"], line["case"]): CaseGrade(case=by_number[line["case"]], **line["result"])
            for line in self._lines()[1:]
            if line["case"] in by_number
        }

    def add(self, submission: str, found: CaseGrade) -> None:
        """Add a finished case of the submission with a digest."""
        result = {"values": found.values, "points": found.points, "problem": found.problem}
        line = json.dumps({"submission": submission, "case": found.case.number, "result": result})
        try:
            with self._path.open("a", encoding="utf-8") as file:
                file.write(line + "\n")
        except OSError as error:
            raise RunError(f"{self._path}: cannot be written ({error.strerror or error})") from None

    def _lines(self) -> list[Any]:
        found: list[Any] = []
        if not self._path.is_file():
            return found
        for line in self._path.read_text(encoding="utf-8").splitlines():
            try:
                found.append(json.loads(line))
            except ValueError:
                break
        return found


def digest_of(handed_in: HandedIn | None, problem: str) -> str:
    """The digest of a submission's files, or of why it has none."""
    if handed_in is None:
        return hashlib.sha256(problem.encode()).hexdigest()
    whole = hashlib.sha256("\n".join([handed_in.name, *sorted(handed_in.files)]).encode())
    for name in sorted(handed_in.files):
        whole.update(hashlib.sha256(handed_in.files[name]).digest())
    return whole.hexdigest()
