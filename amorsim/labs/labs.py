"""Labs as folders: a handout, files to begin with, a rubric, and the lecturer's solutions."""

from __future__ import annotations

import re
import shutil
from collections.abc import Sequence
from pathlib import Path

import attrs

from amorsim.core.errors import StudyError
from amorsim.core.files.atomic_files import copy_file, write_text
from amorsim.core.unknown_names import no_such

__all__ = ["HANDOUT", "Lab", "find_lab", "find_labs", "own_lab", "read_handout", "start_lab"]

HANDOUT, RUBRIC, SOLUTIONS = "handout.md", "rubric.toml", "solutions"
_PACKAGE = Path(__file__).parents[1]
_PLACES = (_PACKAGE / "labs" / "course", _PACKAGE.parent / "docs" / "labs")  # of a wheel, and of a checkout
_FOLDER = re.compile(r"(\d\d)-[a-z0-9-]+")
_LINK = re.compile(r"\[([^\]]+)\]\(\.\./\.\./([^)#]+)\.md(?:#[^)]*)?\)")  # to another page of the docs
_QUESTIONS = re.compile(r"^questions = .*\n", re.MULTILINE)  # the rubric's key for the file of the right answers


@attrs.frozen(kw_only=True)
class Lab:
    """A lab in its folder.

    Attributes
    ----------
    number
        Of the course; 0 for a lab of a lecturer's own.
    title
        The first line of its handout, without "Lab 6:".
    about
        The handout's first paragraph.
    folder
        Where it lies.
    """

    number: int
    title: str
    about: str
    folder: Path

    @property
    def handed_out(self) -> list[Path]:
        """The files that a student gets: all but the solutions, and the website's dark pictures."""
        return sorted(
            path
            for path in self.folder.iterdir()
            if path.is_file() and not path.name.startswith((".", "about-")) and not path.stem.endswith("-dark")
        )

    @property
    def handed_in(self) -> Path:
        """The file that a student changes and hands in: the one program among those handed out."""
        programs = [path for path in self.handed_out if path.suffix == ".py"]
        if len(programs) != 1:
            names = ", ".join(path.name for path in programs) or "none"
            raise StudyError(f"{self.folder}: expected one program that is handed in, got {names}")
        return programs[0]

    @property
    def rubric(self) -> Path:
        """The file of its rubric."""
        return self.folder / RUBRIC


def find_labs() -> list[Lab]:
    """The labs that come with amorsim, by their numbers.

    Raises
    ------
    StudyError
        If this installation has none.
    """
    for place in _PLACES:
        folders = sorted(place.glob(f"*/{RUBRIC}"))
        if folders:
            return [own_lab(rubric.parent) for rubric in folders]
    raise StudyError("this installation of amorsim has no labs; they are in docs/labs of its repository")


def find_lab(number: int) -> Lab:
    """The lab of a number.

    Raises
    ------
    StudyError
        If there is no such lab.
    """
    labs = {str(lab.number): lab for lab in find_labs()}
    if str(number) not in labs:
        raise StudyError(no_such("lab", str(number), labs))
    return labs[str(number)]


def own_lab(folder: Path) -> Lab:
    """The lab in a folder, of a student or of a lecturer.

    Raises
    ------
    StudyError
        If the folder has no rubric or no handout.
    """
    for name in (RUBRIC, HANDOUT):
        if not (folder / name).is_file():
            raise StudyError(f"{folder}: not the folder of a lab: expected {name} in it; amorsim lab start makes one")
    paragraphs = (folder / HANDOUT).read_text(encoding="utf-8").split("\n\n")
    title = paragraphs[0].removeprefix("#").strip()
    numbered = re.match(r"Lab (\d+): (.*)", title)
    about = " ".join(paragraphs[1].split()) if len(paragraphs) > 1 else ""
    number, title = (int(numbered[1]), numbered[2]) if numbered else (0, title)
    return Lab(number=number, title=title[:1].upper() + title[1:], about=about, folder=folder)


def read_handout(lab: Lab) -> str:
    """The text of a lab's handout, with links to other pages replaced by the names of those pages."""
    return _LINK.sub(r"\1 (amorsim's docs: \2)", (lab.folder / HANDOUT).read_text(encoding="utf-8"))


def start_lab(lab: Lab, folder: Path, *, solutions: bool = False) -> list[str]:
    """Copy the files that a lab hands out into a folder, new or empty; returns their names.

    The rubric is without the right answers, unless the solutions come, too. Links of the handout to other pages of the
    docs become the names of those pages.

    Raises
    ------
    StudyError
        If there is something in the folder, or it cannot be written.
    """
    files: Sequence[Path] = lab.handed_out
    try:
        if folder.exists() and any(folder.iterdir()):
            raise StudyError(f"{folder}: there is something in it; name another folder")
        folder.mkdir(parents=True, exist_ok=True)
        for file in files:
            if file.name == HANDOUT:
                write_text(folder / HANDOUT, read_handout(lab))
            elif file.name == RUBRIC and not solutions:
                write_text(folder / RUBRIC, _QUESTIONS.sub("", file.read_text(encoding="utf-8")))
            else:
                copy_file(file, folder / file.name)
        if solutions and (lab.folder / SOLUTIONS).is_dir():
            shutil.copytree(lab.folder / SOLUTIONS, folder / SOLUTIONS, ignore=shutil.ignore_patterns("__pycache__"))
    except OSError as error:
        raise StudyError(f"{folder}: cannot be written ({error.strerror or error})") from None
    return [file.name for file in files]
