"""What the dedicated bench experiments share: their requests, and how they end in a result.

Carrara and Kuga call these "deterministic methods", after Carrara and Milani (2007): each parameter
has an experiment of its own that makes it stand out.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from gyrostat._types import Matrix, Vector
from gyrostat.errors import InputError
from gyrostat.friction import Friction
from gyrostat.identify.fit import Fit
from gyrostat.identify.least_squares import Solution
from gyrostat.identify.observability import CLEAR, Observability
from gyrostat.identify.prediction import wheel_dimensions
from gyrostat.identify.statistics import correlation_length, serial_meat
from gyrostat.telemetry import Record
from gyrostat.units import SI_UNIT

POSITIVE = ("inertia", "motor_constant", "stribeck_speed")
"""Parameters that are more than zero in every wheel."""


def as_records(records: Record | Sequence[Record]) -> tuple[Record, ...]:
    """One record or several as a tuple.

    Raises:
        InputError: there is none.
    """
    every = (records,) if isinstance(records, Record) else tuple(records)
    if not every:
        raise InputError("records: found none, expected at least one")
    return every


def place(records: Sequence[Record]) -> str:
    """The names of records, for a message."""
    return ", ".join(record.name for record in records)


def check_sigma(speed_sigma: float | None) -> None:
    """Refuse a standard deviation of the speed, rad/s, that is not positive.

    Raises:
        InputError: as said.
    """
    if speed_sigma is not None and not (np.isfinite(speed_sigma) and speed_sigma > 0.0):
        raise InputError(f"speed sigma: found {speed_sigma}, expected more than 0 rad/s")


def held_values(
    model: type[Friction],
    inertia: float | None,
    hold: Mapping[str, float | None] | None,
    allowed: Collection[str],
) -> dict[str, float]:
    """Values that an experiment is told, name -> SI.

    Args:
        model: friction model.
        inertia: kg·m², or None.
        hold: name -> value, SI, or None for the default of the friction model.
        allowed: names that `hold` may have.

    Raises:
        InputError: another name, no value where the model has no default, or a value that no wheel
            has.
    """
    dimensions = wheel_dimensions(model)
    values = {} if inertia is None else {"inertia": float(inertia)}
    for name, value in (hold or {}).items():
        if name not in allowed:
            raise InputError(f"hold: found {name!r}, expected one of {', '.join(allowed)}")
        if value is None and name in model.held_by_default:
            value = float(model.from_coulomb(0.0, 0.0).parameters()[name])
        if value is None:
            raise InputError(
                f"held {name}: found no value, expected one in {SI_UNIT[dimensions[name]]}"
            )
        values[name] = float(value)
    for name, value in values.items():
        unit = SI_UNIT[dimensions[name]]
        if not np.isfinite(value):
            raise InputError(f"{name}: found {value}, expected a finite number in {unit}")
        if name in POSITIVE and value <= 0.0:
            raise InputError(f"{name}: found {value:g}, expected more than 0 {unit}")
    return values


def required(held: Mapping[str, float], name: str, why: str) -> float:
    """A value that an experiment cannot do without.

    Raises:
        InputError: it is not held; `why` says what it is needed for.
    """
    if name not in held:
        raise InputError(f"{name}: found none, expected a value to hold: {why}")
    return held[name]


def relaxed_time(time: Vector, viscous: float) -> tuple[Vector, Vector]:
    """Time integral of exp(-b t/J), s, and its derivative with respect to b/J.

    Args:
        time: (m,) s, of either sign.
        viscous: b/J, 1/s; zero leaves the time itself.
    """
    small = np.abs(viscous * time) < 1e-5
    rate = viscous if viscous != 0.0 else 1.0
    # where the decay is not yet seen the closed form cancels: its series takes over
    value = np.where(small, time - 0.5 * viscous * time**2, -np.expm1(-rate * time) / rate)
    bend = np.where(small, -0.5 * time**2, (time * np.exp(-rate * time) - value) / rate)
    return value, bend


def serial_sigma(solution: Solution, counts: Sequence[int]) -> Vector:
    """Standard deviations, (n,), that allow for residuals correlated in time.

    Args:
        solution: of a least-squares problem without a-priori.
        counts: numbers of residuals in each stretch of time, in order.
    """
    bread = np.linalg.inv(solution.jacobian.T @ solution.jacobian)
    scores = solution.residual[:, None] * solution.jacobian
    meat = np.zeros_like(bread)
    for first, last in pairwise(np.cumsum([0, *counts]).tolist()):
        lags = correlation_length(solution.residual[first:last])
        meat += serial_meat(scores[first:last], lags)
    return np.sqrt(np.diag(bread @ meat @ bread))


def verdicts(
    model: type[Friction],
    values: Mapping[str, float],
    names: Sequence[str],
    covariance: Matrix,
    cures: Mapping[str, str],
) -> dict[str, Observability]:
    """Judge each estimate by its effect over its standard deviation.

    Args:
        model: friction model.
        values: name -> value of estimated and held parameters, SI.
        names: of the estimates.
        covariance: of the estimates, SI.
        cures: name of an estimate -> what would show it better.
    """
    judged = {}
    for k, name in enumerate(names):
        effect, variance, label = abs(values[name]), covariance[k, k], name
        reference = model.vanishing_at.get(name)
        if reference is not None:
            effect, label = abs(values[name] - values[reference]), f"{name} - {reference}"
            if reference in names:
                other = names.index(reference)
                variance += covariance[other, other] - 2.0 * covariance[k, other]
        significance = float(effect / np.sqrt(max(variance, np.finfo(float).tiny)))
        advice = (
            f"{name}: not observable in this record ({label} is {significance:.1f} sigma): "
            f"hold it at a known value, or {cures[name]}"
        )
        clear = significance > CLEAR
        judged[name] = Observability(clear, significance, "" if clear else advice)
    return judged


def _warnings(fit: Fit) -> list[str]:
    found = []
    if not fit.converged:
        found.append(f"did not converge in {fit.iterations} iterations: not a valid result")
    for name, value, sigma in zip(fit.names, fit.values, fit.sigma, strict=True):
        signed = fit.dimensions[name] in ("motor_constant", "torque", "viscous")
        if signed and value < -2.0 * sigma:
            found.append(
                f"{name} is negative ({value:.3g}): no wheel has this; do current and speed have "
                "opposite senses?"
            )
    found += [o.advice for o in fit.observability.values() if not o.observable]
    if fit.whiteness is not None and not fit.whiteness.white:
        found.append(
            "the residuals are correlated in time: the model misses something, and sigma is too "
            "small (sigma_serial allows for it)"
        )
    return found


def result(
    model: type[Friction],
    method: str,
    estimates: Mapping[str, float],
    covariance: Matrix,
    held: Mapping[str, float],
    cures: Mapping[str, str],
    *,
    serial_sigma: Vector | None = None,
    warnings: Sequence[str] = (),
    **rest,
) -> Fit:
    """The result of a dedicated experiment.

    Args:
        model: friction model.
        method: its name.
        estimates: name -> value, SI.
        covariance: of the estimates, SI.
        held: name -> value that was not estimated, SI.
        cures: name of an estimate -> what would show it better.
        serial_sigma: standard deviations that allow for correlated residuals; by default those of
            `covariance`.
        warnings: of the method itself, after those that every fit may have.
        rest: the other fields of `Fit`.
    """
    names = tuple(estimates)
    fit = Fit(
        model=model,
        method=method,
        names=names,
        dimensions=wheel_dimensions(model),
        values=np.array([estimates[n] for n in names]),
        covariance=covariance,
        serial_sigma=np.sqrt(np.diag(covariance)) if serial_sigma is None else serial_sigma,
        held=dict(held),
        observability=verdicts(model, {**held, **estimates}, names, covariance, cures),
        crossings=0,
        **rest,
    )
    return replace(fit, warnings=(*_warnings(fit), *warnings))
