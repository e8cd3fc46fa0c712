"""Friction over temperature, from records taken at different temperatures."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.core.units import si_unit
from gyrostat.identification.fit.problem import Problem
from gyrostat.identification.read.slopes import DISTINCT
from gyrostat.identification.result.fit import Fit
from gyrostat.identification.result.temperature_trend import TemperatureTrend
from gyrostat.identification.unsampled import solve
from gyrostat.telemetry import Record


def temperature_trends(
    records: Sequence[Record], *, on_left_out: Callable[[str], None] | None = None, **options: Any
) -> list[TemperatureTrend]:
    """Fit each record separately and compare the friction across their mean temperatures.

    Args:
        records: Records of one wheel.
        on_left_out: Function called with a message for each record without a valid fit of its own.
        options: Arguments of `identify` for all records together.

    Returns:
        One trend for each estimated parameter of the wheel. Empty if fewer than two records have a
        temperature and a valid fit, or if their mean temperatures differ by less than `DISTINCT`.
    """
    return trends_of(Problem.of(records, **options), on_left_out)


def trends_of(
    problem: Problem, on_left_out: Callable[[str], None] | None = None
) -> list[TemperatureTrend]:
    """Temperature trends of the records of a problem; see `temperature_trends`."""
    records = problem.records
    temperatures: list[float] = []
    fits: list[Fit] = []
    means = [None if r.temperature is None else float(np.mean(r.temperature)) for r in records]
    values = [t for t in means if t is not None]
    if len(values) < 2 or np.ptp(values) < DISTINCT:
        return []
    for index, (record, temperature) in enumerate(zip(records, means, strict=True)):
        if temperature is None:
            continue
        try:
            fit = solve(problem.alone(index))
            failure = "" if fit.converged else f"{record.name}: did not converge alone"
        except InputError as error:
            fit, failure = None, str(error)
        if fit is not None and not failure:
            temperatures.append(temperature)
            fits.append(fit)
        elif on_left_out is not None:
            on_left_out(f"omitted from the temperature trend: {failure}")
    if len(fits) < 2 or np.ptp(temperatures) < DISTINCT:
        return []
    return [
        _trend(name, np.array(temperatures), fits)
        for name in fits[0].names
        if not name.startswith("initial_speed") and not fits[0].observability[name].given
    ]


def _trend(name: str, temperature: Vector, fits: Sequence[Fit]) -> TemperatureTrend:
    """Fit a weighted straight line to one parameter of several fits."""
    value = np.array([f.parameters[name] for f in fits])
    sigma = np.array([f.sigma[f.names.index(name)] for f in fits])
    weight = sigma**-2.0
    centred = temperature - np.average(temperature, weights=weight)
    power = float(np.sum(weight * centred**2))
    slope = float(np.sum(weight * centred * value) / power)
    misfit = value - np.average(value, weights=weight) - slope * centred
    freedom = len(fits) - 2
    # a wheel varies from day to day by more than the uncertainty of each record
    excess = np.sqrt(np.sum(weight * misfit**2) / freedom) if freedom > 0 else 1.0
    return TemperatureTrend(
        name=name,
        unit=si_unit(fits[0].dimensions[name]),
        temperature=temperature,
        value=value,
        sigma=sigma,
        slope=slope,
        slope_sigma=float(max(excess, 1.0) * power**-0.5),
    )
