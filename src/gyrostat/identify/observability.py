"""Whether a record shows a parameter at all, and what would."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gyrostat._types import Matrix
from gyrostat.identify.deterministic import StartValues
from gyrostat.identify.least_squares import Solution
from gyrostat.identify.prediction import SpeedPrediction
from gyrostat.identify.selection import Selection

CLEAR = 2.0
"""Standard deviations by which an effect must differ from none to count as seen."""
SILENT = 1e-6
"""A-priori information, relative to the weak one, that keeps every variance finite."""


@dataclass(frozen=True)
class Observability:
    """How clearly the measurements alone show one parameter.

    Attributes:
        observable: whether its effect exceeds `CLEAR` standard deviations.
        significance: the effect over its standard deviation, from the measurements alone.
        advice: what would show it; empty where it is observable.
    """

    observable: bool
    significance: float
    advice: str = ""


def _measured_covariance(solution: Solution, selection: Selection) -> Matrix:
    """Covariance of the parameters without their a-priori, (n, n)."""
    scale = selection.prior.sigma
    rows = solution.jacobian * scale
    information = rows.T @ rows + SILENT**2 * np.eye(len(scale))
    return np.linalg.inv(information) * np.outer(scale, scale)


def _advice(name: str, effect: str, significance: float, crossings: int, breakaway: bool) -> str:
    text = f"{name}: not observable in this record ({effect} is {significance:.1f} sigma)"
    if breakaway:
        cure = "slow current ramps from rest (bench --profile ramps) show the breakaway directly"
        if crossings == 0:
            return f"{text}: the speed never crosses zero; {cure}"
        times = (3.0 / max(significance, 0.05)) ** 2
        return (
            f"{text}: for 3 sigma record about {times:.0f} times as many zero crossings or use a "
            f"tachometer {np.sqrt(times):.1f} times quieter; {cure}"
        )
    return f"{text}: hold it at a known value, or record with more varied currents and speeds"


def observability(
    prediction: SpeedPrediction,
    selection: Selection,
    values: Mapping[str, float],
    solution: Solution,
    deterministic: StartValues,
    crossings: int,
) -> dict[str, Observability]:
    """Judge every estimated parameter by the measurements alone.

    A static torque is judged by its difference from the Coulomb torque, an initial speed or a
    current bias by its sigma against the level of the signal, everything else against zero.

    Args:
        prediction: records and friction model.
        selection: what was estimated.
        values: name -> value of all parameters, SI.
        solution: of the estimated parameters.
        deterministic: levels of the signals.
        crossings: zero crossings in the records.

    Returns:
        Name -> verdict.
    """
    covariance = _measured_covariance(solution, selection)
    verdicts = {}
    for k, name in enumerate(selection.free):
        effect, variance, label = abs(values[name]), covariance[k, k], name
        reference = prediction.model.vanishing_at.get(name)
        if reference is not None:
            effect, label = abs(values[name] - values[reference]), f"{name} - {reference}"
            if reference in selection.free:
                other = selection.free.index(reference)
                variance += covariance[other, other] - 2.0 * covariance[k, other]
        elif name == "current_bias" or name.startswith("initial_speed"):
            effect, label = deterministic.size(name, prediction.dimensions[name], 0.0), "its range"
        significance = float(effect / np.sqrt(max(variance, np.finfo(float).tiny)))
        if significance > CLEAR:
            verdicts[name] = Observability(True, significance)
        else:
            advice = _advice(name, label, significance, crossings, reference is not None)
            verdicts[name] = Observability(False, significance, advice)
    return verdicts
