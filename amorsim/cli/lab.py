"""``amorsim lab``: the labs of a course, for students and for lecturers."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import compile_once, say

__all__ = ["app"]

app = typer.Typer(no_args_is_help=False, rich_markup_mode=None, add_completion=False)


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
    from amorsim.labs import find_lab, start_lab

    found = find_lab(number)
    target = folder or Path(f"lab-{number}")
    names = start_lab(found, target)
    say(f"made {', '.join(names)} in {target}")
    say(f"read {target / 'handout.md'}, and see it move: amorsim view {target / 'lab.toml'}")
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
    from amorsim.cli.study import table
    from amorsim.grading.grade import grade
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
            criterion.measured.name,
            f"{graded.points_for(criterion.measured.name):.2f}",
            f"{criterion.points:g}",
            "none at {}, all at {}".format(*criterion.in_words),
        ]
        for criterion in rubric.criteria
    ]
    say("\n" + table(["criterion", "points", "of", ""], rows))
    say(f"\n{program.name}: {graded.total:.2f} of {graded.of:g} points, the mean of {len(graded.cases)} runs")
    problems = {case.problem for case in graded.cases if case.problem}
    for problem in sorted(problems):
        say(f"it did not finish: {problem}")


@app.command("new")
def new(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="New or empty.")],
    source: Annotated[int, typer.Option("--from", metavar="NUMBER", help="The lab that it begins as.")] = 6,
) -> None:
    """Make a lab of your own, which begins as a copy of one that is there, with its solutions."""
    from amorsim.labs import find_lab, start_lab

    start_lab(find_lab(source), folder, solutions=True)
    say(f"made a copy of lab {source} in {folder}, with its solutions")
    say("change its scenario, handout and rubric; what its solutions earn shows")
    say(f"amorsim grade {folder}/rubric.toml {folder}/solutions/*.py")
