"""Identification of a drive in closed loop from its inverse dynamics."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.identification.bench.bench_methods import held_values, result
from gyrostat.identification.conclude import with_tolerances
from gyrostat.identification.drive.checks import (
    FOLLOWED,
    check_reference,
    check_senses,
    refused,
    warnings_of,
)
from gyrostat.identification.drive.control_law import ControlLaw
from gyrostat.identification.drive.delay import delay
from gyrostat.identification.drive.equation import Equation
from gyrostat.identification.drive.estimators import Regression, estimate, iterate, relative_rms
from gyrostat.identification.drive.filtered_reference import filtered_reference
from gyrostat.identification.drive.motion import Drive, Motion, drives
from gyrostat.identification.drive.output_error import minimise_output_error
from gyrostat.identification.drive.parts import Part, half_width, part_of
from gyrostat.identification.drive.points import friction_points
from gyrostat.identification.drive.tracking import tracking
from gyrostat.identification.drive.weak_form import CUTOFF
from gyrostat.identification.read.checks import as_records, check_sigma, check_signals, place
from gyrostat.identification.read.statistics import noise_level
from gyrostat.identification.result.fit import Fit
from gyrostat.identification.result.inverse_dynamics import Estimates, InverseDynamics
from gyrostat.identification.uncertainty.tolerances import check_tolerances, propagate_dedicated
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import ViscousCoulomb
from gyrostat.wheel.friction_laws import Law, friction_law

FEWEST = 40
"""Smallest number of windows."""


def _equation(
    model: str | Law | None, inertia: float | None, hold: Mapping[str, float | None]
) -> Equation:
    """Equation of motion with what is held.

    Raises:
        InputError: Neither inertia nor motor constant is given, or nothing is to be estimated.
    """
    law = ViscousCoulomb if model is None else friction_law(model)
    bias = {n: 0.0 if v is None else v for n, v in hold.items() if n == "current_bias"}
    rest = {n: v for n, v in hold.items() if n not in bias}
    names = ("motor_constant", "inertia", *law.dimensions())
    defaults = {n: None for n in law.held_by_default if n not in rest}
    held = {**held_values(law, inertia, {**defaults, **rest}, names), **bias}
    if not {"inertia", "motor_constant"} & set(held):
        raise InputError(
            "--method inverse: found neither --inertia nor --hold motor_constant=VALUE, expected "
            "one of them: current and speed show torques only relative to it"
        )
    free = [n for n in (*names, "current_bias") if n not in held]
    if not law.odd and "current_bias" in free:
        # an offset of the current and friction that differs by direction are the same
        free.remove("current_bias")
        held["current_bias"] = 0.0
    if not set(free) - {"current_bias"}:
        raise InputError("hold: found every parameter, expected one to estimate")
    equation = Equation(law, held, tuple(free))
    equation.check()
    return equation


def _segments(
    records: Sequence[Record], hold: str, law: ControlLaw | None
) -> list[tuple[Record, Drive]]:
    """Segments of the records, each with its record.

    Raises:
        InputError: A record lacks the reference, or it is the measured motion.
    """
    pairs = []
    for record in records:
        wanted = ("reference", "setpoint") if law is None else (law.reference,)
        if all(getattr(record, name) is None for name in wanted):
            raise InputError(
                f"{record.name}: found no column {' or '.join(wanted)}, expected one for --method "
                "inverse: what the drive was commanded (reference: angle; setpoint: speed) has no "
                "part in the disturbances, and what it measures has"
            )
        check_reference(record)
        pairs += [(record, drive) for drive in drives(record, hold)]
    return pairs


def identify_inverse(
    records: Record | Sequence[Record],
    *,
    inertia: float | None = None,
    hold: Mapping[str, float | None] | None = None,
    model: str | Law | None = None,
    speed_sigma: float | None = None,
    law: ControlLaw | None = None,
    current_hold: str = "zero-order",
    held_out: Sequence[Record] = (),
    tolerance: Mapping[str, float] | None = None,
) -> Fit:
    """Identify a drive from a record in closed loop, by its inverse dynamics and instruments.

    The torque is a linear regression on acceleration, friction and a constant, in windows
    (`gyrostat.identification.drive.weak_form`). In a closed loop, disturbances drive the current,
    and measured speeds have noise; both bias least squares. The instruments are the same regressors
    of a motion that is predicted from the reference, and is free of both: that of an auxiliary
    drive in the same control law, simulated with the estimates, or of a linear filter of the
    reference (Janot, Vandanjon and Gautier 2014).

    Args:
        records: Records of one drive, with the column reference or setpoint.
        inertia: Inertia, kg·m²; held if given.
        hold: Name -> value, SI; motor_constant must be here if no inertia is given.
        model: Friction model, by default "viscous-coulomb"; linear in what is estimated.
        speed_sigma: Standard deviation of the measured speed, rad/s; by default from the record.
        law: Control law; None to filter the reference.
        current_hold: Current between samples, "zero-order" or "linear".
        held_out: Records whose torque is only predicted.
        tolerance: Name of a given quantity -> relative tolerance, one sigma, as for `identify`.

    Returns:
        The fit, with the estimates of all methods in `inverse`.

    Raises:
        InputError: A record has no reference or is too short, or the arguments allow no estimate.
    """
    records = as_records(records)
    check_sigma(speed_sigma)
    check_signals(records)
    equation = _equation(model, inertia, hold or {})
    pairs = _segments(records, current_hold, law)
    if not pairs:
        raise InputError(f"{place(records)}: found no segment of 8 speeds, expected a longer one")
    motions = [filtered_reference(drive) for _, drive in pairs]
    width = float(np.median([half_width(d, m) for (_, d), m in zip(pairs, motions, strict=True)]))
    parts = [part_of(drive, width) for _, drive in pairs]
    count = sum(len(part.used) for part in parts)
    if count < FEWEST:
        raise InputError(
            f"{place(records)}: found {count} windows of {2.0 * width:.3g} s in which the drive "
            f"moves, expected {FEWEST} or more: a longer record"
        )
    check_senses(records, equation)
    parts = _weighted(equation, pairs, parts, motions)
    best, motions = iterate(equation, parts, motions, law)
    fits = {"instruments": best, "least_squares": estimate(equation, parts, None)}
    followed = _followed(parts, motions)
    output = None
    if law is not None and followed >= FOLLOWED:
        output = minimise_output_error(equation, parts, best.values, law)
    if output is not None:
        fits["output_error"] = output
    inverse = InverseDynamics(
        prediction="the filtered reference" if law is None else f"the stated {law.name} control",
        cutoff=CUTOFF / width,
        windows=count,
        followed=followed,
        strength=best.strength,
        methods={name: _estimates(equation, fit) for name, fit in fits.items()},
        torque_error=_by_record(pairs, best),
        held_out=dict(
            _held_out_error(equation, best, record, width, current_hold) for record in held_out
        ),
        simulated={} if output is None else _by_record(pairs, output),
    )
    noise = max(noise_level(record.speed[record.valid]) for record in records)
    fit = result(
        equation.law,
        "inverse",
        dict(zip(equation.names, best.values.tolist(), strict=True)),
        equation.held,
        dict.fromkeys(equation.names, "record larger accelerations, and speeds over a wider range"),
        covariance=best.covariance,
        reason="" if best.converged else "the simulated loop and the estimates do not agree",
        scatter=[],
        refused=refused(inverse, law),
        warnings=warnings_of(
            inverse,
            delay(equation, parts, motions),
            None if law is None else tracking(law, parts, motions),
        ),
        iterations=best.iterations,
        samples=sum(int(record.valid.sum()) for record in records),
        speed_sigma=speed_sigma or noise,
        records=records,
        whiteness=None,
        inverse=inverse,
        friction_points=friction_points(equation, parts, equation.named(best.values)),
    )
    return _with_tolerances(fit, check_tolerances(tolerance or {}))


def _with_tolerances(fit: Fit, tolerances: Mapping[str, float]) -> Fit:
    """Fit with the effect of tolerances on its uncertainty.

    Raises:
        InputError: Inertia and motor constant are both held, so that no scaling law holds.
    """
    if not tolerances:
        return fit
    scales = [n for n in ("inertia", "motor_constant") if n in fit.held]
    if len(scales) == 2:
        raise InputError(
            "--method inverse: found a tolerance with a held inertia and motor constant, expected "
            "one of the two to be estimated"
        )
    dimensions = [fit.dimensions[name] for name in fit.names]
    law = f"inverse at a known {scales[0]}"
    errors = propagate_dedicated(tolerances, law, dimensions, fit.values)
    return with_tolerances(fit, errors, tolerances)


def _weighted(
    equation: Equation,
    pairs: Sequence[tuple[Record, Drive]],
    parts: Sequence[Part],
    motions: Sequence[Motion],
) -> list[Part]:
    """Parts with the weight of their record; one record has the weight 1."""
    if len({id(record) for record, _ in pairs}) == 1:
        return list(parts)
    first = estimate(equation, parts, motions)
    level: dict[int, list[Vector]] = {}
    for (record, _), error in zip(pairs, first.errors, strict=True):
        level.setdefault(id(record), []).append(error)
    weight = {key: 1.0 / float(np.std(np.concatenate(each))) for key, each in level.items()}
    return [
        replace(part, weight=weight[id(record)])
        for part, (record, _) in zip(parts, pairs, strict=True)
    ]


def _followed(parts: Sequence[Part], motions: Sequence[Motion]) -> float:
    """Share of the variance of the measured speed that the predicted one has."""
    speed = np.concatenate([part.drive.measured.mean_speed for part in parts])
    error = speed - np.concatenate([motion.mean_speed for motion in motions])
    return 1.0 - float(np.sum(error**2) / np.sum((speed - np.mean(speed)) ** 2))


def _estimates(equation: Equation, fit: Regression) -> Estimates:
    sigma = np.sqrt(np.diag(fit.covariance)).tolist()
    return Estimates(
        dict(zip(equation.names, fit.values.tolist(), strict=True)),
        dict(zip(equation.names, sigma, strict=True)),
        fit.torque_error,
        fit.converged,
    )


def _by_record(pairs: Sequence[tuple[Record, Drive]], fit: Regression) -> dict[str, float]:
    """Record -> relative torque error."""
    errors: dict[str, list[tuple[Vector, Vector]]] = {}
    for (record, _), *both in zip(pairs, fit.errors, fit.torques, strict=True):
        errors.setdefault(record.name, []).append((both[0], both[1]))
    return {
        name: relative_rms(*(np.concatenate(each) for each in zip(*both, strict=True)))
        for name, both in errors.items()
    }


def _held_out_error(
    equation: Equation, fit: Regression, record: Record, width: float, hold: str
) -> tuple[str, float]:
    """Record that was not fitted, and its relative torque error at its measured motion."""
    check_signals([record])
    values, pairs = equation.named(fit.values), []
    for drive in drives(record, hold):
        part = part_of(drive, width)
        pairs.append(equation.torque_error(part.rows(equation, part.drive.measured), values))
    if not sum(len(torque) for _, torque in pairs):
        raise InputError(
            f"{record.name}: found no window of {2.0 * width:.3g} s in which the drive moves, "
            "expected a held-out record in which it does"
        )
    return record.name, relative_rms(*(np.concatenate(each) for each in zip(*pairs, strict=True)))
