"""Row of the window table for one wheel from the blocks of a window."""

from collections.abc import Mapping
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.monitoring.agreement import OBSERVABLE, agreeing_estimate
from gyrostat.monitoring.blocks import Blocks
from gyrostat.monitoring.drive_samples import resolution
from gyrostat.monitoring.moments import COULOMB, IDLE, MOTOR, OFFSET, VISCOUS
from gyrostat.monitoring.noise import Noise
from gyrostat.monitoring.noise_search import USUAL
from gyrostat.monitoring.power import doubt_of, shows_torque
from gyrostat.monitoring.regression import Estimate, Rows
from gyrostat.monitoring.residuals import residual_columns
from gyrostat.monitoring.rounding import rounding_errors
from gyrostat.monitoring.rows import prior_of, regression_rows, usable
from gyrostat.monitoring.statistics import plain_columns, standstill_columns
from gyrostat.monitoring.stuck import stuck
from gyrostat.monitoring.verdict import FEWEST, lack, unit_doubt, verdict
from gyrostat.monitoring.warming import about_its_share
from gyrostat.monitoring.wheel_data import KnownWheels
from gyrostat.monitoring.windows import REGRESSED

_PLACES = {"coulomb": COULOMB, "viscous": VISCOUS, "motor_constant": MOTOR, "offset": OFFSET}


def window_row(
    blocks: Blocks,
    known: KnownWheels,
    wheel: int,
    window: tuple[float, float],
    *,
    total: int,
    length: float,
    drive: str,
    noise: Noise | None,
    exchange: dict[str, float],
) -> tuple[dict[str, Any], Noise | None]:
    """Row of a wheel, and the noise that the next window starts from.

    Args:
        blocks: Whole blocks of the window.
        known: The wheels.
        wheel: Place of the wheel.
        window: Start and end of the window, s.
        total: Number of blocks of the window with those that are not whole.
        length: Usual length of a block, s.
        drive: "current", "power", "torque" or "none".
        noise: Noise of the previous window, or None.
        exchange: Columns of the exchange of momentum.
    """
    rotor, power = known.wheels[wheel], drive == "power"
    # a commanded torque has no sensor, and a power is not the current
    held = stuck(blocks, known, wheel) if drive == "current" else np.zeros(len(blocks), bool)
    gaps, blocks = total - len(blocks), blocks.part(~held)
    row = {"wheel": rotor.name, "start": window[0], "end": window[1]}
    row |= plain_columns(blocks, wheel, window) | {"stuck_blocks": int(np.sum(held))}
    row["held_as_stated"] = ""
    row |= standstill_columns(blocks, known, wheel) | exchange
    if drive == "none":
        reason = "there is no motor current, electrical power or commanded torque"
        return row | _unknown(reason) | {"valid": False, "why": reason}, noise
    inside = usable(blocks, wheel, rotor.slowest)
    steady = blocks.part(inside & shows_torque(blocks, known, wheel) if power else inside)
    if len(steady) < FEWEST:
        left_out = {
            "a gap, less than four samples a minute or a change of mode": gaps,
            "a stuck sensor of current or speed": row["stuck_blocks"],
        }
        reason = lack(len(steady), blocks, wheel, rotor.slowest, left_out, power=power)
        return row | _unknown(reason) | {"valid": False, "why": reason}, noise
    doubt = "" if power else unit_doubt(steady, known, wheel)
    if doubt:
        return row | _unknown(doubt) | {"valid": False, "why": doubt}, noise
    step = resolution(steady, wheel)
    rows = regression_rows(steady, known, wheel, window, length, power=power, step=step)
    interval = float(np.median(steady.length / steady.count))
    warm = float(row.get("temperature_mean", np.nan))
    prior = prior_of(rotor, rows.regressors.shape[1], interval, warm)
    rows, prior = about_its_share(rows, prior, noise or USUAL)
    speeds = np.abs(steady.speed[:, wheel])
    speed = float(np.median(speeds))
    if power:
        step = known.power_resolution / (rotor.motor_constant * speed)
    errors = partial(rounding_errors, steady, wheel, rows, prior, step=step)
    value = agreeing_estimate(rows, prior, noise or USUAL, errors)
    row |= _values(value, rows, speeds)
    row |= residual_columns(blocks, steady, known, wheel, value, rows)
    known_motor = value.prior.precision[MOTOR] == prior.precision[MOTOR]
    row |= verdict(value, rotor, first=noise is None, known=known_motor)
    if power and row["valid"]:
        friction = value.mean + value.value[VISCOUS] * speed + 2.0 * np.sqrt(value.mean_variance)
        doubt = doubt_of(steady, known, wheel, float(friction))
        if doubt:
            row |= {"valid": False, "why": doubt}
    return row, value.noise if row["valid"] else noise


def _values(value: Estimate, rows: Rows, speeds: Vector) -> dict[str, Any]:
    """Columns of the parameters."""
    row: dict[str, Any] = {}
    for name, place in _PLACES.items():
        row[name] = float(value.value[place])
        row[f"{name}_sigma"] = float(np.sqrt(value.covariance[place, place]))
        row[f"{name}_scatter"] = float(np.sqrt(max(value.scatter[place, place], 0.0)))
        if name in REGRESSED[1:]:
            row[f"{name}_known"] = float(value.prior.precision[place] ** -0.5)
    row |= {
        "coulomb": value.mean,
        "coulomb_sigma": float(np.sqrt(value.mean_variance)),
        "coulomb_scatter": float(np.sqrt(max(value.mean_scatter, 0.0))),
        "coulomb_level": float(value.value[COULOMB]),
        "coulomb_level_sigma": float(np.sqrt(value.covariance[COULOMB, COULOMB])),
        "noise_sigma": value.noise_sigma,
        "noise_time": float(np.exp(value.noise.log_time)),
        "held_as_stated": ", ".join(n for n, place in _PLACES.items() if place in value.held),
    }
    for first, second in combinations(REGRESSED, 2):
        a, b = _PLACES[first], _PLACES[second]
        covariance = value.mean_covariance[b] if first == "coulomb" else value.covariance[a, b]
        row[f"cov_{first}_{second}"] = float(covariance)
    for name, reason in _reasons(value, rows, speeds).items():
        row[f"{name}_observable"] = not reason
        row[f"{name}_reason"] = reason
    return row


def _reasons(value: Estimate, rows: Rows, speeds: Vector) -> Mapping[str, str]:
    """Why each parameter is not observable; empty if it is.

    A parameter counts by what the window says of it, without what was known of it beforehand.
    """
    variance = np.diagonal(value.covariance).copy()
    variance[COULOMB] = value.mean_variance
    told = 1.0 / np.maximum(1.0 / variance - value.prior.precision[: variance.size], 1e-300)
    scale = np.abs(value.value)
    scale[COULOMB] = scale[OFFSET] = abs(value.mean)
    limit = np.full(variance.size, OBSERVABLE)
    within = f"the speed stays within {speeds.min():.4g} and {speeds.max():.4g} rad/s"
    one_sign = bool(np.ptp(rows.regressors[:, OFFSET]) == 0.0)
    known = "motor constant and viscous friction"
    if variance.size > IDLE:
        known = "motor constant, viscous friction and idle power"
    why = {
        "coulomb": f"{within}, and what is known of {known} leaves it open",
        "viscous": within,
        "motor_constant": "the momentum that the wheel exchanges changes too little: only what is "
        "known beforehand holds",
        "offset": "the speed keeps one sign" if one_sign else "its error is too large",
    }
    if one_sign:
        told[OFFSET] = np.inf
    return {
        name: "" if told[p] < (limit[p] * scale[p]) ** 2 else why[name]
        for name, p in _PLACES.items()
    }


def _unknown(reason: str) -> dict[str, Any]:
    """Columns of the parameters where there is no estimate."""
    return {f"{name}_reason": reason for name in _PLACES}
