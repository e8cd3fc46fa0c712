"""Observability of each parameter in a record, and how to improve it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.core.pictured import Described
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.least_squares import Solution
from gyrostat.identification.fit.prediction import SpeedPrediction, wheel_dimensions
from gyrostat.identification.fit.selection import Selection
from gyrostat.identification.fit.start_values import StartValues
from gyrostat.wheel.friction import Friction

CLEAR = 2.0
"""Smallest effect of an observable parameter, in standard deviations."""
SILENT = 1e-6
"""A-priori information, relative to the weak one, that keeps every variance finite."""
UNSEEN = 1e-10
"""Singular value, relative to the largest, below which a direction holds only rounding errors."""
DECIDED = 3.0
"""Ratio of the sigmas without and with the a-priori, above which the a-priori dominates."""


@dataclass(frozen=True)
class Observability(Described):
    """Significance of one parameter from the measurements alone.

    Attributes:
        observable: Whether its effect exceeds `CLEAR` standard deviations.
        significance: Effect divided by its standard deviation, from the measurements alone;
            negative if a static torque lies below its Coulomb torque.
        advice: Advice on how to make it observable; empty if it is observable.
        given: Whether it was given with a tolerance and not estimated.
    """

    observable: bool
    significance: float
    advice: str = ""
    given: bool = False


def judge(
    model: type[Friction],
    values: Mapping[str, float],
    names: Sequence[str],
    root: Matrix,
    cure: Callable[[str], str],
    sizes: Mapping[str, float] | None = None,
    widening: Mapping[str, float] | None = None,
) -> dict[str, Observability]:
    """Observability of each estimate from its effect divided by its standard deviation.

    The effect of a static torque is its difference from the Coulomb torque; that of any other
    parameter is its value, unless `sizes` gives another.

    Args:
        model: Friction model.
        values: Name -> value of estimated and held parameters, SI.
        names: Names of the n estimates.
        root: Square root of their covariance, (n, k), SI.
        cure: Function from name to advice.
        sizes: Name -> effect that replaces the value, SI.
        widening: Name -> factor on the standard deviation of its effect, 1 by default.

    Returns:
        Name -> observability.
    """
    judgements = {}
    for k, name in enumerate(names):
        effect, spread, label = abs(values[name]), root[k], name
        reference = model.vanishing_at.get(name)
        if reference is not None:
            effect, label = values[name] - values[reference], f"{name} - {reference}"
            if reference in names:
                spread = spread - root[names.index(reference)]
        elif sizes and name in sizes:
            effect, label = sizes[name], "its range"
        sigma = max(float(np.linalg.norm(spread)), np.sqrt(np.finfo(float).tiny))
        sigma *= (widening or {}).get(name, 1.0)
        significance = float(effect / sigma)
        clear = abs(significance) > CLEAR
        text = f"{name}: not observable in this record ({label} is {significance:.1f} sigma)"
        advice = "" if clear else f"{text}: {cure(name)}"
        judgements[name] = Observability(clear, significance, advice)
    return judgements


def _root(jacobian: Matrix, scale: Vector) -> Matrix:
    """Square root of the covariance of n parameters without a-priori, (n, n)."""
    # not from the normal equations, which square the condition number
    _, singular, directions = np.linalg.svd(jacobian * scale, full_matrices=False)
    singular = np.where(singular > UNSEEN * singular.max(initial=0.0), singular, 0.0)
    return scale[:, None] * directions.T / np.hypot(singular, SILENT)


def _root_at_given(root: Matrix, index: int, jacobian: Matrix, scale: Vector) -> Matrix:
    """Square root of the covariance at a given value of one estimate, whose own row stays, (n, n).

    Args:
        root: Square root of the covariance without a-priori, (n, n).
        index: Index of the estimate.
        jacobian: Derivatives of the residuals, (m, n).
        scale: Scales of the parameters, (n,).
    """
    others = [k for k in range(len(scale)) if k != index]
    given = np.zeros_like(root)
    given[index] = root[index]
    given[np.ix_(others, range(len(others)))] = _root(jacobian[:, others], scale[others])
    return given


def _inertia_from_prior(root: Matrix, selection: Selection, posterior_sigma: Vector) -> bool:
    """Whether the inertia has a sigma a priori, and the record does not determine it."""
    if "inertia" not in selection.free:
        return False
    index = selection.free.index("inertia")
    has_prior = selection.prior.sigma[index] < selection.scale[index]
    return bool(has_prior and np.linalg.norm(root[index]) > DECIDED * posterior_sigma[index])


def _widening(
    model: type[Friction], names: Sequence[str], honest: Matrix, formal: Matrix
) -> dict[str, float]:
    """Name -> standard deviation of its effect, relative to that in white noise alone.

    Args:
        model: Friction model.
        names: Names of the n estimates.
        honest: Covariance of the estimates, (n, n), SI.
        formal: The same in white noise.
    """
    factors = {}
    for k, name in enumerate(names):
        contrast = np.eye(len(names))[k]
        reference = model.vanishing_at.get(name)
        if reference in names:
            contrast = contrast - np.eye(len(names))[names.index(reference)]
        ratio = (contrast @ honest @ contrast) / max(
            contrast @ formal @ contrast, np.finfo(float).tiny
        )
        factors[name] = float(np.sqrt(max(ratio, 1.0)))
    return factors


def _at_given(covariance: Matrix, index: int) -> Matrix:
    """Covariance at a given value of one estimate, whose own variance stays, (n, n)."""
    row = covariance[index]
    conditional = covariance - np.outer(row, row) / row[index]
    conditional[index, index] = row[index]
    return conditional


def observability(
    prediction: SpeedPrediction,
    selection: Selection,
    values: Mapping[str, float],
    solution: Solution,
    deterministic: StartValues,
    honest: Matrix,
    formal: Matrix,
) -> dict[str, Observability]:
    """Observability of every estimated parameter from the measurements alone.

    An initial speed or a current bias is compared with the level of the signal. A-priori knowledge
    of the inertia only sets the scale of all torques: then the observability of the other
    parameters is evaluated at the given inertia.

    Args:
        prediction: Records and friction model.
        selection: Estimated parameters.
        values: Name -> value of all parameters, SI.
        solution: Solution for the estimated parameters.
        deterministic: Levels of the signals.
        honest: Covariance of the n estimates with effects outside the model, (n, n), SI.
        formal: The same in white noise alone.

    Returns:
        Name -> observability.
    """
    posterior_sigma = np.sqrt(np.diag(solution.covariance()))
    root = _root(solution.jacobian, selection.scale)
    if _inertia_from_prior(root, selection, posterior_sigma):
        index = selection.free.index("inertia")
        root = _root_at_given(root, index, solution.jacobian, selection.scale)
        # the prior of the inertia is in both, and would hide what the effects add
        honest, formal = _at_given(honest, index), _at_given(formal, index)
    alone = np.linalg.norm(root, axis=1)

    has_prior = bool(np.any(selection.prior.sigma < selection.scale))

    def cure(name: str) -> str:
        index = selection.free.index(name)
        if has_prior and alone[index] > DECIDED * posterior_sigma[index]:
            return "its value comes from the a-priori knowledge, not from the record"
        if name not in wheel_dimensions(prediction.model):
            return "hold it at a known value, or record with more varied currents and speeds"
        reference = prediction.model.vanishing_at.get(name)
        contrast = name if reference is None else f"{name}-{reference}"
        return (
            f"hold it at a known value, or record what shows it: gyrostat bench fit.json --design "
            f"{contrast} --duration 60 --out next.csv"
        )

    sizes = {
        name: deterministic.size(name, dimension, values["inertia"], values["motor_constant"])
        for name, dimension in prediction.dimensions.items()
        if name == "current_bias" or name in prediction.initial_speeds
    }
    widening = _widening(prediction.model, selection.free, honest, formal)
    return judge(prediction.model, values, selection.free, root, cure, sizes, widening)
