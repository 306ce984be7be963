"""``amorsim plan``: find a path on a map, and draw it."""

from __future__ import annotations

import io
import math
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import attrs
import typer

from amorsim.cli.console import compile_once, compile_planners_once, complain, say
from amorsim.cli.options import Resolution

if TYPE_CHECKING:
    from amorsim.contracts import Plan, Planner
    from amorsim.core.maps.map import Map
    from amorsim.core.shapes import Shape

__all__ = ["command"]

NO_PATH = 1  # the exit status
_MANY = 10_000_000  # cells of a map, from which on planning on them takes long
_COARSE = 0.05  # [m] side of a cell instead
_QUICK = 5.0  # [s] a plan that took less is made a second time, for its time without what is kept after it


def command(
    source: Annotated[
        str,
        typer.Argument(
            metavar="MAP",
            help="A map of any format, a scenario (.toml, or a bundled one) for its map, or a world generator: office, "
            "maze, cave ...",
        ),
    ],
    start: Annotated[
        str, typer.Option("--from", metavar="X,Y[,DEG]", help="The start [m], and its heading in degrees.")
    ],
    goal: Annotated[str, typer.Option("--to", metavar="X,Y[,DEG]", help="The goal.")],
    planner: Annotated[
        str,
        typer.Option(
            metavar="NAME", help="The planner; `amorsim plugins` lists them. One of your own is FILE.py:NAME."
        ),
    ] = "a_star",
    footprint: Annotated[
        str | None,
        typer.Option(
            metavar="SIZE", help="The robot's footprint [m]: the radius of a disc, or LENGTHxWIDTH. [default: a point]"
        ),
    ] = None,
    robot: Annotated[
        str | None, typer.Option(metavar="MODEL", help="A robot whose footprint it is, such as pioneer2dx.")
    ] = None,
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="A parameter of the planner, as in cell=0.05, or with a dot in it one of the map, as in "
            "world.threshold=0.5; may be given again. `amorsim plugins show a_star` lists the planner's.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Seed of a generated world.")] = 0,
    resolution: Resolution = None,
    out: Annotated[Path, typer.Option("-o", "--out", metavar="FILE", help="The picture to write.")] = Path("plan.png"),
    force: Annotated[bool, typer.Option("--force", help="Replace a picture that is there.")] = False,
) -> None:
    """Find a path on a map, print its length, the time it took and its status, and draw it.

    The exit status is 1 if there is no path; see the message. A minus sign needs an equals sign: --from=-1,2.
    """
    from amorsim.core.errors import AmorsimError
    from amorsim.core.files.atomic_files import check_place
    from amorsim.core.files.reading import is_file
    from amorsim.runs.scenario_argument import look_up_world, read_any_world
    from amorsim.scenario.reading.planners import read_planner

    ends = (_place("--from", start), _place("--to", goal))
    body = _shape(footprint, robot)
    of_planner = [change for change in changes or () if "." not in change.partition("=")[0]]
    of_world = [change for change in changes or () if change not in of_planner]
    made = read_planner(planner, of_planner)
    if is_file(out) and not force:
        raise AmorsimError(f"{out} is there already; --force replaces it, -o names another file")
    check_place(out)
    _check_picture(out)
    compile_once(lambda: look_up_world(source, seed=seed, resolution=resolution, changes=of_world))
    world = read_any_world(source, seed=seed, resolution=resolution, changes=of_world)
    for warning in world.warnings:
        complain(f"{world.name}: {warning}")
    made = _with_cells(made, world)
    compile_planners_once([made])
    plan, took, first = _timed(made, world, ends, body)
    once = f" ({_in_time(first)} with what is kept for the next plan)" if first > 2.0 * took and first > 0.01 else ""
    if plan.status == "found":
        parts = [f"length {plan.length:.3f} m"]
        if math.isfinite(plan.cost) and abs(plan.cost - plan.length) > 1e-6 * plan.length:
            parts.append(f"cost {plan.cost:.3f}")
        complaint = ""
    else:
        parts, complaint = [], plan.message
    say(f"{plan.status}: {', '.join([*parts, f'{plan.expanded} expanded'])}, {_in_time(took)}{once}")
    if complaint:
        complain(complaint)
    _draw(world, plan, ends, body, out, f"{planner}: {plan.status}" + (f", {plan.length:.2f} m" if parts else ""))
    say(f"picture: {out}")
    if plan.status != "found":
        raise typer.Exit(NO_PATH)


def _with_cells(planner: Planner, world: Map) -> Planner:
    """The planner, with coarse cells if the map has very many and the user chose none."""
    rows, columns = world.shape
    if getattr(planner, "cell", 0.0) is not None or rows * columns <= _MANY or world.resolution >= _COARSE:
        return planner
    complain(f"planned on cells of {_COARSE:g} m, as the map has {columns} x {rows}; --set cell=SIDE chooses others")
    return cast("Planner", attrs.evolve(cast("Any", planner), cell=_COARSE))


def _timed(
    planner: Planner, world: Map, ends: tuple[tuple[float, ...], tuple[float, ...]], body: Shape | None
) -> tuple[Plan, float, float]:
    """The plan, the time [s] it takes, and the time of the first one, with compiling and finding the map's cells."""
    from amorsim.algorithms.plans import find_plan

    began = time.perf_counter()
    plan = find_plan(planner, world, *ends, body)
    first = took = time.perf_counter() - began
    if first < _QUICK:
        began = time.perf_counter()
        find_plan(planner, world, *ends, body)
        took = min(first, time.perf_counter() - began)
    return plan, took, first


def _in_time(seconds: float) -> str:
    return f"{seconds:.2f} s" if seconds >= 1.0 else f"{1e3 * seconds:.3g} ms"


def _place(option: str, text: str) -> tuple[float, ...]:
    """Metres and degrees as x, y [m] and heading [rad]."""
    from amorsim.core.errors import AmorsimError

    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (2, 3) or not all(map(math.isfinite, numbers)):
        raise AmorsimError(f"{option}: expected X,Y or X,Y,DEG, finite numbers, as in 1,2.5 or 1,2.5,90; got {text!r}")
    return (*numbers[:2], *map(math.radians, numbers[2:]))


def _shape(footprint: str | None, robot: str | None) -> Shape | None:
    from amorsim.core.errors import AmorsimError
    from amorsim.core.shapes import Shape

    if footprint is not None and robot is not None:
        raise AmorsimError("--footprint and --robot both say what the footprint is; expected one of them")
    if robot is not None:
        from amorsim.scenario.reading.robots import load_robot

        return load_robot(robot).shape
    if footprint is None:
        return None
    try:
        sides = [float(part) for part in footprint.lower().split("x")]
        if len(sides) == 1:
            return Shape.circle(sides[0])
        length, width = sides
        return Shape.rectangle(length, width)
    except ValueError:
        raise AmorsimError(
            f"--footprint: expected a radius [m] above 0, as in 0.25, or LENGTHxWIDTH, as in 0.5x0.4; got {footprint!r}"
        ) from None


def _check_picture(out: Path) -> None:
    """Raise if the ending is of no kind of picture that can be written in colours, by writing a small one."""
    from PIL import Image

    from amorsim.core.errors import AmorsimError

    try:
        Image.new("RGB", (1, 1)).save(io.BytesIO(), Image.registered_extensions()[out.suffix.lower()])
    except (KeyError, OSError, ValueError):
        raise AmorsimError(f"{out}: expected the name of a picture, such as plan.png") from None


def _draw(
    world: Map, plan: Plan, ends: tuple[tuple[float, ...], tuple[float, ...]], body: Shape | None, out: Path, title: str
) -> None:
    from amorsim.core.errors import AmorsimError
    from amorsim.core.files.atomic_files import replacing
    from amorsim.render.plan_picture import draw_plan

    image = draw_plan(world, plan, *ends, footprint=body, title=title)
    with replacing(out, AmorsimError) as file:
        image.save(file)
