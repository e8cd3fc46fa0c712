"""Effects of real wheels and drives outside the friction model.

A friction model in white noise is never complete: tachometers lag, lubricants warm up, bearings
and motors have torque ripple. Each such effect is a candidate here, linearised at a fit. A
deterministic effect is a column of derivatives with an unknown coefficient (`Nuisance`); a random
torque is a process noise of the wheel's speed (`TorqueNoise`). The scales of every candidate are
derived from the wheel and the record and span decades; none is tuned to a particular wheel.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

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
"""Prior sigmas of a viscous drift from mid-record to the end, fraction of the coefficient."""
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
COHERENCE = 1.0
"""Angle over which the ripple at a zero crossing is constant, rad."""
RETURN = 32.0 * np.pi
"""Angle turned after which a wheel stops at another phase of the ripple, rad. A wheel that only
moves to and fro breaks away at the same angles again, and after a few turns it stops nearly where
it did before."""
LONGEST = 65_536
"""Largest number of samples that are processed at once; longer records go in parts, which bounds
the memory."""
WIDTH = 8
"""The number of columns is rounded up to a multiple of this."""
FIRST_WALK = 0.5
"""Initial sigma of a random-walk torque, in units of its growth over the record."""


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
    """

    name: str
    title: str
    unit: str
    scales: tuple[float, ...]
    columns: tuple[Matrix, ...]


@dataclass(frozen=True)
class TorqueNoise:
    """Random torque on the wheel of one record, per unit of its level squared.

    Attributes:
        gain: Change of the speed at the end of each interval per torque in it, (N - 1,), rad/s
            per N·m.
        crossings: Variance that the ripple at zero crossings adds to the speed in each interval,
            (N - 1,), (rad/s)².
        walk: Variance by which a random-walk torque grows in each interval, (N - 1,), (N·m)².
        first: Variance of the random-walk torque at the first sample, (N·m)².
        starts: Change of the speed at the end of each interval per ripple torque, against the
            motion, at the last start from rest or zero crossing, (N - 1,), rad/s per N·m; zero
            where the wheel has turned on.
        kept: Correlation of this torque at the end of each interval with that at its start,
            (N - 1,).
        ripple: Variance of this torque, (N·m)².
    """

    gain: Vector
    crossings: Vector
    walk: Vector
    first: float
    starts: Vector
    kept: Vector
    ripple: float

    def intervals(self, transition: Vector) -> Matrix:
        """Rows of `gyrostat.identification.uncertainty.speed_error`, (N - 1, 7).

        Args:
            transition: Derivative of the speed at the end of each interval by that at its start,
                (N - 1,).
        """
        renewal = self.ripple * (1.0 - self.kept**2)
        gains = (transition, self.gain, self.starts, self.kept)
        return np.column_stack([*gains, self.crossings, self.walk, renewal])


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


def _viscous_drift(
    prediction: SpeedPrediction,
    linear: Sequence[Linearisation],
    values: Mapping[str, float],
    sigma: Mapping[str, float],
) -> Nuisance | None:
    """Linear change of the viscous friction over each record, with zero mean."""
    names = [n for n, d in prediction.model.dimensions().items() if d == "viscous"]
    # an estimate that is near zero by chance gives no scale
    size = {n: abs(values[n]) + sigma.get(n, 0.0) for n in names}
    if not any(size.values()):
        return None
    columns = []
    for k, (record, each) in enumerate(zip(prediction.records, linear, strict=True)):
        torque = sum(size[n] * each.local[:, prediction.names.index(n)] for n in names)
        drift = np.zeros((len(record.time), len(linear)))
        drift[:, k] = accumulated(each, (share_of_range(record.time) * torque)[:, None])[:, 0]
        columns.append(drift)
    title = "drift of the viscous friction over half the record"
    return Nuisance("viscous_drift", title, "1", DRIFTS, tuple(columns))


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
    drift = _viscous_drift(prediction, linear, values, sigma)
    return [_lag(prediction.records, linear), *([] if drift is None else [drift])]


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


def torque_noise(
    prediction: SpeedPrediction, record: Record, linear: Linearisation, values: Mapping[str, float]
) -> TorqueNoise:
    """Random torque on the wheel of a record, with its friction torque as unit level.

    Near zero speed the ripple over the wheel's angle acts long enough to change the speed; at high
    speed it averages out. Within a band of speeds that the wheel leaves after about `COHERENCE`,
    the ripple is a white torque noise with the time in this band as its correlation time.

    A wheel that starts from rest or passes zero shows the ripple at its angle: a constant torque,
    added to the friction until it has turned by `COHERENCE`. Later starts show the same torque, the
    less the more the wheel turns in between (`RETURN`): many breakaways at the same angles do not
    average it.

    Args:
        prediction: Records and friction model.
        record: One of its records.
        linear: Linearisation of this record at the fit.
        values: Name -> value of all parameters, SI.
    """
    friction = dry_friction(prediction.model, values)
    motor = abs(values["motor_constant"]) * float(np.sqrt(np.mean(record.current**2)))
    level = friction or motor
    duration = np.diff(record.time)
    per_current = linear.local[:, prediction.names.index("current_bias")]
    gain = per_current / values["motor_constant"] if values["motor_constant"] else per_current
    acceleration = (friction + motor) / values["inertia"]
    band = np.sqrt(COHERENCE * acceleration)
    low, high = (f(linear.speed[:-1], linear.speed[1:]) for f in (np.minimum, np.maximum))
    inside = np.clip(np.minimum(high, band) - np.maximum(low, -band), 0.0, None)
    change = high - low
    share = np.where(
        change > 0.0, inside / np.where(change > 0.0, change, 1.0), np.abs(high) < band
    )
    correlation = band / acceleration if acceleration > 0.0 else 0.0
    rotation = 0.5 * np.abs(linear.speed[1:] + linear.speed[:-1]) * duration
    starting = _since_zero(linear.speed, rotation) < COHERENCE
    # a wheel at rest does not respond
    mobility = ((gain != 0.0) & ~starting) / values["inertia"] ** 2
    return TorqueNoise(
        gain=gain,
        crossings=level**2 * correlation * duration * share * mobility,
        walk=level**2 * duration / np.ptp(record.time),
        first=(FIRST_WALK * level) ** 2,
        starts=-gain * starting * np.sign(linear.speed[1:]),
        kept=np.exp(-rotation / RETURN),
        ripple=level**2,
    )


def _since_zero(speed: Vector, rotation: Vector) -> Vector:
    """Angle turned since the speed was last zero, at the start of each interval, (N - 1,), rad.

    Args:
        speed: Speed at the samples, (N,), rad/s.
        rotation: Angle turned in each interval, (N - 1,), rad.
    """
    angle = np.cumsum(rotation) - rotation
    return angle - np.maximum.accumulate(np.where(speed[:-1] * speed[1:] <= 0.0, angle, -np.inf))
