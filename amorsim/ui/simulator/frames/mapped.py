"""The maps of a robot's estimators, as a window draws them: maps, matched scans and pose graphs."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping

import numpy as np
from PIL import Image

from amorsim.array_types import AnyArray, Array
from amorsim.simulation.simulation import Simulation
from amorsim.ui.simulator.frames.protocol import Mapped, MappedCells

__all__ = ["mapped_in", "mapped_of"]


_MOST_PIXELS = 1_000_000
_FREE, _OCCUPIED = 28, 235  # opacities; what was never seen is clear


def mapped_of(simulation: Simulation, robot: str) -> list[Mapped]:
    """The beliefs of each estimator of a robot that maps or matches, in their order."""
    frame = next(frame for frame in simulation.frames() if robot in frame.names)
    return mapped_in(frame.beliefs, list(frame.names).index(robot))


def mapped_in(found_beliefs: Mapping[str, Mapping[str, AnyArray]], row: int) -> list[Mapped]:
    """The maps in the beliefs of each estimator of a row, in their order."""
    found: list[Mapped] = []
    for name in found_beliefs:
        beliefs = found_beliefs[name]
        one: Mapped = {"estimator": name, "map": None, "scan": None, "poses": None, "edges": None}
        if "occupancy" in beliefs:
            origin, side = beliefs["occupancy_origin"][row], float(beliefs["occupancy_resolution"][row])
            one["map"] = _map(beliefs["occupancy"][row], origin, side)
        if "scan" in beliefs:
            one["scan"] = _known(beliefs["scan"][row])
        if "graph_poses" in beliefs:
            one["poses"] = _known(beliefs["graph_poses"][row])
            edges = beliefs["graph_edges"][row]
            one["edges"] = edges[edges[:, 0] >= 0].tolist()
        if any(part is not None for part in (one["map"], one["scan"], one["poses"])):
            found.append(one)
    return found


def _known(rows: Array) -> list[list[float]]:
    """The rows that have numbers, rounded to a millimetre."""
    return [[round(value, 3) for value in row] for row in rows[np.isfinite(rows).all(axis=1)].tolist()]


def _map(probability: Array, origin: Array, side: float) -> MappedCells:
    """The pose of a map, and a picture of the part that was seen: the more probable a wall, the more opaque."""
    rows, cols = (np.flatnonzero(np.isfinite(probability).any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return {"extent": [0.0, 0.0, 0.0, 0.0], "png": ""}
    part = probability[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1]
    x, y = origin + side * np.array([cols[0], rows[0]])
    extent = [float(x), float(y), float(x + side * part.shape[1]), float(y + side * part.shape[0])]
    every = int(np.ceil(np.sqrt(part.size / _MOST_PIXELS)))
    part = part[::every, ::every][::-1]
    pixels = np.zeros((*part.shape, 2), dtype=np.uint8)
    opacity = _FREE + (_OCCUPIED - _FREE) * np.nan_to_num(part)
    pixels[..., 1] = np.where(np.isfinite(part), opacity, 0.0).astype(np.uint8)
    out = io.BytesIO()
    Image.fromarray(pixels, "LA").save(out, "PNG")
    return {"extent": extent, "png": base64.b64encode(out.getvalue()).decode()}
