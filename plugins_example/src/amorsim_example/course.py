"""A scenario loader: a course as two lines of text."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

import attrs

import amorsim as am

__all__ = ["Course"]

_MARK = "course "
_ROBOT = ("MODEL", "X", "Y", "HEADING")


@attrs.frozen(kw_only=True)
class Course(am.ScenarioLoader):
    """Reads a file of robots on a map, which may be in any format.

    ``course MAP`` is the first line, ``MODEL X Y HEADING`` in metres and degrees each further one. Other programs
    write more, of course; what a loader leaves out it says in the `remarks` of the document.

    Parameters
    ----------
    duration
        Of the scenario [s]; the file says nothing of it.
    """

    extensions: ClassVar[tuple[str, ...]] = (".course",)

    duration: float = am.parameter(30.0, unit="s", gt=0, help="of the scenario")

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file begins like a course."""
        return head.startswith(_MARK.encode())

    def read(self, path: Path) -> am.ScenarioDocument:
        """The scenario in a file.

        Raises
        ------
        ScenarioError
            If it cannot be read, or with a fault for each line that is not a robot.
        """
        try:
            first, *rest = path.read_text(encoding="utf-8").splitlines() or [""]
        except (OSError, UnicodeDecodeError) as error:
            raise am.ScenarioError([_fault(path, None, f"cannot be read as text: {error}")]) from error
        if not first.startswith(_MARK):
            raise am.ScenarioError([_fault(path, 1, f"expected {_MARK!r} and the name of a map, got {first[:40]!r}")])
        robots: list[dict[str, Any]] = []
        lines: dict[str, int] = {}
        faults = []
        for number, line in enumerate(rest, start=2):
            if not line.strip():
                continue
            try:
                model, x, y, heading = line.split()
                pose = {"x": float(x), "y": float(y), "heading_deg": float(heading)}
            except ValueError:
                faults.append(_fault(path, number, f"expected {' '.join(_ROBOT)}, got {line[:40]!r}"))
                continue
            lines[f"robots.{len(robots)}"] = number
            robots.append({"name": f"robot{len(robots) + 1}", "model": model, "pose": pose})
        if faults:
            raise am.ScenarioError(faults)
        return am.ScenarioDocument(
            tables={
                "format": 1,
                "world": {"map": first.removeprefix(_MARK).strip()},
                "simulation": {"duration": self.duration},
                "robots": robots,
            },
            lines=lines,
        )


def _fault(path: Path, line: int | None, message: str) -> am.Fault:
    return am.Fault(file=str(path), path="", line=line, message=message)
