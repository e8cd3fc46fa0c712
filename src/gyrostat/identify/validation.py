"""How well a known wheel predicts a record that it was not fitted to."""

from dataclasses import dataclass

import numpy as np

from gyrostat._types import Vector
from gyrostat.errors import InputError
from gyrostat.friction import Friction
from gyrostat.identify.batch import identify
from gyrostat.identify.prediction import CurrentHold
from gyrostat.identify.statistics import Whiteness, crossing_times, noise_level
from gyrostat.telemetry import Record

NEAR_CROSSING = 2.0
"""s on either side of a zero crossing that count as near it."""


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

    def to_dict(self) -> dict[str, object]:
        """The content of validation.json."""
        return {
            "record": self.record.name,
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


def validate(
    model: type[Friction],
    values: dict[str, float],
    record: Record,
    *,
    current_hold: CurrentHold = "zero-order",
) -> Validation:
    """Predict a record with a known wheel; only the speed at its first sample is estimated.

    Args:
        model: friction model.
        values: all parameters of the wheel, SI.
        record: not used to find them.
        current_hold: the current between samples.

    Raises:
        InputError: the record cannot be predicted.
    """
    fit = identify(record, model=model.name, hold=dict(values), current_hold=current_hold)
    residual = fit.residuals[0]
    used = residual[record.valid]
    if not np.all(np.isfinite(used)):
        raise InputError(f"{record.name}: found no finite prediction, expected a wheel that turns")
    changes = crossing_times(record.time, fit.predicted[0], fit.speed_sigma)
    near = np.zeros(len(record.time), dtype=bool)
    for change in changes:
        near |= np.abs(record.time - change) <= NEAR_CROSSING
    close = residual[near & record.valid]
    return Validation(
        record=record,
        predicted=fit.predicted[0],
        initial_speed=fit.parameters["initial_speed"],
        rms_speed=float(np.sqrt(np.mean(used**2))),
        mean=float(np.mean(used)),
        largest=float(np.max(np.abs(used))),
        rms_near_crossings=float(np.sqrt(np.mean(close**2))) if len(close) else None,
        noise=noise_level(record.speed[record.valid]),
        samples=len(used),
        crossings=fit.crossings,
        whiteness=fit.whiteness,
    )
