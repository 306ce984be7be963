"""The keys of a ROS map's YAML file, with the lines they are in."""

from __future__ import annotations

import math
from collections.abc import Mapping

import attrs
import yaml

from amorsim.core.errors import MapError, did_you_mean

__all__ = ["MapYaml", "parse_map_yaml"]

_KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode")
_REQUIRED = ("image", "resolution", "origin")
_MODES = ("trinary", "scale", "raw")
_FLAGS = {"0": False, "1": True, "false": False, "true": True, "no": False, "yes": True}


@attrs.frozen(kw_only=True)
class MapYaml:
    """The file's content, checked, with the `lines` of its keys."""

    image: str
    resolution: float  # [m]
    origin: tuple[float, float, float]  # [m, m, rad]
    negate: bool
    occupied_thresh: float
    free_thresh: float
    mode: str
    remarks: tuple[str, ...]
    lines: Mapping[str, int]


def parse_map_yaml(text: str) -> MapYaml:
    """The content of a YAML file about a map.

    Thresholds that are missing are those of `map_server`, 0.65 and 0.196. Keys that no map has are remarked on.

    Raises
    ------
    MapError
        If it is not YAML, a key is missing or doubled, or a value is none that the key may have; with the line.
    """
    nodes, remarks = _top(text)
    for key in _REQUIRED:
        if key not in nodes:
            raise MapError(
                f"{key!r} is missing{''.join(f' ({each})' for each in remarks)}; the YAML file of a ROS map has "
                f"{', '.join(_REQUIRED)} at least, and a scenario is a .toml file"
            )
    image = _text(nodes["image"], "image", "the path of a picture")
    resolution = _number(nodes["resolution"], "resolution")
    if resolution <= 0.0:
        raise MapError(f"{_at(nodes['resolution'])}: resolution is {resolution:g}; expected more than 0 m")
    low, high = (
        _probability(nodes[key], key, default) if key in nodes else default
        for key, default in (("free_thresh", 0.196), ("occupied_thresh", 0.65))
    )
    if low > high:
        at = _at(nodes.get("free_thresh", nodes.get("occupied_thresh")))
        raise MapError(f"{at}: free_thresh {low:g} is above occupied_thresh {high:g}")
    mode = _text(nodes["mode"], "mode", "a mode").lower() if "mode" in nodes else "trinary"
    if mode not in _MODES:
        raise MapError(
            f"{_at(nodes['mode'])}: mode is {mode!r}; expected {', '.join(_MODES[:-1])} or {_MODES[-1]}."
            f"{did_you_mean(mode, _MODES)}"
        )
    negate = _text(nodes["negate"], "negate", "0 or 1").lower() if "negate" in nodes else "0"
    if negate not in _FLAGS:
        raise MapError(f"{_at(nodes['negate'])}: negate is {negate!r}; expected 0 or 1")
    return MapYaml(
        image=image,
        resolution=resolution,
        origin=_origin(nodes["origin"]),
        negate=_FLAGS[negate],
        occupied_thresh=high,
        free_thresh=low,
        mode=mode,
        remarks=remarks,
        lines={key: node.start_mark.line + 1 for key, node in nodes.items()},
    )


def _top(text: str) -> tuple[dict[str, yaml.Node], tuple[str, ...]]:
    """The values of a map's keys, and remarks on other keys. No value is built, so aliases cannot multiply."""
    try:
        top = yaml.compose(text, yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"line {mark.line + 1}: " if mark is not None else ""
        raise MapError(f"{where}this is not YAML: {error.problem or error.context}") from error
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        raise MapError(f"this is not YAML: {type(error).__name__}") from error
    if not isinstance(top, yaml.MappingNode):
        raise MapError("this is not a YAML file of a ROS map, which has lines such as 'resolution: 0.05'")
    nodes: dict[str, yaml.Node] = {}
    others = []
    for key, value in top.value:
        name = key.value if isinstance(key, yaml.ScalarNode) else ""
        if name in nodes:
            raise MapError(f"{_at(key)}: a second {name!r}; the first is in {_at(nodes[name])}")
        if name in _KEYS:
            nodes[name] = value
        else:
            others.append(f"{_at(key)}: {name[:40]!r} is not a key of a ROS map.{did_you_mean(name[:40], _KEYS)}")
    more = f" ({len(others) - 1} more such keys)" if len(others) > 1 else ""
    return nodes, (others[0] + more,) if others else ()


def _at(node: yaml.Node | None) -> str:
    return "the file" if node is None else f"line {node.start_mark.line + 1}"


def _text(node: yaml.Node, key: str, expected: str) -> str:
    if not isinstance(node, yaml.ScalarNode) or not node.value.strip():
        raise MapError(f"{_at(node)}: {key}: expected {expected}")
    return str(node.value).strip()


def _number(node: yaml.Node, key: str) -> float:
    text = node.value if isinstance(node, yaml.ScalarNode) else ""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        shown = repr(text[:40]) if text else "not a number"
        raise MapError(f"{_at(node)}: {key} is {shown}; expected a finite number")
    return value


def _probability(node: yaml.Node, key: str, usual: float) -> float:
    value = _number(node, key)
    if not 0.0 <= value <= 1.0:
        raise MapError(f"{_at(node)}: {key} is {value:g}; expected 0 to 1, a probability, such as {usual:g}")
    return value


def _origin(node: yaml.Node) -> tuple[float, float, float]:
    if not isinstance(node, yaml.SequenceNode) or len(node.value) not in (2, 3):
        raise MapError(f"{_at(node)}: origin: expected [x, y, yaw] in metres and radians")
    x, y, *yaw = (_number(item, "origin") for item in node.value)
    return x, y, yaw[0] if yaw else 0.0
