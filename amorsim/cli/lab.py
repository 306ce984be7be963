"""``amorsim lab``: the labs of a course, for students and for lecturers."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from amorsim.cli.console import compile_once, say

if TYPE_CHECKING:
    from amorsim.grading.results import Grade

__all__ = ["app"]


class _Commands(TyperGroup):
    """Commands; a number alone is that of a lab, which is begun."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that the first word names, and what is left of the words."""
        return super().resolve_command(ctx, ["start", *args] if args[0].isdecimal() else args)


app = typer.Typer(cls=_Commands, no_args_is_help=False, rich_markup_mode=None, add_completion=False)


@app.callback(invoke_without_command=True)
def lab(context: typer.Context) -> None:
    """List the labs: exercises with a handout, files to begin with, and a rubric that gives points."""
    if context.invoked_subcommand is not None:
        return
    from amorsim.labs import find_labs

    for one in find_labs():
        say(f"{one.number:>2}  {one.title}")
        say(f"    {one.about}")
    say("\nTo begin with one: amorsim lab start NUMBER FOLDER")


@app.command("start")
def start(
    number: Annotated[int, typer.Argument(metavar="NUMBER", help="Of the lab, as `amorsim lab` lists them.")],
    folder: Annotated[
        Path | None, typer.Argument(metavar="FOLDER", help="New or empty; lab-NUMBER without it.")
    ] = None,
) -> None:
    """Copy a lab's handout and the files to begin with."""
    from amorsim.labs import NOTEBOOK, find_lab, start_lab, write_notebook

    found = find_lab(number)
    target = folder or Path(f"lab-{number}")
    names = start_lab(found, target)
    write_notebook(found, target)
    say(f"made {', '.join([*names, NOTEBOOK])} in {target}")
    say(f"read {target / 'handout.md'}, and see it move: amorsim view {target / 'lab.toml'}")
    say(f"or open {target / NOTEBOOK} in Jupyter")
    say(f"change {target / found.handed_in.name}, and see what it earns: amorsim lab check {target}")


@app.command("check")
def check(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="Of a lab, as `amorsim lab start` makes it.")
    ] = Path(),
    no_fence: Annotated[
        bool, typer.Option("--no-fence", help="Without bubblewrap, where that is missing: it is your own program.")
    ] = False,
) -> None:
    """Grade your own file by the lab's rubric, over seeds that are drawn anew and are not those of the lecturer."""
    from amorsim.cli.studies.study import table
    from amorsim.grading.grade import grade
    from amorsim.grading.questions import ANSWERS
    from amorsim.grading.rubric import read_rubric
    from amorsim.labs import own_lab

    found = own_lab(folder)
    program = found.handed_in

    def look() -> None:
        read_rubric(found.rubric)

    compile_once(look)
    rubric = read_rubric(found.rubric)
    with tempfile.TemporaryDirectory(prefix="amorsim-lab-") as out:
        folder = Path(out) / "grades"
        graded = grade(found.rubric, [program], folder, fence=not no_fence, progress=lambda line, *_: say(line))[0]
    rows = [
        [
            part.name,
            f"{graded.points_for(part.name):.2f}",
            f"{part.points:g}",
            _mean(graded, part.name),
            "none at {}, all at {}".format(*part.in_words),
        ]
        for part in rubric.parts
    ]
    say("\n" + table(["criterion", "points", "of", "value", ""], rows))
    say(f"\n{program.name}: {graded.total:.2f} of {graded.of:g} points, the mean of {len(graded.cases)} runs")
    if not rubric.questions and ANSWERS in program.read_text(encoding="utf-8", errors="replace"):
        say(f"what {ANSWERS} holds is looked at when you hand in")
    problems = {case.problem for case in graded.cases if case.problem}
    for problem in sorted(problems):
        say(f"it did not finish: {problem}")


def _mean(graded: Grade, name: str) -> str:
    """The mean value of a criterion over the runs that ended; empty if none did."""
    values = [case.values[name] for case in graded.cases if name in case.values]
    return f"{math.fsum(values) / len(values):.3g}" if values else "-"


@app.command("notebook")
def notebook(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Of a lab, such as one of your own.")] = Path(),
) -> None:
    """Make the notebook of a lab's handout anew."""
    from amorsim.labs import NOTEBOOK, own_lab, write_notebook

    write_notebook(own_lab(folder), folder)
    say(f"made {folder / NOTEBOOK}")


@app.command("new")
def new(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="New or empty.")],
    source: Annotated[int, typer.Option("--from", metavar="NUMBER", help="The lab that it begins as.")] = 6,
) -> None:
    """Make a lab of your own, which begins as a copy of an existing one with its solutions."""
    from amorsim.labs import find_lab, start_lab

    start_lab(find_lab(source), folder, solutions=True)
    say(f"made a copy of lab {source} in {folder}, with its solutions")
    say("change its scenario, handout and rubric; what its solutions earn shows")
    say(f"amorsim grade {folder}/rubric.toml {folder}/solutions/*.py")
