"""Numbers of a scenario that cannot exist together, and names that clash."""

from collections import Counter

import numpy as np

from gyrostat.core.errors import InputError, placed
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario.numbers import check_inertias
from gyrostat.scenario.scenario import Scenario
from gyrostat.spacecraft.flexible.appendages import APPENDAGES
from gyrostat.spacecraft.flexible.coupling import MODE_STEP
from gyrostat.wheel.friction import Friction
from gyrostat.wheel.friction_laws import law_of
from gyrostat.wheel.segment import MAX_SEGMENTS

COLUMNS = ("run", "status", "ended")
"""Columns of the table of runs beside metrics and drawn values."""


def check_possible(scenario: Scenario) -> None:
    """Validate numbers that concern several keys, and the names of windows.

    Raises:
        InputError: The body inertia is not above that of the rotors, a mode is too fast for the
            integration, or a window has the name of a metric.
    """
    with placed("key body.inertia"):
        check_inertias(scenario.values, scenario.wheels, scenario.axes)
    _check_modes(scenario)
    _check_names(scenario)


def _check_modes(scenario: Scenario) -> None:
    """Validate that the explicit integration resolves the modes of flexible appendages.

    The Runge-Kutta steps are shortened to `MODE_STEP` of the phase of a mode, at most
    `MAX_SEGMENTS` of them in a step of the scenario. The integration with bristles is implicit.
    """
    law = law_of(scenario.friction, scenario.sources)
    if not issubclass(law, Friction):
        return
    step = scenario.values["run.control_period"] / scenario.substeps
    most = MAX_SEGMENTS * MODE_STEP / (2.0 * np.pi * step)
    for part in scenario.parts:
        key = f"{part.section}.{part.name}.frequency"
        if part.section in APPENDAGES and scenario.values[key] > most:
            raise InputError(
                f"key {key}: found {scenario.values[key]:g} Hz, expected at most {most:g} Hz, what "
                f"the explicit integration resolves in a step of {step:g} s: use a shorter "
                "run.step, or leave out the mode"
            )


def _check_names(scenario: Scenario) -> None:
    """Validate that no window has the name of a metric, and no two columns have one name."""
    metrics = metrics_of(scenario)
    for window in scenario.windows:
        names = {*COLUMNS, *(n for n, metric in metrics.items() if metric.window is None)}
        # metrics of a window have its name in front
        ends = {n.removeprefix(f"{window.name}.") for n in metrics if n.startswith(window.name)}
        if window.name in names or window.name in ends:
            raise InputError(
                f"key metrics.window[{window.name}].name: found the name of a metric, expected "
                "another one"
            )
    counts = Counter([*COLUMNS, *metrics, *scenario.dispersed])
    duplicates = [name for name, count in counts.items() if count > 1]
    if duplicates:
        raise InputError(
            f"key {duplicates[0]}: found two columns of this name in the table of runs, expected "
            "other names of windows and metrics"
        )
