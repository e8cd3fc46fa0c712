"""Random torques on a wheel: ripple near zero speed, a random walk, and rounding of the current."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.prediction import Linearisation, SpeedPrediction
from gyrostat.identification.uncertainty.effects import dry_friction
from gyrostat.telemetry import Record

COHERENCE = 1.0
"""Angle over which the ripple at a zero crossing is constant, rad."""
RETURN = 32.0 * np.pi
"""Angle turned after which a wheel stops at another phase of the ripple, rad. A wheel that only
moves to and fro breaks away at the same angles again, and after a few turns it stops nearly where
it did before."""
FIRST_WALK = 0.5
"""Initial sigma of a random-walk torque, in units of its growth over the record."""


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
        fixed: Variance that the rounding of the current adds to the speed in each interval at any
            level, (N - 1,), (rad/s)².
    """

    gain: Vector
    crossings: Vector
    walk: Vector
    first: float
    starts: Vector
    kept: Vector
    ripple: float
    fixed: Vector

    def intervals(self, transition: Vector) -> Matrix:
        """Rows of `gyrostat.identification.uncertainty.speed_error`, (N - 1, 8).

        Args:
            transition: Derivative of the speed at the end of each interval by that at its start,
                (N - 1,).
        """
        renewal = self.ripple * (1.0 - self.kept**2)
        gains = (transition, self.gain, self.starts, self.kept)
        return np.column_stack([*gains, self.crossings, self.walk, renewal, self.fixed])


def torque_noise(
    prediction: SpeedPrediction,
    record: Record,
    linear: Linearisation,
    values: Mapping[str, float],
    rounding: Vector | float = 0.0,
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
        rounding: Variance of the current in each interval, independent of the others, (N - 1,), A².
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
        fixed=rounding * per_current**2,
    )


def _since_zero(speed: Vector, rotation: Vector) -> Vector:
    """Angle turned since the speed was last zero, at the start of each interval, (N - 1,), rad.

    Args:
        speed: Speed at the samples, (N,), rad/s.
        rotation: Angle turned in each interval, (N - 1,), rad.
    """
    angle = np.cumsum(rotation) - rotation
    return angle - np.maximum.accumulate(np.where(speed[:-1] * speed[1:] <= 0.0, angle, -np.inf))
