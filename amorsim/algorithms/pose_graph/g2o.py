"""Pose graphs in g2o's text format.

Lines ``VERTEX_SE2 id x y heading`` and ``EDGE_SE2 from to dx dy dheading I11 I12 I13 I22 I23 I33``, in metres and
radians; the numbers I are the upper triangle of the information matrix. Source: R. Kümmerle et al., "g2o: A General
Framework for Graph Optimization" (2011), and its wiki's page on the file format.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from amorsim.algorithms.pose_graph.graph import PoseGraph
from amorsim.core.arguments import checked
from amorsim.core.errors import GraphError
from amorsim.core.files.atomic_files import replacing
from amorsim.core.files.reading import read_text, reason

__all__ = ["read_g2o", "write_g2o"]

_UPPER = np.triu_indices(3)
_SIZES = {"VERTEX_SE2": (1, 3), "EDGE_SE2": (2, 9)}  # whole numbers, then others


@checked
def read_g2o(path: str | Path) -> PoseGraph:
    """The pose graph in a file.

    A pose that only edges name has no place yet and is put at the origin. Lines ``FIX`` are left out: a solution is
    given with its first pose where the file has it.

    Raises
    ------
    GraphError
        If the file cannot be read, a line is not of a known kind, or a number in it makes no sense.
    """
    path = Path(path)
    try:
        text = read_text(path)
    except (OSError, ValueError) as error:
        raise GraphError(f"{path}: cannot be read: {reason(error)}") from error
    vertices: dict[int, list[float]] = {}
    pairs, numbers = [], []
    for count, line in enumerate(text.splitlines(), start=1):
        words = line.split("#")[0].split()
        if not words or words[0] == "FIX":
            continue
        names, values = _values(words, f"{path}: line {count}")
        if words[0] == "EDGE_SE2":
            pairs.append(names)
            numbers.append(values)
        elif vertices.setdefault(names[0], values) is not values:
            raise GraphError(f"{path}: line {count}: vertex {names[0]} is there already; list each once")
    for pair in pairs:
        for name in pair:
            vertices.setdefault(name, [0.0, 0.0, 0.0])
    ids = sorted(vertices)
    places = {name: place for place, name in enumerate(ids)}
    rows = np.array(numbers, dtype=np.float64).reshape(-1, 9)
    information = np.zeros((len(rows), 3, 3))
    information[:, _UPPER[0], _UPPER[1]] = rows[:, 3:]
    information[:, _UPPER[1], _UPPER[0]] = rows[:, 3:]
    edges = np.array([[places[name] for name in pair] for pair in pairs], dtype=np.int64)
    try:
        return PoseGraph.of([vertices[name] for name in ids], edges, rows[:, :3], information, ids)
    except GraphError as error:
        raise GraphError(f"{path}: {error}") from error


def _values(words: list[str], where: str) -> tuple[list[int], list[float]]:
    """The whole numbers of a line, and its other numbers."""
    if words[0] not in _SIZES:
        known = ", ".join(_SIZES)
        raise GraphError(f"{where}: {words[0]!r} is not a line of a graph in the plane; expected {known} or FIX")
    whole, others = _SIZES[words[0]]
    if len(words) != 1 + whole + others:
        raise GraphError(f"{where}: expected {whole + others} numbers after {words[0]}, got {len(words) - 1}")
    try:
        return [int(word) for word in words[1 : 1 + whole]], [float(word) for word in words[1 + whole :]]
    except ValueError as error:
        raise GraphError(f"{where}: {error}; expected numbers after {words[0]}") from None


@checked
def write_g2o(graph: PoseGraph, path: str | Path) -> None:
    """Write a pose graph into a file; a file that is there is replaced. Read again, it has the same bits.

    Raises
    ------
    GraphError
        If the file cannot be written.
    """
    path = Path(path)
    lines = [
        f"VERTEX_SE2 {name} " + " ".join(map(repr, pose))
        for name, pose in zip(graph.ids.tolist(), graph.poses.tolist(), strict=True)
    ]
    pairs = graph.ids[graph.edges].tolist()
    upper = graph.information[:, _UPPER[0], _UPPER[1]]
    numbers = np.concatenate((graph.measurements, upper), axis=1).tolist()
    for (first, second), values in zip(pairs, numbers, strict=True):
        lines.append(f"EDGE_SE2 {first} {second} " + " ".join(map(repr, values)))
    with replacing(path, GraphError) as new:
        new.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
