"""Pointing budget of a group of runs, collected during the simulation."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaigns.pointing.collected import Collected, Moments, Profile
from gyrostat.campaigns.pointing.indices import Part, parts_of
from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.requirement import signals_of
from gyrostat.scenario.scenario import Scenario

PROFILED = 1000
"""Number of runs whose errors over time are kept: the first ones, drawn like any other."""
ERROR_PROFILE = "error.profile"
"""Column with the pointing error at the times of a profile."""


def profile_name(metric: str) -> str:
    """Column with the index of a requirement over time."""
    return f"{metric}.profile"


def counts_name(metric: str) -> str:
    """Column with the shares of time of a mixed requirement."""
    return f"{metric}.shares"


def size_name(metric: str) -> str:
    """Column with the size at the level of the index of a requirement in each run."""
    return f"{metric}.size"


class PointingBudget:
    """Values of all pointing requirements in a group of runs, and profiles of errors over time.

    Args:
        scenario: Scenario.
        runs: Number of runs.
        samples: Number of samples that arrive of each run, at least those of a run.
        group: Number of runs of the whole group, see `collectors`.
        moments: Whether `moments` is asked for.
    """

    def __init__(
        self, scenario: Scenario, runs: int, samples: int, group: int, *, moments: bool = False
    ):
        period = scenario.values["run.control_period"]
        windows = ["", *(window.name for window in scenario.windows)]
        signals = signals_of(scenario.requirements)
        self._next = 0
        self._error = Profile(runs, scenario.count + 1)
        self._entries = []
        # they share the memory for the values of a group
        temporal = [each for each in scenario.requirements if each.interpretation == "temporal"]
        group *= max(len(temporal), 1)
        for each in scenario.requirements:
            places = [windows.index(name) for name in each.during or ("",)]
            collected = Collected(
                each,
                runs,
                period,
                samples,
                group=group,
                masks=len(places),
                length=scenario.count + 1,
            )
            if moments:
                collected.moments = Moments(runs, parts_of(each))
            self._entries.append((each, signals.index(each.signal), places, collected))

    def add(self, counted: Sequence[Matrix], vectors: Sequence[NDArray[np.float64]]) -> None:
        """Process the next samples.

        Args:
            counted: Pointing errors of the run and of each window, infinite outside, rad, (runs,
                samples).
            vectors: Error vectors, rad, (runs, samples, 3).
        """
        self._error.add(Part(self._next, counted[0]))
        self._next += counted[0].shape[1]
        for _, signal, places, collected in self._entries:
            collected.add(vectors[signal], [counted[index] < np.inf for index in places])

    def needs_errors(self, runs: NDArray[np.int64]) -> bool:
        """Whether the errors of these runs must be added: for a requirement or a profile."""
        return bool(self._entries) or bool(np.any(runs < PROFILED))

    def finish(self) -> None:
        """Process what remains after the last sample."""
        for *_, collected in self._entries:
            collected.finish()

    def metrics(self) -> dict[str, Vector]:
        """Metric of each requirement, (runs,); NaN for a run without values."""
        return {each.metric: collected.metric() for each, *_, collected in self._entries}

    def moments(self) -> dict[str, Vector]:
        """Columns with mean square, mean and size at the level of each index, (runs,)."""
        columns = {}
        for each, *_, collected in self._entries:
            assert collected.moments is not None, "they were not asked for"
            columns |= collected.moments.columns(each.metric)
            columns[size_name(each.metric)] = collected.size()
        return columns

    def lists(
        self, run: NDArray[np.int64], status: NDArray[np.int8], picked: NDArray[np.int64]
    ) -> dict[str, NDArray[np.float32]]:
        """Columns with several numbers for each run, (runs, numbers); NaN where a run has none.

        Args:
            run: Numbers of the runs.
            status: Status of the runs.
            picked: Their places among the runs of the group.
        """
        ended = (status == 0)[:, None]
        has = ended & (run < PROFILED)[:, None]
        columns = {ERROR_PROFILE: np.where(has, self._error.values[picked], np.nan)}
        for each, *_, collected in self._entries:
            if each.operation != "reproducibility":
                values = collected.profile.values[picked]
                columns[profile_name(each.metric)] = np.where(has, values, np.nan)
            if each.interpretation == "mixed":
                counts = collected.counts()[picked]
                total = counts[:, -1:]
                shares = counts[:, :-1] / np.maximum(total, 1.0)
                columns[counts_name(each.metric)] = np.where(ended & (total > 0.0), shares, np.nan)
        return {name: values.astype(np.float32) for name, values in columns.items()}
