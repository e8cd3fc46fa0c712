"""Part of a page that flies runs of its scenario: sliders, the compiled program and its inputs."""

import base64
import gzip
import json
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from gyrostat.campaigns.draws import check_draws, draw, noise_keys, values_at
from gyrostat.campaigns.web_program import WebProgram, web_program
from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.units import RPM
from gyrostat.core.validation import LARGEST
from gyrostat.reports.axis import scaled_unit
from gyrostat.reports.fly_limits import Limit, run_limits
from gyrostat.reports.page_units import shown_unit
from gyrostat.reports.replay import MOST_FRAMES
from gyrostat.runs.designs import phases_of
from gyrostat.runs.planned_slews import keys_of_plans
from gyrostat.runs.plans import plans_of
from gyrostat.scenario.kinds.registry import numbers_of
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario.relation import Relation
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.schema import Key
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario.timeline import modes
from gyrostat.scenario_files.run_file import FIXED, relations_of_file

CLOUD = 64
"""Number of runs of the cloud: the first ones of the campaign."""
_TAIL = 1e-4
"""Share of the dispersed values beyond each end of a slider."""


class Slider(NamedTuple):
    """Slider of a value.

    Attributes:
        key: Key of the value.
        label: Key without the name of its group.
        unit: Shown unit.
        factor: Shown value over the value in SI units.
        low: Left end, SI.
        high: Right end, SI.
        is_dispersed: Whether the scenario disperses the value.
        is_designed: Whether the design of the controller or its model depends on the value.
        least: Smallest value that is flown, SI.
        most: Largest one, SI.
        expected: Allowed values, for a message.
    """

    key: str
    label: str
    unit: str
    factor: float
    low: float
    high: float
    is_dispersed: bool
    is_designed: bool
    least: float
    most: float
    expected: str


def fly_content(
    scenario: Scenario,
    seed: int,
    runs: Mapping[str, tuple[int, Vector | None]],
    say: Callable[[str], None],
) -> dict[str, Any]:
    """What the template of a page that flies needs.

    Where the program cannot be made, it has only the text why not, "lacking".

    Args:
        scenario: Scenario.
        seed: Seed of the noise and of the draws.
        runs: Name of a run in the page -> its number and its dispersed values, (keys,); None: the
            nominal ones, of one run. The page begins with the first.
        say: Called with a line if the page cannot fly.
    """
    try:
        relations = [*relations_of_file(scenario)]
        program = web_program(scenario, relations)
    except InputError as error:
        say(f"warning: the page cannot fly: {error}")
        return {"lacking": str(error)}
    nominal = np.array([scenario.values[key] for key in scenario.dispersed])
    rows = np.array([nominal if row is None else row for _, row in runs.values()])
    keys = noise_keys(seed, np.array([number for number, _ in runs.values()]))
    own = program.own_words(scenario, rows.reshape(len(runs), len(nominal)), keys)
    cloud = np.zeros((0, len(nominal) + 1), np.uint64)
    if scenario.dispersions and _are_possible(scenario, seed, say):
        values, cloud_keys = draw(scenario, seed, np.arange(CLOUD))
        cloud = np.column_stack([np.ascontiguousarray(values).view(np.uint64), cloud_keys])
    words = np.concatenate([program.shared, own.ravel(), cloud.ravel()])
    every, coupled = sliders(scenario, program, rows, relations)
    about = {
        **program.about,
        "coupled": coupled,
        "sliders": {each.key: each._asdict() for each in every},
        "keys": [*scenario.values],
        "dispersed": [[*scenario.values].index(key) for key in scenario.dispersed],
        "metrics": _metric_rows(scenario),
        "runs": [[name, None if row is None else number] for name, (number, row) in runs.items()],
        "nominal": [row is None for _, row in runs.values()].index(True),
        "moving": scenario.reference != "fixed",
        "cloud": len(cloud),
        "seed": seed,
        "torque": shown_unit("N·m")[0],
        "events": [event.name for event in scenario.events],
        "phases": _phases(scenario),
        "frames": MOST_FRAMES,
        "modes": modes(scenario.parts),
        "name": scenario.name,
        "scenario": scenario.text(),
    }
    return {
        "about": _packed(json.dumps(about, ensure_ascii=False, allow_nan=False).encode()),
        "module": _packed(program.module),
        "words": _packed(words.tobytes()),
        "runs": [*runs],
        "cloud": len(cloud),
        "groups": _groups(scenario, every),
        "left_out": len(scenario.requirements),
    }


def _are_possible(scenario: Scenario, seed: int, say: Callable[[str], None]) -> bool:
    """Whether the draws of all runs of the cloud are allowed values."""
    try:
        check_draws(scenario, seed, CLOUD)
    except InputError as error:
        say(f"warning: the page has no {CLOUD} runs: {error}")
        return False
    return True


def _packed(content: bytes) -> str:
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode()


def _metric_rows(scenario: Scenario) -> list[list[Any]]:
    """Name, factor from SI and shown unit of each metric."""
    metrics = metrics_of(scenario)
    return [[name, *shown_unit(each.unit)] for name, each in metrics.items()]


def _phases(scenario: Scenario) -> list[list[Any]]:
    """Target attitude of each phase, and the keys whose sum is its start; the first has none."""
    slews = {event.name: event.target for event in scenario.events}
    phases: list[list[Any]] = [[scenario.target, []]]
    for event in phases_of(structure_of(scenario)):
        prefix = f"event.{event.name}"
        keys = [f"{prefix}.{name}" for name in ("time", "detected_after")]
        target = slews[event.name] or phases[-1][0]
        phases.append([target, [key for key in keys if key in scenario.values]])
    return phases


def sliders(
    scenario: Scenario, program: WebProgram, rows: Matrix, relations: Sequence[Relation]
) -> tuple[list[Slider], Sequence[tuple[str, str]]]:
    """Sliders of the values that a program reads and that have a range.

    Args:
        scenario: Scenario.
        program: Its program.
        rows: Dispersed values of the runs in the page, (runs, keys), which are within the ranges.
        relations: Relations that the values must fulfil.

    Returns:
        Sliders; pairs of keys of which only one can be moved, see `RunLimits`.
    """
    entries = numbers_of(scenario)
    planned = keys_of_plans(scenario, plans_of(scenario))
    shares = np.tile([[_TAIL], [1.0 - _TAIL]], len(scenario.dispersed))
    dispersed = np.concatenate([rows, values_at(scenario, shares)])
    spread = dict(zip(scenario.dispersed, dispersed.T, strict=True))
    ranges: dict[str, tuple[float, float, float, float]] = {}
    for key in program.read:
        entry, value = entries[key], scenario.values[key]
        fixed = key.startswith(FIXED) or key in planned or entry.is_text
        if fixed or not math.isfinite(value):
            continue
        if key in spread:
            low, high = float(spread[key].min()), float(spread[key].max())
        else:
            low, high = _range(scenario, key, entry)
        if low < high:
            # a value of almost 0 in place of 0, if that is not allowed
            least = entry.least + (1e-9 * (value - entry.least) if entry.positive else 0.0)
            ranges[key] = low, high, max(least, -LARGEST), min(entry.most, LARGEST)
    limits = run_limits(scenario, ranges, relations)
    return [
        _slider(key, entries[key], ranges[key], limits.ends[key], spread, program.designed)
        for key in ranges
    ], limits.coupled


def _slider(
    key: str,
    entry: Key,
    ends: tuple[float, float, float, float],
    limits: tuple[Limit, Limit],
    dispersed: Collection[str],
    designed: Collection[str],
) -> Slider:
    low, high, *_ = ends
    unit, factor = _unit(key, entry, max(abs(low), abs(high)))
    label = key.split(".", _depth(key))[-1]
    expected = entry.range()
    for word, end, allowed in zip(("least", "most"), limits, ends[2:], strict=True):
        if end.value != allowed:
            expected += f"; at {word} {end.value:g}, {end.why or 'the end of what this page flies'}"
    flags = key in dispersed, key in designed
    least, most = (end.value for end in limits)
    return Slider(key, label, unit, factor, low, high, *flags, least, most, expected)


def _range(scenario: Scenario, key: str, entry: Key) -> tuple[float, float]:
    """Range of a value that is not dispersed: from 0 to twice the value, where it may be."""
    value = scenario.values[key]
    size = abs(value)
    if key.startswith("body.inertia."):  # any combination is the inertia of a body
        size = 0.1 * max(abs(scenario.values[f"body.inertia.{end}"]) for end in _MAIN)
        size = min(size, 0.5 * abs(value)) if key[-2:] in _MAIN else 0.2 * size
    elif size == 0.0:
        size = max(abs(scenario.values[k]) for k in _beside(scenario, key))
    low, high = value - size, value + size
    if key.startswith("event.") and key.endswith(".time"):
        low, high = _between(scenario, key)
    if key.endswith(".speed") and key.startswith("wheel."):
        stem = key.removesuffix("speed")
        most = scenario.values[f"{stem}momentum_limit"] / scenario.values[f"{stem}inertia"]
        low, high = max(low, -most), min(high, most)
    least = entry.least + 0.01 * size if entry.positive else entry.least
    return max(low, least), min(high, entry.most)


_MAIN = ("xx", "yy", "zz")


def _beside(scenario: Scenario, key: str) -> Iterable[str]:
    """Keys of the other components of a vector, or of the other wheels."""
    parts = key.split(".")
    if parts[-1] in ("x", "y", "z"):
        return [k for k in scenario.values if k.rsplit(".", 1)[0] == key.rsplit(".", 1)[0]]
    if parts[0] == "wheel":
        return [f"wheel.{wheel}.{'.'.join(parts[2:])}" for wheel in scenario.wheels]
    return [key]


def _between(scenario: Scenario, key: str) -> tuple[float, float]:
    """Range of the time of an event: the events keep their order."""
    names = [f"event.{event.name}.time" for event in scenario.events]
    times = [0.0, *(scenario.values[name] for name in names), scenario.duration]
    at = names.index(key) + 1
    low, high = (0.5 * (times[at] + times[at + step]) for step in (-1, 1))
    return (0.0 if at == 1 else low), (times[-1] if at == len(names) else high)


def _unit(key: str, entry: Key, largest: float) -> tuple[str, float]:
    """Shown unit of a value, and the factor from SI."""
    if entry.dimension == "speed" and key.startswith("wheel."):
        return "rpm", 1.0 / RPM
    factor, unit = shown_unit(entry.unit)
    if factor == 1.0:
        factor, unit = scaled_unit(largest, unit)
    return unit, factor


def _depth(key: str) -> int:
    """Number of parts of the name of the group of a key."""
    return 2 if key.startswith(("wheel.", "event.")) else 1


def _groups(scenario: Scenario, each: Sequence[Slider]) -> list[tuple[str, list[Slider]]]:
    """Sliders by group: the dispersed ones first, with their whole keys as labels."""
    first = [slider._replace(label=slider.key) for slider in each if slider.is_dispersed]
    groups = {"dispersed values": first} if first else {}
    for slider in each:
        if not slider.is_dispersed:
            name = " ".join(slider.key.split(".")[: _depth(slider.key)])
            groups.setdefault(name, []).append(slider)
    return [*groups.items()]
