"""Texts of results: the sentences that the command line prints."""

from functools import singledispatch

import xarray as xr

from gyrostat.core.errors import InputError
from gyrostat.core.pictured_datasets import Run, Runs, is_whole
from gyrostat.failures import Holdable, Recovery
from gyrostat.reports.datasets import run_lines, runs_lines
from gyrostat.reports.feasibility import answer_lines
from gyrostat.reports.recovery import rows_of, verdict_of
from gyrostat.reports.speed_plan import lines_of
from gyrostat.reports.tuning import tuning_lines
from gyrostat.search.speed_plan import SpeedPlan
from gyrostat.search.tuning import TunedGains


@singledispatch
def text_of(result: object) -> str:
    """Sentences of the command line on a result.

    Args:
        result: Result of a verb.
    """
    return repr(result)


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
