"""Row of the window table for one wheel from the blocks of a window."""

from collections.abc import Mapping
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.monitoring.blocks import Blocks
from gyrostat.monitoring.estimate import APART, Estimate, Rows, estimate
from gyrostat.monitoring.moments import COULOMB, IDLE, MOTOR, OFFSET, VISCOUS, Prior, stated
from gyrostat.monitoring.noise import Noise
from gyrostat.monitoring.noise_search import USUAL
from gyrostat.monitoring.power import doubt_of, shows_torque
from gyrostat.monitoring.residuals import residual_columns
from gyrostat.monitoring.rounding import rounding_variance
from gyrostat.monitoring.rows import (
    nominal_torques,
    prior_of,
    regression_rows,
    turns_one_way,
    usable,
)
from gyrostat.monitoring.statistics import plain_columns, standstill_columns
from gyrostat.monitoring.stuck import stuck
from gyrostat.monitoring.wheel_data import KnownWheel, KnownWheels
from gyrostat.monitoring.windows import REGRESSED

OBSERVABLE = 0.3
"""Largest standard deviation of an observable parameter, over its value."""
FEWEST = 30
"""Smallest number of blocks of an estimate."""
LARGEST_NOISE = 0.5
"""Friction noise over Coulomb torque above which the balance of torques does not hold."""
FAR = 100.0
"""Motor torque over that of nominal friction and acceleration above which it, or below one over
which it has probably another unit."""
CLEARLY = 3.0
"""Negative Coulomb torque, in its sigma, that is no estimate of a positive one."""
TOLD = 0.75
"""Share of the variance of what was known beforehand that data must remove to contradict it."""
IMPLAUSIBLE = 2.0
"""Motor constant over the stated one, or its inverse, that no fault of a motor explains."""
_RPM = np.pi / 30.0
_MISREAD = {
    ", as if speeds in rad/s were read as rpm": _RPM,
    ", as if speeds in rpm were read as rad/s": 1.0 / _RPM,
}
"""What a wrong unit of the speed makes of the motor constant."""
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
    rotor = known.wheels[wheel]
    row = {"wheel": rotor.name, "start": window[0], "end": window[1]}
    row |= plain_columns(blocks, wheel, window)
    row |= standstill_columns(blocks, known, wheel) | exchange
    if drive == "none":
        reason = "there is no motor current, electrical power or commanded torque"
        return row | _unknown(reason) | {"valid": False, "why": reason}, noise
    power = drive == "power"
    held = np.zeros(len(blocks), bool) if power else stuck(blocks, known, wheel)
    row["stuck_blocks"] = int(np.sum(held))
    inside = usable(blocks, wheel, rotor.slowest) & ~held
    steady = blocks.part(inside & shows_torque(blocks, known, wheel) if power else inside)
    if len(steady) < FEWEST:
        reason = _lack(len(steady), blocks, held, wheel, rotor.slowest, total, power=power)
        return row | _unknown(reason) | {"valid": False, "why": reason}, noise
    doubt = "" if power else _doubt(steady, known, wheel)
    if doubt:
        return row | _unknown(doubt) | {"valid": False, "why": doubt}, noise
    rows = regression_rows(steady, known, wheel, window, length, power=power)
    interval = float(np.median(steady.length / steady.count))
    warm = float(row.get("temperature_mean", np.nan))
    prior = prior_of(rotor, rows.regressors.shape[1], interval, warm)
    value = _estimated(rows, prior, noise or USUAL)
    step, speed = None, float(np.median(np.abs(steady.speed[:, wheel])))
    if power:
        step = known.power_resolution / (rotor.motor_constant * speed)
    added = rounding_variance(steady, wheel, value, window, step)
    row |= _values(value, rows, added)
    row |= residual_columns(blocks, steady, known, wheel, value, rows)
    row |= _verdict(value, rotor, known=value.prior.precision[MOTOR] == prior.precision[MOTOR])
    if power and row["valid"]:
        friction = value.mean + value.value[VISCOUS] * speed + 2.0 * np.sqrt(value.mean_variance)
        doubt = doubt_of(steady, known, wheel, float(friction))
        if doubt:
            row |= {"valid": False, "why": doubt}
    return row, value.noise if row["valid"] else noise


def _lack(
    steady: int,
    blocks: Blocks,
    held: NDArray[np.bool_],
    wheel: int,
    slowest: float,
    total: int,
    *,
    power: bool,
) -> str:
    """Why a window has too few usable blocks, with the number of blocks that each reason holds for.

    Args:
        steady: Number of usable blocks.
        blocks: Whole blocks of the window.
        held: Blocks with a stuck sensor.
        wheel: Place of the wheel.
        slowest: Speed below which a block is not used, rad/s.
        total: Number of blocks with those that are not whole.
        power: Whether the drive comes from the electrical power.
    """
    gaps, blocks = total - len(blocks), blocks.part(~held)
    drive = np.isfinite(blocks.drive[:, wheel])
    speed = np.isfinite(blocks.other_change[:, wheel])
    slow = ~turns_one_way(blocks, wheel, slowest)
    lacking = "no power above idle_power, or too slow" if power else "no current or torque"
    counts = {
        "a gap, less than four samples a minute or a change of mode": gaps,
        "a sensor of speed or drive that is stuck": int(np.sum(held)),
        "no speed": int(np.sum(~speed)),
        lacking: int(np.sum(speed & ~drive)),
        f"a speed below {slowest:.3g} rad/s or of both signs": int(np.sum(speed & drive & slow)),
    }
    told = [f"{count} with {name}" for name, count in counts.items() if count]
    braking = int(np.sum(speed & drive & ~slow)) - steady
    if braking:
        told.append(
            f"{braking} that brake or whose friction is not well above the error of idle_power and "
            "power_resolution"
        )
    needed = f"{steady} of {total} blocks are usable, at least {FEWEST} are needed"
    return f"{needed}: {', '.join(told)}" if told else needed


def _doubt(blocks: Blocks, known: KnownWheels, wheel: int) -> str:
    """Why the drive is probably stuck, or has another unit; empty if neither is likely."""
    drive = blocks.drive[:, wheel]
    if np.all(blocks.step[:, wheel] == np.inf) and np.ptp(drive) < 1e-12:
        return "the current or torque has one value in the whole window: is its sensor stuck?"
    friction, accelerating = nominal_torques(blocks, known, wheel)
    driven = known.wheels[wheel].motor_constant * np.abs(drive)
    times = float(np.median(driven) / np.median(friction + np.abs(accelerating)))
    if 1.0 / FAR < times < FAR:
        return ""
    return (
        f"the motor torque is {times:.3g} times that of the stated friction: is the unit of "
        "current or torque right, and are motor_constant, inertia, coulomb and viscous?"
    )


def _estimated(rows: Rows, prior: Prior, noise: Noise) -> Estimate:
    """Estimate; without what was known beforehand of a parameter where the data contradict."""
    start = prior.mean.copy()
    value = estimate(rows, prior, start, noise)
    prior, wrong = value.prior, []
    for place in stated(start.size):
        variance, precision = value.covariance[place, place], prior.precision[place]
        away = abs(value.value[place] - prior.mean[place])
        # the variance of the difference between the prior and an estimate that contains it
        spread = 1.0 / precision - variance
        # weak data may differ by much in their own sigma, by nothing that counts
        told = spread > TOLD / precision and away > APART * np.sqrt(spread)
        if told or away > APART / np.sqrt(precision):
            wrong.append(place)
    if not wrong:
        return value
    return estimate(rows, prior.without(wrong), value.value, value.noise)


def _values(value: Estimate, rows: Rows, added: float) -> dict[str, Any]:
    """Columns of the parameters."""
    row: dict[str, Any] = {}
    mean_variance = value.mean_variance + added
    for name, place in _PLACES.items():
        row[name] = float(value.value[place])
        row[f"{name}_sigma"] = float(np.sqrt(value.covariance[place, place]))
        row[f"{name}_scatter"] = float(np.sqrt(max(value.scatter[place, place], 0.0)))
        if name in REGRESSED[1:]:
            row[f"{name}_known"] = float(value.prior.precision[place] ** -0.5)
    level_variance = value.covariance[COULOMB, COULOMB] + added
    row |= {
        "coulomb": value.mean,
        "coulomb_sigma": float(np.sqrt(mean_variance)),
        "coulomb_scatter": float(np.sqrt(max(value.mean_scatter, 0.0) + added)),
        "coulomb_level": float(value.value[COULOMB]),
        "coulomb_level_sigma": float(np.sqrt(level_variance)),
        "noise_sigma": value.noise_sigma,
        "noise_time": float(np.exp(value.noise.log_time)),
    }
    for first, second in combinations(REGRESSED, 2):
        a, b = _PLACES[first], _PLACES[second]
        covariance = value.mean_covariance[b] if first == "coulomb" else value.covariance[a, b]
        row[f"cov_{first}_{second}"] = float(covariance)
    for name, reason in _reasons(value, rows, mean_variance).items():
        row[f"{name}_observable"] = not reason
        row[f"{name}_reason"] = reason
    return row


def _reasons(value: Estimate, rows: Rows, mean_variance: float) -> Mapping[str, str]:
    """Why each parameter is not observable; empty if it is.

    A parameter counts by what the window says of it, without what was known of it beforehand.
    """
    variance = np.diagonal(value.covariance).copy()
    variance[COULOMB] = mean_variance
    told = 1.0 / np.maximum(1.0 / variance - value.prior.precision[: variance.size], 1e-300)
    scale = np.abs(value.value)
    scale[COULOMB] = scale[OFFSET] = abs(value.mean)
    limit = np.full(variance.size, OBSERVABLE)
    speeds = np.abs(rows.regressors[:, VISCOUS])
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


def _verdict(value: Estimate, rotor: KnownWheel, *, known: bool) -> dict[str, Any]:
    """Whether the estimates hold.

    Args:
        value: Estimate.
        rotor: The wheel as stated.
        known: Whether the data agree with the stated motor constant.
    """
    why, negative = "", "the Coulomb torque is negative: has the current the sign of its torque?"
    times = value.value[MOTOR] / rotor.motor_constant
    sigma = np.sqrt(value.covariance[MOTOR, MOTOR]) / rotor.motor_constant
    # of a power, the gain of its measurement takes the place of the motor constant
    told = value.value.size <= IDLE and (abs(times - 1.0) > APART * sigma or not known)
    if not np.all(np.isfinite(value.value)) or value.value[MOTOR] <= 0.0:
        why = "the balance of torques has no solution with a positive motor constant"
    elif told and not 1.0 / IMPLAUSIBLE < times < IMPLAUSIBLE:
        reads = next((r for r, f in _MISREAD.items() if 0.8 < times / f < 1.25), "")
        why = (
            negative
            if value.mean < 0.0
            else (
                f"the motor constant is {times:.3g} times the stated one{reads}: are the units of "
                "speed and current right, and inertia and motor_constant?"
            )
        )
    elif value.noise_sigma > LARGEST_NOISE * abs(value.mean):
        share = 100.0 * value.noise_sigma / abs(value.mean)
        why = f"the balance of torques leaves {share:.0f} % of the Coulomb torque"
    elif value.mean < -CLEARLY * np.sqrt(value.mean_variance):
        why = negative
    return {"valid": not why, "why": why}


def _unknown(reason: str) -> dict[str, Any]:
    """Columns of the parameters where there is no estimate."""
    return {f"{name}_reason": reason for name in _PLACES}
