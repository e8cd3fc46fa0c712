"""Read the [metrics] table of a scenario file and its windows, [[metrics.window]]."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

from gyrostat.core.errors import placed
from gyrostat.scenario.metrics.kinds import WINDOW, WINDOW_METRICS, keys_of_run
from gyrostat.scenario.metrics.results import percentile_name
from gyrostat.scenario.metrics.window_metric import WindowStart
from gyrostat.scenario.relation import check_relations
from gyrostat.scenario.relations import before_end, relations_of_window
from gyrostat.scenario.scenario import Event, Part, Scenario, Window
from gyrostat.scenario.schema import positive
from gyrostat.scenario.timeline import event_times, modes
from gyrostat.scenario_files.tables import Table

TEXTS = ("name", "event", "mode", "boresight", "propellant")
"""Keys of a window that are no numbers."""
_VIEW = positive("angle", None, "Field of view.", most=pi)


def read_metrics(
    top: Table, values: dict[str, float], events: Sequence[Event], parts: Sequence[Part]
) -> dict[str, Any]:
    """Read the metrics of a scenario file and add their numbers to its values.

    Args:
        top: Top-level table of the file.
        values: Full key -> number, SI; the numbers of the metrics are added.
        events: Events of the scenario.
        parts: Parts of the scenario: own metrics, modes and slews of the reference.

    Returns:
        Fields of the scenario: boresight, field of view, percentiles, budget and windows.

    Raises:
        InputError: A key is unknown or has a value that is not allowed.
    """
    extra = ("percentiles", "boresight", "field_of_view", "momentum_budget", "window")
    keys = keys_of_run(parts)
    table = top.table("metrics", (*keys, *extra))
    values |= table.numbers(keys)
    with placed(str(top.path)):
        check_relations([before_end("metrics.after")], values)
    boresight = table.unit("boresight", 3, None) if "boresight" in table.row else None
    view = table.row.get("field_of_view")
    percentiles = table.rising("percentiles", (50.0, 95.0, 99.7), 0.0, 100.0)
    for part in parts:
        if part.section == "metric" and part.name in map(percentile_name, percentiles):
            raise Table(top.path, f"metric[{part.name}].", {}).refuse(
                "name", part.name, "another name than that of a percentile"
            )
    return {
        "boresight": boresight,
        "field_of_view": None if view is None else table.allowed("field_of_view", view, _VIEW),
        "percentiles": percentiles,
        "budget": table.flag("momentum_budget"),
        "windows": _windows(table.tables("window"), boresight, values, events, parts),
    }


def with_windows(scenario: Scenario, given: Any) -> Scenario:
    """Scenario with other windows.

    Args:
        scenario: Scenario.
        given: Name of a window -> its keys, as in a scenario file.

    Raises:
        InputError: It is something else, or a key is unknown or has a value that is not allowed.
    """
    path, values = Path(scenario.name), dict(scenario.values)
    if not isinstance(given, Mapping) or not all(isinstance(v, Mapping) for v in given.values()):
        raise Table(path, "", {}).refuse("windows", given, '{"NAME": {"from": 10.0, ...}}')
    values = {key: value for key, value in values.items() if not key.startswith("window.")}
    rows = [Table(path, f"windows[{name}].", {**row, "name": name}) for name, row in given.items()]
    windows = _windows(rows, scenario.boresight, values, scenario.events, scenario.parts)
    return replace(scenario, windows=windows, values=dict(sorted(values.items())))


def _windows(
    rows: Sequence[Table],
    boresight: tuple[float, ...] | None,
    values: dict[str, float],
    events: Sequence[Event],
    parts: Sequence[Part],
) -> tuple[Window, ...]:
    """Read windows and add their numbers to the values."""
    origins = {"event": event_times(events, parts), "mode": dict.fromkeys(modes(parts))}
    windows: list[Window] = []
    names = {*(key.split(".")[0] for key in values), "window"}
    for number, row in enumerate(rows):
        expected = "a unique name without a dot that is not the name of a section"
        name = row.unique_name(str(number + 1), names, expected)
        names.add(name)
        row = Table(row.path, f"metrics.window[{name}].", row.row)
        windows.append(_window(row, name, boresight, values, origins))
    return tuple(windows)


def _window(
    row: Table,
    name: str,
    boresight: tuple[float, ...] | None,
    values: dict[str, float],
    origins: Mapping[str, Mapping[str, str | None]],
) -> Window:
    """Read a window and add its numbers to the values.

    Args:
        row: Table of the window.
        name: Name of the window.
        boresight: Boresight of the scenario.
        values: Full key -> number, SI.
        origins: Kind of origin of its times, "event" or "mode" -> known names, with the key of the
            time of an event.
    """
    row.known((*TEXTS, *WINDOW))
    entries = {key: entry for key, entry in WINDOW.items() if key in row.row}
    entries |= {key: WINDOW[key] for key in ("from", "until")}
    for kind in WINDOW_METRICS:
        if kind.asked_by in entries:
            entries |= {key: each for key, each in kind.keys.items() if each.default is not None}
    span = row.numbers(entries, "")
    event, mode = (_origin(row, kind, names) for kind, names in origins.items())
    if event is not None and mode is not None:
        raise row.refuse("mode", mode, "none beside an event")
    window = Window(
        name,
        event,
        mode,
        row.unit("boresight", 3, None) if "boresight" in row.row else None,
        row.text("propellant", None) if "propellant" in row.row else None,
    )
    key = None if event is None else origins["event"][event]
    within = {**values, **{f"window.{name}.{end}": value for end, value in span.items()}}
    with placed(str(row.path)):
        check_relations(relations_of_window(name, key), within)
    remaining = values["run.duration"] - (0.0 if key is None else values[key])
    length = min(span["until"], remaining) - span["from"]
    start = WindowStart(
        window, (), window.boresight or boresight, span, values["run.control_period"]
    )
    for kind in WINDOW_METRICS:
        kind.check(start, length, row)
    values |= {f"window.{name}.{key}": value for key, value in span.items()}
    return window


def _origin(row: Table, kind: str, names: Mapping[str, str | None]) -> str | None:
    """Name of the event or mode of a window; None if it has none."""
    if kind not in row.row:
        return None
    if not names:
        raise row.refuse(kind, row.row[kind], f"none: this scenario has no {kind}")
    return row.one_of(kind, names)
