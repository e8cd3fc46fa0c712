"""Prediction of an independent record by a known wheel."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.identification.checks import check_signals
from gyrostat.identification.least_squares import UNFINISHED, Evaluation, Prior, minimise
from gyrostat.identification.loss import Quadratic
from gyrostat.identification.prediction import CurrentHold, SpeedPrediction
from gyrostat.identification.statistics import (
    NUMERICAL_NOISE,
    Whiteness,
    crossing_times,
    noise_level,
    whiteness,
)
from gyrostat.telemetry import Record, cut
from gyrostat.wheel.friction import Friction

NEAR_CROSSING = 2.0
"""s on either side of a zero crossing that count as near it."""
FIRST_SPEEDS = 5
"""Speeds that tell where the initial one lies."""
REACH = 5.0
"""Standard deviations, beyond the range of the first speeds, within which the initial one is taken:
one further away would only hide how bad a wheel is."""


@dataclass(frozen=True)
class Validation:
    """Residuals of a record under a fixed wheel.

    Attributes:
        record: the record.
        predicted: modelled speed at its samples, rad/s.
        initial_speed: at the first sample, rad/s, estimated from the record.
        rms_speed: root mean square residual, rad/s.
        mean: residual, rad/s.
        largest: residual in size, rad/s.
        rms_near_crossings: within `NEAR_CROSSING` of a sign change, rad/s; None without any.
        noise: level of the tachometer noise seen in the record itself, rad/s.
        samples: speeds used.
        crossings: sign changes of the modelled speed.
        whiteness: of the residuals.
        converged: whether the initial speed was found.
    """

    record: Record
    predicted: Vector
    initial_speed: float
    rms_speed: float
    mean: float
    largest: float
    rms_near_crossings: float | None
    noise: float
    samples: int
    crossings: int
    whiteness: Whiteness | None
    converged: bool

    def to_dict(self) -> dict[str, object]:
        """The content of validation.json."""
        return {
            "record": self.record.name,
            "converged": self.converged,
            "rms_speed": self.rms_speed,
            "mean": self.mean,
            "largest": self.largest,
            "rms_near_crossings": self.rms_near_crossings,
            "noise": self.noise,
            "unit": "rad/s",
            "initial_speed": self.initial_speed,
            "samples": self.samples,
            "crossings": self.crossings,
            "residuals": None if self.whiteness is None else self.whiteness.to_dict(),
        }


def _best_prediction(
    prediction: SpeedPrediction, values: Mapping[str, float], noise: float
) -> tuple[float, Vector, bool]:
    """Initial speed that suits a record best, the speed that follows, and whether it was found.

    Every segment of the record has one; the first is returned.
    """
    record = prediction.records[0]
    told = {"current_bias": 0.0, **values}
    wheel = prediction.names[: -len(prediction.initial_speeds)]
    missing = [n for n in wheel if n not in told]
    if missing:
        raise InputError(f"wheel model: found no {missing[0]}, expected its value")
    base = np.array([told[n] for n in wheel], dtype=float)
    speeds = [record.speed[part][record.valid[part]] for part in record.segments]
    sigma = max(noise, NUMERICAL_NOISE * float(np.max(np.abs(np.concatenate(speeds))))) or 1.0
    first = np.array([np.median(own[:FIRST_SPEEDS]) for own in speeds])
    reach = REACH * sigma + np.array([np.ptp(own[:FIRST_SPEEDS]) for own in speeds])

    def evaluate(x: Vector) -> Evaluation | None:
        # a wheel that sticks is a bad model, and its residuals shall say how bad
        predicted = prediction(np.append(base, x))
        if predicted is None:
            return None
        speed, rows = predicted[0]
        residual = (record.speed - speed)[record.valid]
        return residual / sigma, rows[record.valid, len(base) :] / sigma

    # keeps the problem regular where the wheel rests and nothing shows how it started
    weak = Prior(first, reach)
    solution = minimise(evaluate, weak.mean, weak, Quadratic())
    unlike = f"{record.name}: found no speed that this wheel could have had, expected finite "
    unlike += "parameters, positive scales and a friction curve that the samples resolve"
    if solution is None:
        raise InputError(unlike)
    initial = np.clip(solution.x, first - reach, first + reach)
    predicted = prediction(np.append(base, initial))
    if predicted is None:
        raise InputError(unlike)
    # one parameter between two ends has its minimum there, or where no correction lowers the cost
    found = solution.reason != UNFINISHED or np.any(initial != solution.x)
    return float(initial[0]), predicted[0][0], bool(found)


def validate(
    model: type[Friction],
    values: Mapping[str, float],
    record: Record,
    *,
    current_hold: CurrentHold = "zero-order",
) -> Validation:
    """Predict a record with a known wheel; only the speed at its first sample is estimated.

    Args:
        model: friction model.
        values: all parameters of the wheel, SI; current_bias, A, where the drive has one.
        record: not used to find them.
        current_hold: the current between samples.

    Raises:
        InputError: a parameter is missing, or the record cannot be predicted.
    """
    record = cut(record)
    check_signals([record])
    noise = noise_level(record.speed[record.valid])
    prediction = SpeedPrediction([record], model, current_hold)
    initial, speed, found = _best_prediction(prediction, values, noise)
    residual = record.speed - speed
    used = residual[record.valid]
    changes = crossing_times(record.time, speed, noise)
    near = np.zeros(len(record.time), dtype=bool)
    for change in changes:
        near |= np.abs(record.time - change) <= NEAR_CROSSING
    close = residual[near & record.valid]
    return Validation(
        record=record,
        predicted=speed,
        initial_speed=initial,
        rms_speed=float(np.sqrt(np.mean(used**2))),
        mean=float(np.mean(used)),
        largest=float(np.max(np.abs(used))),
        rms_near_crossings=float(np.sqrt(np.mean(close**2))) if len(close) else None,
        noise=noise,
        samples=len(used),
        crossings=len(changes),
        whiteness=whiteness(used) if len(used) >= 10 else None,
        converged=bool(found),
    )
