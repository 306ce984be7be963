"""The commands, and how a user's mistake ends: with a message and exit status 2."""

from __future__ import annotations

import errno
import gc
import io
import os
import sys
import warnings
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from amorsim.cli import compile_, grade, lab, new, plugins, schema
from amorsim.cli.console import complain
from amorsim.cli.runs import export, plot, replay, report, reproduce, run, slam, view
from amorsim.cli.scenarios import check, convert, edit, explain, generate, plan
from amorsim.cli.start import answer_interrupts
from amorsim.cli.studies import calibrate, compare, sweep, umbmark
from amorsim.core.error_text import explain as in_words
from amorsim.core.errors import AmorsimError

__all__ = ["app", "main"]

_OF_OUTPUT = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF)
_OF_NAMES = (errno.ENAMETOOLONG, errno.ELOOP)  # of what the user typed, wherever it was first used
INTERRUPTED = 130  # the exit status after Ctrl-C, as shells have it


class _Commands(TyperGroup):
    """Commands that report at which one Ctrl-C came; typer alone ends without a word and drops the error's notes."""

    def invoke(self, ctx: Any) -> Any:
        answer_interrupts()
        _check_here()
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt as error:
            complain("\n".join(["interrupted", *getattr(error, "__notes__", ())]))
            raise typer.Exit(INTERRUPTED) from error


def _check_here() -> None:
    """Raise an error where the present folder has been removed: no relative path leads anywhere then."""
    try:
        Path.cwd()
    except OSError as error:
        raise AmorsimError(f"the present folder cannot be used ({error.strerror}); go to another one: cd") from None


app = typer.Typer(
    name="amorsim",
    cls=_Commands,
    help="Simulate mobile robots in the plane, where every quantity is true, measured and estimated.",
    epilog="Begin with `amorsim run demo`, or with `amorsim new my-study` and what it says then.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("run", short_help="Simulate a scenario, or a map alone.")(run.command)
app.command("view", short_help="Open the Simulator in the browser.")(view.command)
app.command("runsim", short_help="The same as view; the original's name for it.")(view.command)
app.command("edit", short_help="Make or change a scenario in the browser.")(edit.command)
app.command("createsim", short_help="The same as edit; the original's name for it.")(edit.command)
app.command("replay", short_help="Open a recorded run in the Simulator.")(replay.command)
app.command("reproduce", short_help="Run a finished run again, and compare.")(reproduce.command)
app.command("check", short_help="Report all that is wrong with a scenario.")(check.command)
app.command("convert", short_help="Write a map in another format.")(convert.command)
app.command("generate", short_help="Make a random world, such as an office or a maze.")(generate.command)
app.command("plan", short_help="Find a path on a map, and draw it.")(plan.command)
app.command("compile", short_help="Compile the kernels ahead of the first run.")(compile_.command)
app.command("sweep", short_help="Run a study: a scenario over axes, seeds and replicas.")(sweep.command)
app.command("compare", short_help="Compare systems on the same noise, and say what may be claimed.")(compare.command)
app.command("slam", short_help="Make a path and a map from the log of a robot.")(slam.command)
app.command("plot", short_help="Draw a run, from its files.")(plot.command)
app.command("report", short_help="Write one HTML file about a run, a study or a comparison.")(report.command)
app.command("export", short_help="Write a run as TUM, KITTI, CSV, Parquet, MCAP or rosbag2.")(export.command)
app.command("grade", short_help="Grade controllers in files, by a rubric.")(grade.command)
app.command("umbmark", short_help="Measure and correct a differential drive by squares.")(umbmark.command)
app.command("calibrate", short_help="Find the errors of a gyro, a compass or a range sensor.")(calibrate.command)
app.command("explain-errors", short_help="Show what each error does to odometry.")(explain.command)
app.command("new", short_help="Make a scenario, a controller and a map to start from.")(new.command)
app.command("schema", short_help="Print the JSON Schema of scenarios, studies or rubrics.")(schema.command)
app.add_typer(lab.app, name="lab", short_help="List, begin and check the labs of a course.")
app.add_typer(plugins.app, name="plugins", short_help="List all components, or show the manual of one.")


def _version(wanted: bool) -> None:
    if wanted:
        from amorsim.core.version import __version__

        typer.echo(f"amorsim {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and end.")
    ] = False,
) -> None:
    pass


def main() -> None:
    """Run the command line; the exit status is 0 for success, 1 for a difference found, 2 for a user's mistake."""
    # What is imported stays; to look through it for garbage every 700 objects takes a tenth of a start.
    gc.set_threshold(50_000, 20, 50)
    _open_closed()
    with warnings.catch_warnings():
        # One line a warning, without the place in our code that a user cannot do anything about.
        warnings.showwarning = lambda message, *_, **__: complain(f"warning: {message}")
        try:
            app(prog_name="amorsim")  # however it was called: python -m amorsim, or a test
        except AmorsimError as error:
            complain(in_words(error))
            sys.exit(2)
        except BrokenPipeError:  # the reader of our output has closed it (``| head``)
            _print_no_more()
            sys.exit(1)
        except OSError as error:
            if error.filename is not None and error.errno in _OF_NAMES:
                complain(f"{error.filename}: cannot be used ({error.strerror})")
                sys.exit(2)
            if error.filename is not None or error.errno not in _OF_OUTPUT:
                raise
            _print_no_more()
            complain(f"what is printed cannot be written ({error.strerror})")
            sys.exit(2)


def _print_no_more() -> None:
    """Discard all further output, and what is buffered, which Python would try to write at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _open_closed() -> None:
    """Print to nowhere where the caller has closed the standard output or error (``>&-``), and print every text."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_WRONLY), "w", encoding="utf-8"))
    if isinstance(sys.stdout, io.TextIOWrapper):  # what a terminal cannot show is escaped, as on the standard error
        sys.stdout.reconfigure(errors="backslashreplace")
