"""The table as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from benchmarks.published import PLAIN_FLOOR, PLAIN_THERE
from benchmarks.results import Conduct, Row, spread_of

__all__ = ["TITLES", "as_text", "figure", "plain_says"]

TITLES: Mapping[str, str] = {
    "rays": "Ray casting",
    "fleet": "Robot-steps",
    "compositions": "What a robot costs that differs from the shipped Pioneer in one thing",
    "mixed": "A mixed fleet",
    "crowd": "A crowd",
    "memory": "Memory and loading",
    "maps": "Maps and worlds",
    "start": "Start-up and files",
    "filters": "Filters",
    "mapping": "Mapping",
    "graphs": "Pose graphs",
    "planners": "Planners",
    "avoiders": "Avoiders",
    "studies": "Studies",
    "learning": "Environments for learners",
}
_HEAD = ("setting", "side", "median", "least to most", "unit", "amorsim is", "counts", "what it did")


def as_text(
    rows: Sequence[Row], about: dict[str, str], command: str, plain_rates: Sequence[float], remarks: Sequence[str]
) -> str:
    """The whole table: circumstances, how to read it, a table a section, and what each side computes."""
    lines = [f"amorsim's benchmarks: {command}", ""]
    lines += [f"{name + ':':12} {value}" for name, value in about.items()]
    lines += [
        "",
        "'amorsim is' is a ratio, taken in each round and then the median (least to most): of rates amorsim's over the",
        "other's, of times the other's over amorsim's; above 1 amorsim is faster. It counts only if both sides moved",
        "as far, evaluated all beams, and agree in mean range to 1 %, in the first scans and over the way.",
    ]
    if plain_rates:
        lines += ["", plain_says(plain_rates)]
    lines += ["", *remarks] if remarks else []
    for section, title in TITLES.items():
        found = [row for row in rows if row.section == section]
        if found:
            lines += ["", title, "=" * len(title), "", *_grid([_HEAD, *(_cells(row) for row in found)])]
    lines += ["", "What each side computes", "=======================", ""]
    said: dict[tuple[str, str], None] = {}
    for row in rows:
        if row.note:
            said.setdefault((row.side, f"{row.setting}: {row.note}" if _is_own(row) else row.note))
    lines += [f"- {side}: {note}" for side, note in said]
    return "\n".join(lines) + "\n"


def plain_says(rates: Sequence[float]) -> str:
    """Whether the yardstick itself is fast enough."""
    here = spread_of(rates)
    holds = (
        "which is what the yardstick must do"
        if here.median >= PLAIN_FLOOR
        else "less than the yardstick must do where PEERS' figures hold: this machine is slower, or busy"
    )
    return (
        f"The plain traversal casts {here.median / 1e6:.2f} million rays a second on 5 cm cells "
        f"({here.low / 1e6:.2f} to {here.high / 1e6:.2f}; at least {PLAIN_FLOOR / 1e6:g}), {holds}. "
        f"Published figures are scaled by it: it did {PLAIN_THERE / 1e6:g} million there."
    )


def figure(value: float) -> str:
    """Three digits, with k and M for thousands and millions."""
    for factor, sign in ((1e6, " M"), (1e3, " k")):
        if abs(value) >= factor:
            return f"{value / factor:.3g}{sign}"
    return f"{value:.3g}"


def _is_own(row: Row) -> bool:
    return (
        row.section in ("compositions", "mixed", "crowd", "memory", "maps", "start", "planners", "studies", "learning")
        or "costs" in row.note
        or row.side == "plain traversal"
    )


def _cells(row: Row) -> tuple[str, ...]:
    spread, ratio = row.spread, row.ratio
    times, counts = "", ""
    if ratio is not None:
        one = ratio.spread
        times = f"{one.median:.3g} x ({one.low:.3g} to {one.high:.3g})"
        counts = "yes" if ratio.counts else f"no: {ratio.why_not}"
    return (
        row.setting,
        row.side,
        "" if spread is None else figure(spread.median),
        "" if spread is None else f"{figure(spread.low)} to {figure(spread.high)}",
        row.unit,
        times,
        counts,
        _did(row.conduct),
    )


def _did(conduct: Conduct | None) -> str:
    if conduct is None:
        return ""
    words = []
    if conduct.mean_range is not None:
        words.append(f"mean range {conduct.mean_range:.3f} m")
    if conduct.distance is not None:
        words.append(f"drove {conduct.distance:.3f} m in {conduct.steps} steps")
    if conduct.stopped is not None:
        words.append(f"{conduct.stopped:.0%} stood")
    return ", ".join(words)


def _grid(lines: Sequence[tuple[str, ...]]) -> list[str]:
    widths = [max(len(line[column]) for line in lines) for column in range(len(lines[0]))]
    made = ["  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in lines]
    return [made[0], "  ".join("-" * width for width in widths), *made[1:]]
