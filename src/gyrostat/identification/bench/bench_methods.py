"""Inputs and results shared by the bench methods (steady, torque step, coast-down).

Carrara and Kuga call these "deterministic methods", after Carrara and Milani (2007): each parameter
has its own experiment, in which it dominates.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.units import si_unit
from gyrostat.identification.fit.parameters import check_parameter
from gyrostat.identification.fit.prediction import wheel_dimensions
from gyrostat.identification.judge.plausibility import Scatter, judged
from gyrostat.identification.read.checks import MOTION
from gyrostat.identification.read.statistics import crossing_times
from gyrostat.identification.result.fit import Fit
from gyrostat.identification.uncertainty.observability import judge
from gyrostat.identification.uncertainty.sigmas import square_root, widened
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import Friction


def held_values(
    model: type[Friction],
    inertia: float | None,
    hold: Mapping[str, float | None] | None,
    allowed: Collection[str],
) -> dict[str, float]:
    """Values given to a bench method, name -> SI.

    Args:
        model: Friction model.
        inertia: Rotor inertia, kg·m², or None.
        hold: Name -> value, SI, or None for the default of the friction model.
        allowed: Names allowed in `hold`.

    Raises:
        InputError: A name is not allowed, a value is missing and the model has no default, or no
            wheel can have the value.
    """
    dimensions = wheel_dimensions(model)
    values = {} if inertia is None else {"inertia": float(inertia)}
    for name, value in (hold or {}).items():
        if name not in allowed:
            raise InputError(f"hold: found {name!r}, expected one of {', '.join(allowed)}")
        if value is None and name in model.held_by_default:
            value = model.start_values(0.0, 0.0)[name]
        if value is None:
            raise InputError(
                f"held {name}: found no value, expected one in {si_unit(dimensions[name])}"
            )
        values[name] = float(value)
    for name, value in values.items():
        check_parameter(model, name, value, name)
    return values


def require_held(held: Mapping[str, float], name: str, why: str) -> float:
    """Held value that a bench method needs.

    Raises:
        InputError: The value is not held; `why` says what it is needed for.
    """
    if name not in held:
        raise InputError(f"{name}: found none, expected a value to hold: {why}")
    return held[name]


def relaxed_time(time: Vector, viscous: float) -> tuple[Vector, Vector]:
    """Time integral of exp(-b t/J), s, and its derivative with respect to b/J.

    Args:
        time: Time of either sign, (m,), s.
        viscous: b/J, 1/s; for zero the result is the time itself.
    """
    small = np.abs(viscous * time) < 1e-5
    rate = viscous if viscous != 0.0 else 1.0
    # for small decay the closed form suffers from cancellation: use its series
    value = np.where(small, time - 0.5 * viscous * time**2, -np.expm1(-rate * time) / rate)
    bend = np.where(small, -0.5 * time**2, (time * np.exp(-rate * time) - value) / rate)
    return value, bend


def result(
    model: type[Friction],
    method: str,
    estimates: Mapping[str, float],
    held: Mapping[str, float],
    cures: Mapping[str, str],
    *,
    covariance: Matrix,
    records: tuple[Record, ...],
    speed_sigma: float,
    scatter: Sequence[Scatter],
    reason: str,
    serial_sigma: Vector | None = None,
    warnings: Sequence[str] = (),
    refused: Sequence[str] = (),
    **fields,
) -> Fit:
    """Result of a bench method, which does not model a whole record.

    Args:
        model: Friction model.
        method: Name of the method.
        estimates: Name -> value, SI.
        held: Name -> value that was not estimated, SI.
        cures: Name of an estimate -> advice on how to improve it.
        covariance: Covariance of the estimates, SI.
        records: Records used.
        speed_sigma: Standard deviation of a measured speed, rad/s.
        scatter: Scatter of the speeds about the fit.
        reason: Reason why the iteration did not converge; empty if it did.
        serial_sigma: Standard deviations with correlated residuals; by default those of
            `covariance`.
        warnings: Warnings of the method, after those common to all fits.
        refused: Reasons why the estimates are not valid.
        fields: Other fields of `Fit`.
    """
    names = tuple(estimates)
    formal = np.sqrt(np.diag(covariance))
    observability = judge(
        model,
        {**held, **estimates},
        names,
        square_root(covariance),
        lambda name: f"hold it at a known value, or {cures[name]}",
    )
    if "current_bias" in observability:
        # it may be zero
        observability["current_bias"] = replace(observability["current_bias"], advice="")
    fit = Fit(
        model=model,
        method=method,
        names=names,
        dimensions={**wheel_dimensions(model), "current_bias": "current"},
        values=np.array([estimates[n] for n in names]),
        covariance=widened(covariance, formal if serial_sigma is None else serial_sigma),
        noise_sigma=formal,
        least_squares=np.array([estimates[n] for n in names]),
        held=dict(held),
        observability=observability,
        converged=not reason,
        crossings=sum(
            len(crossing_times(r.time[r.valid], r.speed[r.valid], MOTION * speed_sigma))
            for r in records
        ),
        speed_sigma=speed_sigma,
        speed_sigmas=(speed_sigma,) * len(records),
        records=records,
        predicted=(),
        predicted_sigma=(),
        **fields,
    )
    return judged(fit, reason, scatter, warnings=warnings, refused=refused)
