"""File of one run, run.json, that a page which flies a scenario gives: scenario and values."""

import json
import math
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from gyrostat.core.errors import InputError, placed
from gyrostat.core.text import shortened
from gyrostat.core.validation import LARGEST_SEED, check_seed
from gyrostat.runs.designs import Plans
from gyrostat.runs.planned_slews import keys_of_plans
from gyrostat.runs.plans import check_run, plans_of
from gyrostat.runs.run_relations import run_relations
from gyrostat.scenario.kinds.registry import numbers_of
from gyrostat.scenario.relation import Relation, check_relations
from gyrostat.scenario.relations import nominal_relations
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario_files.scenario_file import validated

KIND = "run"
"""Value of the key "gyrostat" of such a file."""
FIXED = ("run.", "metrics.", "window.", "orbit.")
"""Starts of the keys that the compiled program, or its tables, have as they are in the scenario."""
_MOST_LISTED = 12
_LONGEST = 40


class RunFile(NamedTuple):
    """One run of a scenario.

    Attributes:
        scenario: Scenario, for whose values the controller is designed.
        values: Key -> value of the run, SI, of the keys that differ or are dispersed.
        seed: Seed of the noise.
        run: Number of the run whose noise it has; None: that of the nominal run.
    """

    scenario: Scenario
    values: Mapping[str, float]
    seed: int
    run: int | None

    @property
    def flown(self) -> Scenario:
        """Scenario with the values of the run; its designs are not those that are flown."""
        return replace(self.scenario, values={**self.scenario.values, **self.values})

    def line(self) -> str:
        """What distinguishes the run from the nominal run of the scenario."""
        nominal = self.scenario.values
        texts = [f"{k} = {v:.9g}" for k, v in self.values.items() if v != nominal[k]]
        changed = shortened(texts, _MOST_LISTED) if texts else "those of the scenario"
        noise = "" if self.run is None else f"; noise of run {self.run}"
        return f"values of the run, SI: {changed}{noise}"


def read_run(path: str | os.PathLike[str], say: Callable[[str], None]) -> RunFile:
    """Read the file of a run.

    Args:
        path: Path of the file.
        say: Called with a line before Python files in it are executed.

    Raises:
        InputError: The file cannot be read, is not that of a run, or has a value that is not
            allowed.
    """
    path = Path(path)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: found {error}, expected the file of a run, JSON") from None
    if not isinstance(content, dict) or content.get("gyrostat") != KIND:
        raise InputError(
            f'{path}: found no "gyrostat": "{KIND}", expected the file of a run, which a page that '
            "flies a scenario gives"
        )
    with placed(str(path)):
        fields = content.get("scenario")
        numbers = fields.get("values") if isinstance(fields, dict) else None
        if not isinstance(numbers, dict):
            raise InputError("key scenario: found none, expected a scenario with its values")
        for key, value in numbers.items():
            if math.isnan(_number(value)):
                found = repr(value)[:_LONGEST]
                raise InputError(f"key scenario.values.{key}: found {found}, expected a number")
        try:
            scenario = Scenario.from_text(json.dumps(fields, ensure_ascii=False))
        except (TypeError, AttributeError, ValueError) as error:
            raise InputError(f"key scenario: found {error}, expected a scenario") from None
        if scenario.sources:
            names = ", ".join(source.path for source in scenario.sources)
            say(f"{path} has Python files in it, which are executed: {names}")
        validated(scenario)
        seed, run = content.get("seed", 0), content.get("run")
        if type(seed) is not int or not (run is None or (type(run) is int and run >= 0)):
            raise InputError(f"found seed {seed!r} and run {run!r}, expected whole numbers")
        check_seed(seed)
        if run is not None and run > LARGEST_SEED:
            raise InputError(f"key run: found {run}, expected 0 to {LARGEST_SEED}")
        values = _values(scenario, content.get("values", {}))
        plans = plans_of(scenario)
        _check_plans(scenario, plans, values)
        file = RunFile(scenario, values, seed, run)
        changed = {key for key, value in values.items() if value != scenario.values[key]}
        check_relations(
            [each for each in relations_of_file(scenario) if not changed.isdisjoint(each.keys)],
            file.flown.values,
        )
        check_run(file.flown, plans)
    return file


def relations_of_file(scenario: Scenario) -> Iterator[Relation]:
    """Relations that the values of a run in a file must fulfil, if one of them was changed.

    Args:
        scenario: Scenario of the run.
    """
    yield from run_relations(scenario)
    yield from nominal_relations(scenario)


def _check_plans(scenario: Scenario, plans: Plans, values: dict[str, float]) -> None:
    """Refuse other values of what slews around cones are planned from."""
    planned = keys_of_plans(scenario, plans)
    for key, value in values.items():
        if key in planned and value != scenario.values[key]:
            raise InputError(
                f"key values.{key}: found {value:g}, expected {scenario.values[key]:g}, "
                "from which the slews with keep_out are planned"
            )


def _number(value: Any) -> float:
    """Number of a file; NaN for anything else, also for what no float can be."""
    if not isinstance(value, int | float) or isinstance(value, bool):
        return math.nan
    try:
        return float(value)
    except OverflowError:
        return math.nan


def _values(scenario: Scenario, values: Any) -> dict[str, float]:
    if not isinstance(values, dict):
        raise InputError(f"key values: found {values!r}, expected keys with numbers")
    entries, numbers = numbers_of(scenario), {k: _number(v) for k, v in values.items()}
    for key, value in values.items():
        if key not in scenario.values:
            raise InputError(f"key values.{key}: found no such key, expected one of the scenario")
        if key.startswith(FIXED) and key not in scenario.dispersed:
            raise InputError(
                f"key values.{key}: found a value of the run, expected none: change it in the "
                "scenario, for which the program and its tables are made"
            )
        number = numbers[key]
        if entries[key].is_text and number != scenario.values[key]:
            raise InputError(f"key values.{key}: found another text, expected that of the scenario")
        if not math.isfinite(number) or not entries[key].allows(number):
            found, expected = repr(value)[:_LONGEST], entries[key].range(number)
            raise InputError(f"key values.{key}: found {found}, expected {expected}")
    return numbers
