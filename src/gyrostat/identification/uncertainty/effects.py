"""Effects of real wheels and drives outside the friction model.

A friction model in white noise is never complete: tachometers lag, lubricants warm up, bearings
and motors have torque ripple. Each such effect is a candidate here, linearised at a fit. A
deterministic effect is a column of derivatives with an unknown coefficient (`Nuisance`); a random
torque is a process noise of the wheel's speed
(`gyrostat.identification.uncertainty.torque_noise`). The scales of every candidate are
derived from the wheel and the record and span decades; none is tuned to a particular wheel.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gyrostat.core.jax64 import jax
from gyrostat.core.stored_function import stored_function
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.prediction import (
    Linearisation,
    SpeedPrediction,
    over_intervals,
    padded,
)
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import Friction

LAGS = (0.1, 0.3, 1.0)
"""Prior sigmas of a tachometer lag, in sample intervals."""
SLOWEST_LAG = 0.1
"""Largest lag considered in a fast record, s; tachometer filters reach this."""
DRIFTS = (0.03, 0.1, 0.3)
"""Prior sigmas of a drift of friction from mid-record to the end, fraction of the friction."""
DRIFTING = (
    ("viscous", "viscous", "viscous friction", DRIFTS, None),
    ("torque", "coulomb", "dry friction", DRIFTS[:2], 1.0),
)
"""Dimension of the parameters that drift together; identifier, title, prior sigmas and prior odds
of the drift. That of the dry friction is no hint at other effects."""
CONSTANT_TORQUE = "constant_torque"
"""Identifier of a torque that the diagnosis names by its causes: current offset, asymmetry."""
WAVES, MOST_WAVES = 8, 16
"""Number of cosines of a variation of friction about its drift in a record, and in all records
together. The k-th has k half periods in the record and 1/k of the amplitude, as those of a random
walk (Karhunen and Loève)."""
RIPPLES = (0.01, 0.03, 0.1)
"""Levels of a torque noise, fractions of the friction torque."""
LARGEST_RIPPLE_ODDS = 4.0
"""Prior odds of the largest of these levels, for the ripple at zero crossings. The few crossings of
a record hardly tell the level, on which the sigma of the static torque depends; the odds are chosen
by measured coverage (`benchmarks/coverage.py`)."""
RESOLVED = 0.02
"""Standard deviation of a torque at rest in white noise, fraction of the dry friction, below which
the prior odds of a wheel without ripple fall, as its square. Absence stands for every ripple that
the record does not show, of which fewer are left in a finer record; a few breakaways that agree by
chance do not show it. Chosen by measured coverage (`benchmarks/next_record.py`)."""
STRONG_RIPPLES = (0.3, 1.0, 3.0)
"""Further levels, for records that these do not explain."""
LONGEST = 65_536
"""Largest number of samples that are processed at once; longer records go in parts, which bounds
the memory."""
WIDTH = 8
"""The number of columns is rounded up to a multiple of this."""


@dataclass(frozen=True)
class Nuisance:
    """Deterministic effect with unknown coefficients.

    Attributes:
        name: Identifier in fit.json.
        title: Title in reports.
        unit: Unit of the coefficients.
        scales: Prior standard deviations considered, in `unit`.
        columns: For each record, the derivative of the modelled speed at its samples with respect
            to each of the k coefficients, (N, k).
        at: Coefficients of an effect that is certainly present, at which the records are
            linearised, (k,); None if its presence is to be decided.
        odds: Prior odds of an effect that comes from the samples and not from the wheel, so that
            its presence is no hint at that of others; None for an effect of the wheel.
        beside: Effect at whose scale this one is present too or not, with equal odds; None for an
            effect of its own.
        currents: For each record, the current in each interval that acts as each coefficient,
            (N - 1, k), A per `unit`; None if no current does.
    """

    name: str
    title: str
    unit: str
    scales: tuple[float, ...]
    columns: tuple[Matrix, ...]
    at: Vector | None = None
    odds: float | None = None
    beside: str | None = None
    currents: tuple[Matrix, ...] | None = None


@stored_function
def _chain(transition, inputs, start):
    """Accumulate local changes of the speed, (N - 1, k), over a record from a start, (k,)."""

    def interval(state, sample):
        state = sample[0] * state + sample[1]
        return state, state

    return jax.lax.scan(interval, start, (transition, inputs))[1]


def accumulated(linear: Linearisation, inputs: Matrix) -> Matrix:
    """Response of the speed to changes that arise within each sample interval, (N, k), rad/s.

    Args:
        linear: Linearisation of the record.
        inputs: Change that arises within each interval, at its end, (N - 1, k), rad/s.
    """
    count, width = inputs.shape
    size = min(len(padded(linear.transition)), LONGEST)
    response, last = np.zeros((count + 1, width)), np.zeros(width + spare(width))
    for start in range(0, count, size):
        columns = slice(start, start + size)
        fill = max(0, start + size - count)
        rows = _chain(
            np.pad(linear.transition[columns], (0, fill)),
            np.pad(inputs[columns], ((0, fill), (0, spare(width)))),
            last,
        )
        rows = np.asarray(rows)
        response[start + 1 : start + 1 + size], last = rows[: size - fill, :width], rows[-1]
    return over_intervals(response) if linear.averaged else response


def spare(width: int) -> int:
    """Number of zero columns to append, so that few different widths are compiled."""
    return -width % WIDTH


def _lag(records: Sequence[Record], linear: Sequence[Linearisation]) -> Nuisance:
    """Delay of the measured speed, the same in all records."""
    intervals = [np.diff(r.time) for r in records]
    slopes = [
        np.append(0.0, -np.diff(f.speed) / dt) for f, dt in zip(linear, intervals, strict=True)
    ]
    usual = float(np.median(np.concatenate(intervals)))
    scales = [share * usual for share in LAGS]
    while scales[-1] < SLOWEST_LAG:
        scales.append(scales[-1] * np.sqrt(10.0))
    columns = tuple(slope[:, None] for slope in slopes)
    return Nuisance("speed_lag", "lag or delay of the measured speed", "s", tuple(scales), columns)


def share_of_range(values: Vector) -> Vector:
    """Mean of samples (N,) over each interval, from -1 for the smallest sample to 1, (N - 1,)."""
    middle = 0.5 * (values[1:] + values[:-1])
    return 2.0 * (middle - values.min()) / np.ptp(values) - 1.0


def _drifts(
    prediction: SpeedPrediction,
    linear: Sequence[Linearisation],
    size: Mapping[str, float],
    name: str,
    title: str,
    scales: tuple[float, ...],
    odds: float | None,
) -> list[Nuisance]:
    """Change of some friction torques over each record, with zero mean: a line, and about it.

    Args:
        prediction: Records and friction model.
        linear: Linearisation of each record at the fit.
        size: Name -> size of the parameters that drift together, SI.
        name: First part of the identifiers.
        title: Friction in titles.
        scales: Prior sigmas of the drift; its variation has the larger ones.
        odds: Prior odds of a drift that is no hint at other effects.
    """
    if not any(size.values()):
        return []
    count = min(WAVES, MOST_WAVES // len(linear))
    orders = np.arange(1, count + 1)
    bias = prediction.names.index("current_bias")
    columns, currents = [], []
    for k, (record, each) in enumerate(zip(prediction.records, linear, strict=True)):
        parts = [size[n] * each.local[:, prediction.names.index(n)] for n in size]
        torque = np.sum(parts, axis=0)
        share = share_of_range(record.time)
        shapes = np.cos(0.5 * np.pi * orders * (share[:, None] + 1.0)) / orders
        inputs = np.zeros((len(torque), (1 + count) * len(linear)))
        own = [k, *range(len(linear) + k * count, len(linear) + (k + 1) * count)]
        inputs[:, own] = np.column_stack([share, shapes]) * torque[:, None]
        columns.append(accumulated(each, inputs))
        # a gap has no motion
        per_current = np.where(each.local[:, bias] == 0.0, np.inf, each.local[:, bias])
        currents.append(inputs / per_current[:, None])

    def effect(name: str, title: str, scales: tuple[float, ...], part: slice) -> Nuisance:
        return Nuisance(
            name,
            title,
            "1",
            scales,
            tuple(rows[:, part] for rows in columns),
            currents=tuple(rows[:, part] for rows in currents),
        )

    drift, lines = f"{name}_drift", len(linear)
    over = f"drift of the {title} over half the record"
    line = replace(effect(drift, over, scales, slice(lines)), odds=odds)
    if not count:
        return [line]
    about = f"variation of the {title} about its drift"
    variation = effect(f"{name}_variation", about, scales[1:], slice(lines, None))
    return [line, replace(variation, beside=drift)]


def nuisances(
    prediction: SpeedPrediction,
    linear: Sequence[Linearisation],
    values: Mapping[str, float],
    sigma: Mapping[str, float],
) -> list[Nuisance]:
    """Deterministic candidate effects.

    Args:
        prediction: Records and friction model.
        linear: Linearisation of each record at the fit.
        values: Name -> value of all parameters, SI.
        sigma: Name -> standard deviation of the estimated parameters, SI.
    """
    effects = [_lag(prediction.records, linear)]
    for dimension, name, title, scales, odds in DRIFTING:
        names = [n for n, d in prediction.model.dimensions().items() if d == dimension]
        # an estimate that is near zero by chance gives no scale
        size = {n: abs(values[n]) + sigma.get(n, 0.0) for n in names}
        effects += _drifts(prediction, linear, size, name, title, scales, odds)
    return effects


def dry_friction(model: type[Friction], values: Mapping[str, float]) -> float:
    """Mean size of the dry friction torques of a wheel, N·m; 0 without any."""
    names = [n for n, d in model.dimensions().items() if d == "torque"]
    return float(np.mean([abs(values[n]) for n in names])) if names else 0.0


def resolution(
    prediction: SpeedPrediction, values: Mapping[str, float], sigma: Mapping[str, float]
) -> float:
    """Smallest standard deviation of a torque at rest over the dry friction; infinite without one.

    Args:
        prediction: Records and friction model.
        values: Name -> value of all parameters, SI.
        sigma: Name -> standard deviation of the estimated parameters in white noise, SI.
    """
    finest = min((sigma[n] for n in prediction.model.vanishing_at if n in sigma), default=np.inf)
    friction = dry_friction(prediction.model, values)
    return finest / friction if friction > 0.0 else np.inf
