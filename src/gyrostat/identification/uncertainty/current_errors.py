"""Errors of a recorded current: rounding, steps between two samples, an offset.

A current that is recorded to 1 mA and held for 30 s has one constant error of up to 0.5 mA, which
no number of samples averages out. A current that steps between two samples acts from an unknown
time on. Both are currents that are added to the recorded one, with unknown coefficients of known
prior.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.prediction import CurrentHold, Linearisation, SpeedPrediction
from gyrostat.identification.read.current_steps import steps_of
from gyrostat.identification.read.quantisation import held_levels
from gyrostat.identification.uncertainty.effects import CONSTANT_TORQUE, Nuisance, accumulated
from gyrostat.telemetry import Record

ROUNDED = 1.0 / np.sqrt(12.0)
"""Standard deviation of an error of rounding, in steps."""
CONSTANT = 0.03
"""Prior sigma of a constant torque, fraction of that of the rms current."""
ROUNDING = 20.0
"""Prior odds that currents with a common step were rounded to it, and are not exact set points."""
STEPPED = 1.0 / np.sqrt(3.0)
"""Root mean square of the fraction of an interval after a step of the current that is in it."""
MOST_STEPS = 60
"""Largest number of steps with a time of their own."""
STEPS = "current_steps"


@dataclass(frozen=True)
class CurrentError:
    """Currents that are added to the recorded one.

    Attributes:
        name: Identifier in fit.json.
        title: Title in reports.
        unit: Unit of the coefficients.
        sigma: Prior standard deviation of each coefficient, in `unit`.
        shapes: For each record the current in each interval per coefficient, (N - 1, m), A.
        odds: Prior odds of its presence.
        at: Zeros if the error is certainly present, (m,); None if its presence is to be decided.
    """

    name: str
    title: str
    unit: str
    sigma: float
    shapes: tuple[Matrix, ...]
    odds: float
    at: Vector | None = None

    def nuisance(self, prediction: SpeedPrediction, linear: Sequence[Linearisation]) -> Nuisance:
        """The same as changes of the speed, linearised at a fit."""
        bias = prediction.names.index("current_bias")
        columns = [
            accumulated(each, shape * each.local[:, bias, None])
            for shape, each in zip(self.shapes, linear, strict=True)
        ]
        return Nuisance(
            self.name,
            self.title,
            self.unit,
            (self.sigma,),
            tuple(columns),
            self.at,
            odds=self.odds,
            currents=self.shapes,
        )


def rounded_current(
    records: Sequence[Record], step: float, *, stated: bool = False
) -> tuple[CurrentError | None, list[Vector]]:
    """Errors of a current that was rounded.

    Args:
        records: Records of one drive.
        step: Step of the current, A.
        stated: Whether the rounding is certain.

    Returns:
        Constant errors of held currents, or None if none is held; and the variance of all other
        currents, independent from one interval to the next, (N - 1,), A², for each record.
    """
    numbers, common, count = held_levels(records, step)
    variances = [size * (ROUNDED * step) ** 2 for size in common]
    if not count:
        return None, variances
    shapes = [(index[:, None] == np.arange(count)).astype(float) for index in numbers]
    title = f"rounding of the current to {1e3 * step:.4g} mA, error of a held current"
    at = np.zeros(count) if stated else None
    sigma = ROUNDED * step
    return CurrentError(
        "current_rounding", title, "A", sigma, tuple(shapes), ROUNDING, at
    ), variances


def constant_torque(records: Sequence[Record]) -> CurrentError:
    """Constant torque, as a current: an offset of the drive, or friction that differs by direction.

    Args:
        records: Records of one wheel and drive.
    """
    rms = float(np.sqrt(np.mean(np.concatenate([r.current for r in records]) ** 2)))
    shapes = tuple(np.full((len(r.time) - 1, 1), rms) for r in records)
    title = "constant torque (current offset or direction asymmetry), fraction of the rms current"
    return CurrentError(CONSTANT_TORQUE, title, "1", CONSTANT, shapes, 1.0)


def current_steps(records: Sequence[Record], hold: CurrentHold) -> CurrentError | None:
    """Steps of the current between two samples, at unknown times.

    The coefficient is the fraction of the interval for which the next sample's current acts.

    Args:
        records: Records of one drive.
        hold: Current between samples; one that is linear does not step.
    """
    if hold != "zero-order":
        return None
    places = [
        (abs(record.current[i + 1] - record.current[i]), k, i)
        for k, record in enumerate(records)
        for i in steps_of(record)
    ]
    if not places:
        return None
    places = sorted(places, key=lambda entry: -entry[0])[:MOST_STEPS]
    shapes = [np.zeros((len(record.time) - 1, len(places))) for record in records]
    for j, (_, k, i) in enumerate(places):
        shapes[k][i, j] = records[k].current[i + 1] - records[k].current[i]
    title = "steps of the current between samples, fraction of the interval"
    return CurrentError(STEPS, title, "1", STEPPED, tuple(shapes), 1.0)
