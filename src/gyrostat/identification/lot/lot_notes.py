"""Remarks on a lot whose results are less certain."""

from collections.abc import Mapping, Sequence

from gyrostat.core.types import Vector
from gyrostat.identification.judge.fit_comparison import temperature_note
from gyrostat.identification.lot.posterior import LARGEST_SHAPE
from gyrostat.identification.lot.result import LotParameter
from gyrostat.identification.result.stored_fit import StoredFit

FEWEST_EFFECTIVE = 100
"""Fewest effective draws for limits to two digits."""
RARE_TAILS = 0.01
"""P-value of the kurtosis of the scores at which another form of the distribution is reported."""
LARGE_SHAPE = 0.8 * LARGEST_SHAPE


def notes(
    fits: Sequence[StoredFit], parameters: Mapping[str, LotParameter], shape: str
) -> tuple[str, ...]:
    """Remarks on a lot.

    Args:
        fits: Fits of the wheels.
        parameters: Name -> distribution.
        shape: Shape that the analysis was told.
    """
    remarks = [f"{text}, which is part of the spread here" for text in temperature_note(fits)]
    if any(fit.date is None for fit in fits):
        remarks.append(
            "no drift, and control charts in the order of the files: a date is unknown (comment "
            "'# date: 2026-03-01' in each record, or --manifest)"
        )
    unread = [fit for fit in fits if fit.date is None and fit.unread_date]
    remarks += [f"{fit.name}: date {fit.unread_date!r} is not one that is read" for fit in unread]
    remarks += _on_held(fits)
    for name, parameter in parameters.items():
        remarks += [f"{name}: {text}" for text in _of_parameter(parameter, shape)]
    return tuple(remarks)


def _on_held(fits: Sequence[StoredFit]) -> list[str]:
    """Remarks on values that were held, but not the same in all fits."""
    first = fits[0]
    remarks = []
    for name, value in first.given.items():
        other = next((fit for fit in fits if fit.given.get(name) != value), None)
        if name != "inertia" and other is not None:
            remarks.append(
                f"{name} is held at {value:.4g} in {first.name}, and not in {other.name}: the "
                "other parameters depend on it"
            )
    return remarks


def _of_parameter(parameter: LotParameter, shape: str) -> list[str]:
    remarks = []
    if parameter.sigma_errors > parameter.sigma.value:
        remarks.append(
            "the errors of the fits are larger than the spread of the wheels: the spread and the "
            "shape are uncertain, and the limits are wide"
        )
    typical = parameter.draws.typical()[2]
    if shape != "normal" and abs(typical) > LARGE_SHAPE:
        remarks.append(
            f"the shape {typical:.2f} is near the largest one that is considered, {LARGEST_SHAPE}: "
            "the limits may not hold"
        )
    remarks += _tails(parameter.chart.scores)
    if parameter.draws.effective < FEWEST_EFFECTIVE:
        remarks.append(f"the limits are from {parameter.draws.effective:.0f} effective draws only")
    if parameter.outliers:
        remarks.append(
            "the limits include the outliers: correct or remove their fits if the wheels are not "
            "used"
        )
    if parameter.drift is not None and parameter.drift.significant:
        remarks.append(
            "changes over the date of production: the limits are those of the wheels so far, not "
            "of the next ones"
        )
    return remarks


def _tails(scores: Vector) -> list[str]:
    """Remark on tails that are not those of the model, by the test of Anscombe and Glynn (1983)."""
    from scipy.stats import kurtosistest  # slow to import

    excess, chance = kurtosistest(scores)
    if chance > RARE_TAILS:
        return []
    if excess > 0.0:
        return ["the tails are heavier than those of the model: the limits may not hold"]
    return ["the tails are shorter than those of the model, as of two groups: the limits are wide"]
