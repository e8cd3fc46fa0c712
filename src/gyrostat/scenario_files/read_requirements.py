"""Read the pointing requirements of a scenario file, [[requirement]]."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.validation import MOST_PERIODS
from gyrostat.scenario.metrics.schema import REQUIREMENT
from gyrostat.scenario.requirement import (
    AXES_OF_ERROR,
    INDICES,
    INSTANTS,
    INTERPRETATIONS,
    KNOWLEDGE,
    Requirement,
)
from gyrostat.scenario.scenario import Scenario, Window
from gyrostat.scenario_files.tables import Table

TEXTS = ("name", "index", "axis", "interpretation", "instant", "during", "boresight", "estimate")
"""Keys that are no numbers."""


def read_requirements(
    rows: Sequence[Table],
    boresight: tuple[float, ...] | None,
    values: Mapping[str, float],
    windows: Sequence[Window],
) -> tuple[Requirement, ...]:
    """Read pointing requirements.

    Args:
        rows: Tables of the requirements.
        boresight: Boresight of the scenario.
        values: Full key -> number, SI.
        windows: Windows of the metrics.

    Raises:
        InputError: A key is unknown or has a value that is not allowed.
    """
    requirements: dict[str, Requirement] = {}
    for row in rows:
        row.known((*TEXTS, *REQUIREMENT))
        default = str(row.row.get("index", "")).lower() or "requirement"
        name = row.unique_name(default, requirements)
        row = Table(row.path, f"requirement[{name}].", row.row)
        requirements[name] = _requirement(row, name, boresight, values, windows)
    return tuple(requirements.values())


def with_requirements(scenario: Scenario, given: Any) -> Scenario:
    """Scenario with other pointing requirements.

    Args:
        scenario: Scenario.
        given: Requirements, or their keys as in a scenario file.

    Raises:
        InputError: It is something else, or a key is unknown or has a value that is not allowed.
    """
    top = Table(Path(scenario.name), "", {})
    rows = given if isinstance(given, list | tuple) else None
    if rows is not None and all(isinstance(row, Requirement) for row in rows):
        return replace(scenario, requirements=tuple(rows))
    if rows is None or not all(isinstance(row, Mapping) for row in rows):
        raise top.refuse("requirements", given, '[{"index": "APE", ...}]')
    tables = [Table(top.path, f"requirements[{k}].", dict(row)) for k, row in enumerate(rows)]
    requirements = read_requirements(tables, scenario.boresight, scenario.values, scenario.windows)
    return replace(scenario, requirements=requirements)


def check_requirements(scenario: Scenario) -> None:
    """Validate that the windows of the requirements exist; raises `InputError`."""
    names = [window.name for window in scenario.windows]
    for each in scenario.requirements:
        for name in each.during:
            if name not in names:
                raise InputError(
                    f"key requirement[{each.name}].during: found {name!r}, expected "
                    f"{'one of ' + ', '.join(names) if names else 'none: there are no windows'}"
                )


def _requirement(
    row: Table,
    name: str,
    boresight: tuple[float, ...] | None,
    values: Mapping[str, float],
    windows: Sequence[Window],
) -> Requirement:
    index = row.one_of("index", INDICES)
    kind, operation, _ = INDICES[index]
    interpretation = row.one_of("interpretation", INTERPRETATIONS, "mixed")
    if operation == "reproducibility" and interpretation == "temporal":
        raise row.refuse(
            "interpretation", interpretation, "ensemble or mixed: PRE has no distribution over time"
        )
    during = _during(row, windows)
    axis, aim = _axis(row, boresight, [each for each in windows if each.name in during])
    applies = {
        "window": operation != "absolute",
        "stability": operation == "drift",
        "instant": operation == "relative",
        "estimate": kind == KNOWLEDGE,
        "share": interpretation == "temporal",
    }
    for key in applies:
        if key in row.row and not applies[key]:
            choice = interpretation if key == "share" else index
            raise row.refuse(key, row.row[key], f"none: {choice} does not have it")
    numbers = _numbers(row, [key for key in ("window", "stability") if applies[key]])
    requirement = Requirement(
        name=name,
        index=index,
        interpretation=interpretation,
        axis=axis,
        boresight=aim,
        instant=row.one_of("instant", INSTANTS, "any"),
        during=during,
        estimate=row.text("estimate", None) if "estimate" in row.row else None,
        **numbers,
    )
    _check_times(row, requirement, values)
    return requirement


def _axis(
    row: Table, boresight: tuple[float, ...] | None, windows: Sequence[Window]
) -> tuple[str, tuple[float, ...] | None]:
    """Axis of a requirement, and the boresight of those that need it.

    The boresight is its own, that of its windows, or that of the scenario.
    """
    boresights = {window.boresight or boresight for window in windows} or {boresight}
    if "boresight" in row.row:
        boresights = {row.unit("boresight", 3, None)}
    axis = row.one_of("axis", AXES_OF_ERROR, "full" if boresights == {None} else "half_cone")
    if axis not in ("half_cone", "about"):
        if "boresight" in row.row:
            raise row.refuse("boresight", row.row["boresight"], f"none for the axis {axis}")
        return axis, None
    if len(boresights) > 1:
        raise row.refuse("boresight", None, "one: its windows have different boresights")
    if boresights == {None}:
        raise row.refuse("boresight", None, f"a body direction [x, y, z] for the axis {axis}")
    return axis, boresights.pop()


def _numbers(row: Table, times: Sequence[str]) -> dict[str, float]:
    """Value, level, times and share of a requirement, SI; the times of its index are required."""
    required_keys = ("value", "level", *times)
    keys = {key: REQUIREMENT[key] for key in REQUIREMENT if key in row.row or key in required_keys}
    shares = {key: row.percentage(key) for key in ("level", "share")}
    values = {}
    for key, entry in keys.items():
        share = shares.get(key)
        values |= row.number(key, entry, row.row.get(key) if share is None else share, key)
    for key in shares:
        if values.get(key) == 1.0:
            raise row.refuse(
                key, row.row[key], "a probability below 1: no number of runs can show certainty"
            )
    return values


def _during(row: Table, windows: Sequence[Window]) -> tuple[str, ...]:
    """Names of the windows of the observation periods."""
    value = row.row.get("during", [])
    names = [value] if isinstance(value, str) else value
    choices = [window.name for window in windows]
    if (
        not isinstance(names, list | tuple)
        or not all(isinstance(name, str) and name in choices for name in names)
        or len(set(names)) < len(names)
    ):
        raise row.refuse(
            "during", value, f"windows of the metrics: {', '.join(choices) or 'there are none'}"
        )
    return tuple(names)


def _check_times(row: Table, requirement: Requirement, values: Mapping[str, float]) -> None:
    """Validate the times of a requirement, and that its index can exist; raises `InputError`."""
    period, index = values["run.control_period"], requirement.index
    for key in ("window", "stability"):
        time = getattr(requirement, key)
        if time > 0.0:
            periods = row.multiple(key, time, "control period", period, MOST_PERIODS)
            if key == "window" and requirement.instant == "centre" and periods % 2:
                raise row.refuse(
                    key, row.row[key], "an even number of control periods for the instant centre"
                )
    if 0.0 < requirement.stability < requirement.window:
        raise row.refuse(
            "stability", row.row["stability"], f"at least the window, {requirement.window:g} s"
        )
    span = requirement.window + requirement.stability
    longest = max(
        (_length(name, values) for name in requirement.during),
        default=values["run.duration"] - values["metrics.after"],
    )
    if span > longest * (1.0 + 1e-9):
        raise row.refuse(
            "window",
            row.row.get("window"),
            f"{span:g} s of {index} to fit in an observation period of {longest:g} s",
        )
    if requirement.operation == "reproducibility" and not requirement.during:
        raise row.refuse(
            "during", None, "windows of the metrics: PRE compares separate observation periods"
        )


def _length(name: str, values: Mapping[str, float]) -> float:
    """Longest time that a window can have in a nominal run, s."""
    begin, end = (values[f"window.{name}.{key}"] for key in ("from", "until"))
    return min(end, values["run.duration"]) - begin
