"""Validation of a known wheel on an independent record."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.pictured import Pictured
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.views import lines
from gyrostat.identification.fit.least_squares import UNFINISHED, Evaluation, Prior, minimise
from gyrostat.identification.fit.loss import Quadratic
from gyrostat.identification.fit.prediction import CurrentHold, Linearisation, SpeedPrediction
from gyrostat.identification.judge.acceptance_lines import Acceptance
from gyrostat.identification.read.checks import check_signals
from gyrostat.identification.read.statistics import (
    NUMERICAL_NOISE,
    Whiteness,
    crossing_times,
    noise_level,
    whiteness,
)
from gyrostat.telemetry import Record, cut
from gyrostat.wheel.friction import Friction

NEAR_CROSSING = 2.0
"""Time on either side of a zero crossing that counts as near it, s."""
ENOUGH = 0.8
"""Smallest fraction of the samples inside the 95 % prediction interval for a valid model. The
errors of the parameters are common to all samples: a correct model has 95 % inside on average, and
clearly fewer in one record of twenty."""
INTERVAL = 1.959964
"""Standard deviations of a 95 % interval."""
FIRST_SPEEDS = 5
"""Number of speeds that give the range of the initial speed."""
REACH = 5.0
"""Standard deviations by which the initial speed may lie outside the range of the first speeds. A
larger value would only hide a bad model."""


@dataclass(frozen=True, repr=False)
class Validation(Pictured):
    """Residuals of a record for a fixed wheel model.

    Attributes:
        record: Predicted record.
        predicted: Modelled speed at its samples, rad/s.
        initial_speed: Speed at the first sample, estimated from the record, rad/s.
        rms_speed: Root mean square residual, rad/s.
        mean: Mean residual, rad/s.
        largest: Largest residual in magnitude, rad/s.
        rms_near_crossings: Root mean square residual within `NEAR_CROSSING` of a sign change,
            rad/s; None without any.
        noise: Tachometer noise estimated from the record itself, rad/s.
        samples: Number of speeds used.
        crossings: Sign changes of the modelled speed.
        whiteness: Independence tests of the residuals.
        converged: Whether the initial speed was found.
        predicted_sigma: Standard deviation of the modelled speed from the uncertain parameters,
            (N,), rad/s.
        inside: Fraction of the speeds within the 95 % prediction interval (parameters and noise).
        names: Parameters whose standard deviation is known.
        information: Information matrix of these n parameters from this record alone, in white noise
            and with the initial speeds unknown, (n, n), SI.
        acceptance: Judgement against a data sheet; None without one.
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
    predicted_sigma: Vector
    inside: float
    names: tuple[str, ...]
    information: Matrix
    acceptance: Acceptance | None = None

    @property
    def holds(self) -> bool:
        """Whether the model predicts the record within its own uncertainty."""
        return self.inside >= ENOUGH

    def __repr__(self) -> str:
        """Text that the command line prints."""
        return "\n".join(lines(self))

    @property
    def verdict(self) -> str:
        """Result of the validation in one sentence."""
        verdict = "holds" if self.holds else "FAILS"
        return (
            f"the model {verdict}: {100.0 * self.inside:.1f} % of the samples lie inside the 95 % "
            f"prediction interval (parameters and noise), {100.0 * ENOUGH:.0f} % are required"
        )

    def to_dict(self) -> dict[str, object]:
        """Content of validation.json."""
        return {
            "record": self.record.name,
            "converged": self.converged,
            "holds": self.holds,
            "inside": self.inside,
            "asked_for": ENOUGH,
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
            "acceptance": None if self.acceptance is None else self.acceptance.to_dict(),
        }


def _best_prediction(
    prediction: SpeedPrediction, values: Mapping[str, float], noise: float
) -> tuple[float, Linearisation, bool]:
    """Initial speed that fits a record best, the resulting speed, and whether it was found.

    Every segment of the record has its own initial speed; that of the first one is returned.
    """
    record = prediction.records[0]
    parameters = {"current_bias": 0.0, **values}
    wheel = prediction.names[: -len(prediction.initial_speeds)]
    missing = [n for n in wheel if n not in parameters]
    if missing:
        raise InputError(f"wheel model: found no {missing[0]}, expected its value")
    base = np.array([parameters[n] for n in wheel], dtype=float)
    speeds = [record.speed[part][record.valid[part]] for part in record.segments]
    sigma = max(noise, NUMERICAL_NOISE * float(np.max(np.abs(np.concatenate(speeds))))) or 1.0
    first = np.array([np.median(segment[:FIRST_SPEEDS]) for segment in speeds])
    reach = REACH * sigma + np.array([np.ptp(segment[:FIRST_SPEEDS]) for segment in speeds])

    def evaluate(x: Vector) -> Evaluation | None:
        # a model that sticks is not refused: its residuals show how bad it is
        point = prediction(np.append(base, x))
        if point is None:
            return None
        speed, rows = point[0]
        residual = (record.speed - speed)[record.valid]
        return residual / sigma, rows[record.valid, len(base) :] / sigma

    # keeps the problem regular if the wheel rests and the initial speed has no effect
    weak = Prior(first, reach)
    solution = minimise(evaluate, weak.mean, weak, Quadratic())
    unlike = f"{record.name}: found no initial speed for this wheel, expected finite "
    unlike += "parameters, positive scales and a friction curve that the samples resolve"
    if solution is None:
        raise InputError(unlike)
    initial = np.clip(solution.x, first - reach, first + reach)
    linear = prediction.linearise(np.append(base, initial))
    if linear is None:
        raise InputError(unlike)
    # the bounded minimum lies at a bound, or where no correction lowers the cost
    converged = solution.reason != UNFINISHED or np.any(initial != solution.x)
    return float(initial[0]), linear[0], bool(converged)


def _parameter_columns(
    prediction: SpeedPrediction, linear: Linearisation, names: Sequence[str]
) -> Matrix:
    """Derivatives of the speed by parameters, (N, n), with the initial speeds refitted.

    The initial speeds are refitted for every choice of the parameters; the part of a derivative
    that they compensate is removed.
    """
    columns = linear.jacobian[:, [prediction.names.index(n) for n in names]]
    starts = linear.jacobian[:, -len(prediction.initial_speeds) :]
    valid = prediction.records[0].valid
    return columns - starts @ np.linalg.lstsq(starts[valid], columns[valid], rcond=1e-10)[0]


def validate(
    model: type[Friction],
    values: Mapping[str, float],
    record: Record,
    *,
    current_hold: CurrentHold = "zero-order",
    covariance: tuple[Sequence[str], Matrix] | None = None,
) -> Validation:
    """Predict a record with a known wheel; only the initial speed of each segment is estimated.

    Args:
        model: Friction model.
        values: All parameters of the wheel, SI; and current_bias, A, if the drive has one.
        record: Record that was not used to identify the wheel.
        current_hold: Interpolation of the current between samples.
        covariance: Names of identified parameters and the covariance of their errors, (n, n), SI;
            None if all values are exact.

    Raises:
        InputError: A parameter is missing, or the record cannot be predicted.
    """
    record = cut(record)
    check_signals([record])
    noise = noise_level(record.speed[record.valid])
    prediction = SpeedPrediction([record], model, current_hold)
    initial, linear, converged = _best_prediction(prediction, values, noise)
    names, matrix = covariance or ((), np.zeros((0, 0)))
    columns = _parameter_columns(prediction, linear, names)
    variance = np.einsum("mi,ij,mj->m", columns, matrix, columns)
    speed, spread = linear.speed, np.sqrt(np.maximum(variance, 0.0))
    residual = record.speed - speed
    errors = residual[record.valid]
    exact = NUMERICAL_NOISE * float(np.sqrt(np.mean(speed**2)))
    level = float(np.hypot(noise, exact)) or 1.0
    width = INTERVAL * np.sqrt(spread**2 + noise**2 + exact**2)
    changes = crossing_times(record.time, speed, noise)
    near = np.zeros(len(record.time), dtype=bool)
    for change in changes:
        near |= np.abs(record.time - change) <= NEAR_CROSSING
    close = residual[near & record.valid]
    return Validation(
        record=record,
        predicted=speed,
        initial_speed=initial,
        rms_speed=float(np.sqrt(np.mean(errors**2))),
        mean=float(np.mean(errors)),
        largest=float(np.max(np.abs(errors))),
        rms_near_crossings=float(np.sqrt(np.mean(close**2))) if len(close) else None,
        noise=noise,
        samples=len(errors),
        crossings=len(changes),
        whiteness=whiteness(errors) if len(errors) >= 10 else None,
        converged=converged,
        predicted_sigma=spread,
        inside=float(np.mean(np.abs(errors) <= width[record.valid])),
        names=tuple(names),
        information=columns[record.valid].T @ columns[record.valid] / level**2,
    )
