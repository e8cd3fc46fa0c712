"""File of one run, run.json, that a page which flies a scenario gives: scenario and values."""

import json
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from gyrostat.core.errors import InputError, placed
from gyrostat.core.validation import check_seed
from gyrostat.scenario.kinds.registry import numbers_of
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario_files.scenario_file import validated

KIND = "run"
"""Value of the key "gyrostat" of such a file."""


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
        text = json.dumps(content.get("scenario"), ensure_ascii=False)
        try:
            scenario = Scenario.from_text(text)
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
        values = _values(scenario, content.get("values", {}))
        # what a scenario with these values may not be, such as an inertia of no body
        validated(replace(scenario, values={**scenario.values, **values}))
    return RunFile(scenario, values, seed, run)


def _values(scenario: Scenario, values: Any) -> dict[str, float]:
    if not isinstance(values, dict):
        raise InputError(f"key values: found {values!r}, expected keys with numbers")
    entries = numbers_of(scenario)
    for key, value in values.items():
        if key not in scenario.values:
            raise InputError(f"key values.{key}: found no such key, expected one of the scenario")
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not is_number or not math.isfinite(value) or not entries[key].allows(value):
            expected = entries[key].range(value if is_number else math.nan)
            raise InputError(f"key values.{key}: found {value!r}, expected {expected}")
    return {key: float(value) for key, value in values.items()}
