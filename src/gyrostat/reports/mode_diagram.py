"""Modes of a campaign: graph of the transitions with how often each was taken, and times."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from markupsafe import Markup

from gyrostat.core.text import or_none, plain
from gyrostat.reports.chart_frame import WIDTH
from gyrostat.scenario.mode_graph import GraphEdge, edges
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.timeline import branches, modes

PITCH, HIGH, WIDE = 46, 24, 116
"""Distance of two modes, and size of the box of one, in units of the diagram."""
CHARACTER = 6.5
"""Width of a character of a label."""
MOST_BEND = 140.0
"""Largest distance of an arc from the boxes."""


def modes_content(scenario: Scenario, columns: Mapping[str, Any]) -> dict[str, Any] | None:
    """Times in the modes and changes of mode in the runs of a campaign; None if none branches.

    Args:
        scenario: Scenario of the runs.
        columns: Columns of the table of runs, (runs,); runs with NaN are omitted.

    Returns:
        `modes`: of each, `name`, `share` of the runs that were in it, and `time`, median, 5 and 95
        % of these runs, s. `changes`: of each, `name`, `start` (several modes), `to`, `share` of
        the runs that took it, `mean` number of times in a run, and `most`.
    """
    if not branches(scenario.parts):
        return None
    rows = []
    for name in modes(scenario.parts):
        time = _finite(columns[f"mode.{name}.time"])
        inside = time[time > 0.0]
        quantiles = np.percentile(inside, (50.0, 5.0, 95.0)) if len(inside) else [np.nan] * 3
        rows.append(
            {
                "name": name,
                "share": _mean(time > 0.0),
                "time": [or_none(float(value)) for value in quantiles],
            }
        )
    changes: dict[str, dict[str, Any]] = {}
    for edge in edges(scenario):
        if edge.name not in changes:
            taken = _finite(columns[f"change.{edge.name}"])
            changes[edge.name] = {
                "name": edge.name,
                "start": [],
                "to": edge.to,
                "share": _mean(taken > 0.0),
                "mean": _mean(taken),
                "most": int(np.max(taken, initial=0.0)),
            }
        changes[edge.name]["start"].append(edge.start)
    return {"modes": rows, "changes": list(changes.values())}


def _finite(column: Any) -> Any:
    values = np.asarray(column, dtype=float)
    return values[np.isfinite(values)]


def _mean(values: Any) -> float:
    return float(np.mean(values)) if len(values) else 0.0


def mode_diagram(scenario: Scenario, content: Mapping[str, Any]) -> Markup:
    """Graph of the modes: those that follow in the file downward on the right, back on the left.

    Each arc has the share of the runs that took it; with an asterisk, the share of those that took
    the transition from any of several modes.

    Args:
        scenario: Scenario of the runs.
        content: Result of `modes_content`.
    """
    names = modes(scenario.parts)
    shares = {change["name"]: change["share"] for change in content["changes"]}
    several = {change["name"] for change in content["changes"] if len(change["start"]) > 1}
    pairs: dict[tuple[str, str], list[GraphEdge]] = {}
    for edge in edges(scenario):
        pairs.setdefault((edge.start, edge.to), []).append(edge)
    arcs, labels = [], []
    bend = min(30.0, MOST_BEND / max(1, len(names) - 1))
    # those that are taken are drawn above the others
    order = sorted(pairs.items(), key=lambda pair: max(shares[edge.name] for edge in pair[1]))
    for (start, to), group in order:
        begin, end = names.index(start), names.index(to)
        share = max(shares[edge.name] for edge in group)
        text = ", ".join(
            percent_of(shares[edge.name], 2) + ("*" if edge.name in several else "")
            for edge in group
            if shares[edge.name] > 0.0 or share == 0.0
        )
        title = ", ".join(f"{edge.name}: {percent_of(shares[edge.name])}" for edge in group)
        arc, label = _arc(begin, end, bend, share, f"{start} to {to}; {title}", text)
        arcs.append(arc)
        labels.append(label)
    boxes = [_box(row, name) for row, name in zip(range(len(names)), content["modes"], strict=True)]
    head = Markup(
        '<svg class="chart diagram" viewBox="0 0 {} {}" role="img" aria-label="graph of the modes">'
    ).format(WIDTH, PITCH * len(names))
    return Markup("").join([head, *arcs, *boxes, *labels, Markup("</svg>")])


def percent_of(share: float, digits: int = 3) -> str:
    """Share of the runs in percent, in which 100 % and never are exact."""
    if share in (0.0, 1.0):
        return "100 %" if share else "never"
    text = plain(100.0 * share, digits)
    return f"{text} %" if float(text) < 100.0 else f"> {100.0 - 10.0 ** (2 - digits):g} %"


def _box(row: int, mode: Mapping[str, Any]) -> Markup:
    """Box of a mode with its name."""
    middle = PITCH * (row + 0.5)
    kind = "node" if mode["share"] > 0.0 else "node unused"
    name = mode["name"] if len(mode["name"]) <= 17 else f"{mode['name'][:16]}…"
    return Markup(
        '<g><title>{}: {}</title><rect class="{}" x="{:g}" y="{:g}" width="{}" height="{}" rx="5"/>'
        '<text class="x" x="{:g}" y="{:g}">{}</text></g>'
    ).format(
        *(mode["name"], percent_of(mode["share"]), kind),
        *(0.5 * (WIDTH - WIDE), middle - 0.5 * HIGH, WIDE, HIGH),
        *(0.5 * WIDTH, middle + 4.0, name),
    )


def _arc(
    begin: int, end: int, bend: float, share: float, title: str, text: str
) -> tuple[Markup, Markup]:
    """Arc with an arrow from one row to another, and its label."""
    side = 1.0 if end > begin else -1.0
    edge = 0.5 * (WIDTH + side * WIDE)
    # those that leave a box and those that come in have ends of their own
    apart = 5.0 * side if begin != end else 8.0
    low, high = PITCH * (begin + 0.5) + apart, PITCH * (end + 0.5) - apart
    out = edge + side * bend * max(abs(end - begin), 0.8) * 4.0 / 3.0
    width = 1.0 + 3.0 * share
    kind = "arc" if share > 0.0 else "arc unused"
    tip = edge + side * 7.0
    arc = Markup(
        '<g><title>{}</title><path class="{}" stroke-width="{:.2f}" '
        'd="M{:.1f} {:.1f}C{:.1f} {:.1f} {:.1f} {:.1f} {:.1f} {:.1f}"/>'
        '<path class="{}" d="M{:.1f} {:.1f}l{:.1f} -4.5v9Z"/></g>'
    ).format(
        *(title, kind, width, edge, low, out, low, out, high, tip, high),
        *(kind.replace("arc", "tip"), edge, high, side * 8.0),
    )
    # on its own arc, so that it is away from the others
    x = edge + side * bend * max(abs(end - begin), 0.8)
    quiet = "" if share > 0.0 else " quiet"
    y, wide = 0.5 * (low + high), CHARACTER * len(text)
    label = Markup(
        '<rect class="plate" x="{:.1f}" y="{:.1f}" width="{:.1f}" height="12"/>'
        '<text class="mark{}" x="{:.1f}" y="{:.1f}" text-anchor="middle">{}</text>'
    )
    return arc, label.format(x - 0.5 * wide, y - 6.0, wide, quiet, x, y + 4.0, text)
