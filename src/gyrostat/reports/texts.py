"""Texts of results: the sentences that the command line prints."""

from functools import singledispatch

import numpy as np
import xarray as xr

from gyrostat.core.errors import InputError
from gyrostat.core.pictured_datasets import Run, Runs, is_whole
from gyrostat.core.text import aligned, measured, plain
from gyrostat.core.types import Vector
from gyrostat.core.units import RPM, si_unit
from gyrostat.estimation.track import FrictionTrack
from gyrostat.failures import Holdable, Recovery
from gyrostat.identification.result.fit_text import posterior_summary
from gyrostat.identification.uncertainty.posterior import Marginal, Posterior
from gyrostat.monitoring.rehearsal import Rehearsal
from gyrostat.reports.datasets import run_lines, runs_lines
from gyrostat.reports.feasibility import answer_lines
from gyrostat.reports.recovery import rows_of, verdict_of
from gyrostat.reports.speed_plan import lines_of
from gyrostat.reports.tuning import tuning_lines
from gyrostat.search.speed_plan import SpeedPlan
from gyrostat.search.tuning import TunedGains
from gyrostat.telemetry import Record
from gyrostat.wheel.model_file import WheelModel


@singledispatch
def text_of(result: object) -> str:
    """Sentences of the command line on a result.

    Args:
        result: Result of a verb.
    """
    return repr(result)


@text_of.register
def _(result: Record) -> str:
    """Length of a record, and the ranges of its columns."""
    duration = result.time[-1] - result.time[0]
    missing = int(np.sum(np.logical_not(result.valid)))
    gaps = f", {missing} without a speed" if missing else ""
    rows = [("speed", result.speed / RPM, "rpm"), ("current", result.current, "A")]
    rows += [
        (name, values, unit)
        for name, unit in (("temperature", "°C"), ("torque", "N·m"), ("reference", "rad"))
        if (values := getattr(result, name)) is not None
    ]
    return "\n".join(
        [
            f"{result.name}: {len(result.time)} samples over {plain(duration)} s{gaps}",
            *(f"  {name}: {_range(values, unit)}" for name, values, unit in rows),
            *(f"  {note}" for note in result.notes),
        ]
    )


def _range(values: Vector, unit: str) -> str:
    finite = values[np.isfinite(values)]
    if not len(finite):
        return "no valid value"
    return f"{plain(float(finite.min()))} to {plain(float(finite.max()))} {unit}"


@text_of.register
def _(result: FrictionTrack) -> str:
    """Friction at the end, and whether the filter is consistent."""
    if not len(result.time):
        return "friction: no samples"
    scale = measured(float(result.scale[-1]), float(result.scale_sigma[-1]))
    verdict = "consistent" if result.consistent else "NOT consistent"
    return (
        f"friction after {plain(result.time[-1])} s: {scale} of that of the model; "
        f"{len(result.time)} samples, {result.missed} without a speed; innovations {verdict}"
    )


@text_of.register
def _(result: Posterior) -> str:
    """Draws, verdict, and the table of the parameters."""
    rows = [
        (each.name, measured(each.mean, each.sigma), _interval(each), each.unit)
        for each in result.marginals
    ]
    table = aligned(rows, ("posterior", "mean ± sigma", "95 % interval", "unit"))
    return "\n".join([*posterior_summary(result), *(f"  {line}" for line in table)])


def _interval(marginal: Marginal) -> str:
    return f"{plain(marginal.quantiles[0])} to {plain(marginal.quantiles[-1])}"


@text_of.register
def _(result: WheelModel) -> str:
    """Friction model, and the table of its parameters."""
    rows = []
    for name, value in result.values.items():
        sigma = result.sigma.get(name)
        number = plain(value, 6) if sigma is None else measured(value, sigma)
        rows.append((name, number, si_unit(result.dimensions().get(name, ""))))
    table = aligned(rows, ("parameter", "value ± sigma", "unit"))
    lines = [f"{result.friction.title} friction", *(f"  {line}" for line in table)]
    lines += [f"{name}: {text}" for name, text in result.origin.items()]
    return "\n".join([*lines, *filter(None, [result.impossible])])


@text_of.register
def _(result: Rehearsal) -> str:
    """False alarms, and what to expect of each fault."""
    return "\n".join(result.lines())


@text_of.register
def _(result: Run) -> str:
    """Verdict and metrics; a part of a run is shown as xarray does."""
    return "\n".join(run_lines(result)) if is_whole(result) else xr.Dataset.__repr__(result)


@text_of.register
def _(result: Runs) -> str:
    """Summary of the campaign; a part of its table, or one without folder, as xarray shows it."""
    try:
        return "\n".join(runs_lines(result))
    except InputError:
        return xr.Dataset.__repr__(result)


@text_of.register
def _(result: SpeedPlan) -> str:
    """Crossings by the present law and with the plan."""
    return "\n".join(lines_of(result))


@text_of.register
def _(result: TunedGains) -> str:
    """Old and new values, and their proof."""
    return "\n".join(tuning_lines(result))


@text_of.register
def _(result: Holdable) -> str:
    """Verdict, and what is known of the nearest feasible attitude."""
    return repr(result) if result.question is None else "\n".join(answer_lines(result))


@text_of.register
def _(result: Recovery) -> str:
    """Verdict and what was found."""
    rows = [] if result.case is None else rows_of(result.case[0], result, result.case[1])
    return "\n".join([verdict_of(result), *(f"  {name}: {entry}" for name, entry in rows)])
