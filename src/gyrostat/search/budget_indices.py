"""Pointing indices of a budget of a scenario without pointing requirements."""

from collections.abc import Iterable

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.scenario.requirement import Requirement
from gyrostat.scenario.scenario import Scenario

RUN = "run"
"""Name of the whole run among the windows."""
VALUE, LEVEL = float(np.radians(0.01)), 0.95
"""Middle of the sizes that are counted, rad, and share of the time below the size that is given."""


def default_indices(scenario: Scenario, windows: Iterable[str] = ()) -> tuple[Requirement, ...]:
    """Absolute error in each window, and the relative error over its exposure time if it has one.

    Args:
        scenario: Scenario without pointing requirements.
        windows: Windows of the metrics, or "run"; none: all windows, without any the run.

    Raises:
        InputError: There is no such window.
    """
    known = [window.name for window in scenario.windows]
    names = list(dict.fromkeys(windows)) or known or [RUN]
    for name in names:
        if name not in (*known, RUN):
            raise InputError(
                f"--window: found {name!r}, expected one of {', '.join((*known, RUN))}"
            )
    return tuple(each for name in names for each in _of_window(scenario, name))


def _of_window(scenario: Scenario, name: str) -> list[Requirement]:
    boresight, during, end = scenario.boresight, (), ""
    for window in scenario.windows:
        if window.name == name:
            boresight, during, end = window.boresight or boresight, (name,), f"_{name}"
    axis = "full" if boresight is None else "half_cone"
    about = {"axis": axis, "boresight": boresight, "during": during}
    indices = [Requirement(f"ape{end}", "APE", VALUE, LEVEL, **about)]
    exposure = float(scenario.values.get(f"window.{name}.exposure", np.inf))
    periods = exposure / scenario.values["run.control_period"]
    if during and np.isfinite(periods) and abs(periods - round(periods)) < 1e-6 <= periods:
        indices.append(Requirement(f"rpe{end}", "RPE", VALUE, LEVEL, window=exposure, **about))
    return indices
