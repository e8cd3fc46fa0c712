"""Start values from the integrated equation of motion, which is linear.

w(t) - w(0) = (k_m/J) int I - (b/J) int w - (c/J) int sgn(w). This needs no derivative of the noisy
speed, no other start values, and no simulated wheel that could stick.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gyrostat.core.si_dimensions import speed_power
from gyrostat.core.types import Vector
from gyrostat.core.units import si_unit
from gyrostat.identification.fit.prediction import SpeedPrediction
from gyrostat.identification.read.statistics import noise_level
from gyrostat.telemetry import Record
from gyrostat.telemetry.signals import held_integral, trapezoidal

SMOOTHING = 9
"""Samples in the running mean that determines the sense of rotation."""
CLEAR = 2.0
"""Running mean, in standard deviations of one speed, above which the sense of rotation is known."""
MIN_SAMPLES = 10
"""Smallest number of speed samples in an interval of motion."""


@dataclass(frozen=True)
class StartValues:
    """Parameter ratios that records determine without knowledge of the inertia.

    Attributes:
        motor: k_m/J, rad/s²/A.
        viscous: b/J, 1/s.
        coulomb: c/J, rad/s².
        initial_speeds: Initial speed of each segment, (segments,), rad/s: the first segment of
            each record, then all others.
        speed_level: Root mean square of all speeds, rad/s.
        current_level: Root mean square of all currents, A.
        span: Duration of the longest record, s.
    """

    motor: float
    viscous: float
    coulomb: float
    initial_speeds: Vector
    speed_level: float
    current_level: float
    span: float

    def inertia(self, known: Mapping[str, float]) -> float | None:
        """Inertia, kg·m², if known, or from a known motor constant; otherwise None."""
        if "inertia" in known:
            return known["inertia"]
        if "motor_constant" in known and self.motor != 0.0:
            return abs(known["motor_constant"] / self.motor)
        return None

    def parameters(
        self, prediction: SpeedPrediction, known: Mapping[str, float]
    ) -> dict[str, float]:
        """Start values of all parameters of a prediction, SI.

        Args:
            prediction: Records and friction model.
            known: Given values; the inertia or the motor constant sets the torque scale.

        Returns:
            Name -> value; without the wheel's parameters if the torque scale is unknown.
        """
        speeds = dict(zip(prediction.initial_speeds, self.initial_speeds.tolist(), strict=True))
        slopes = [n for n, d in prediction.dimensions.items() if d.endswith("_per_temperature")]
        first: dict[str, float] = {"current_bias": 0.0, **speeds, **dict.fromkeys(slopes, 0.0)}
        inertia = self.inertia(known)
        if inertia is not None:
            model = prediction.model
            first |= model.start_values(self.viscous * inertia, self.coulomb * inertia)
            first |= {"inertia": inertia, "motor_constant": self.motor * inertia}
        return first

    def size(self, name: str, dimension: str, inertia: float, motor_constant: float) -> float:
        """Value, SI, at which a parameter would have as much effect as the motor torque.

        Args:
            name: Name of the parameter.
            dimension: Dimension of the parameter.
            inertia: Rotor inertia, kg·m².
            motor_constant: Motor constant, N·m/A.
        """
        torque = inertia * max(abs(self.motor) * self.current_level, self.speed_level / self.span)
        # without a current: the current that would balance friction
        current = self.current_level or torque / (abs(motor_constant) or 1.0)
        power = speed_power(si_unit(dimension.removesuffix("_per_temperature")))
        if power is not None:
            return torque / self.speed_level**power if self.speed_level > 0.0 or not power else 0.0
        sizes = {
            "motor_constant": torque / current,
            "inertia": inertia,
            "current": current,
            "speed": self.speed_level if name.startswith("initial_speed") else 0.0,
        }
        return sizes.get(dimension.removesuffix("_per_temperature"), 0.0)


def _stretches(record: Record, speed: Vector, noise: float) -> list[tuple[int, int]]:
    """Intervals (first index, index after the last) in which the wheel turns in one sense.

    The whole record if there is none.
    """
    # single noisy samples would split an interval: use a running mean
    width = min(SMOOTHING, len(speed))
    smooth = np.convolve(speed, np.full(width, 1.0 / width), mode="same")
    sense = np.where(np.abs(smooth) > CLEAR * noise, np.sign(smooth), 0.0)
    turns = (np.flatnonzero(np.diff(sense)) + 1).tolist()
    edges = sorted({*turns, *(part.start for part in record.segments), len(speed)})
    intervals = [
        (first, last)
        for first, last in pairwise(edges)
        if sense[first] != 0.0 and np.sum(record.valid[first:last]) >= MIN_SAMPLES
    ]
    return intervals or [(0, len(speed))]


def integral_regression(records: Sequence[Record]) -> StartValues:
    """Linear least squares on the integrated equation of motion, over each interval of motion.

    Intervals at rest are excluded: there friction equals the motor torque, whatever its parameters.

    Args:
        records: At least one record; missing speeds are interpolated linearly.

    Returns:
        Start values. c/J is limited to less than the largest motor torque so that the modelled
        wheel turns.
    """
    blocks, rights, speeds, firsts = [], [], [], []
    for record in records:
        time = record.time - record.time[0]
        speed = np.interp(time, time[record.valid], record.speed[record.valid])
        noise = noise_level(record.speed[record.valid])
        charge = held_integral(record.current, time)
        integrals = np.column_stack([charge, -trapezoidal(speed, time)])
        stretches = _stretches(record, speed, noise)
        firsts.append((len(blocks), stretches[0][0]))
        for first, last in stretches:
            index = first + np.flatnonzero(record.valid[first:last])
            sense = np.sign(np.mean(speed[first:last]))
            change = integrals[index] - integrals[first]
            blocks.append(np.column_stack([change, -sense * (time[index] - time[first])]))
            rights.append(speed[index])
        speeds.append(speed)
    # each interval starts at its own speed, which subtracting the means eliminates
    rows = np.vstack([block - block.mean(axis=0) for block in blocks])
    right = np.concatenate([part - part.mean() for part in rights])
    size = np.linalg.norm(rows, axis=0)
    size = np.where(size > 0.0, size, 1.0)
    ratio = np.linalg.lstsq(rows / size, right, rcond=1e-10)[0] / size
    motor, viscous, coulomb = (float(v) for v in ratio)
    initial = [
        np.mean(rights[k]) - blocks[k].mean(axis=0) @ ratio
        if first == 0
        else np.mean(speed[: min(first, SMOOTHING)])
        for (k, first), speed in zip(firsts, speeds, strict=True)
    ]

    currents = [record.current for record in records]
    current_level = float(np.sqrt(np.mean(np.concatenate(currents) ** 2)))
    speed_level = float(np.sqrt(np.mean(np.concatenate(speeds) ** 2)))
    drive = abs(motor) * max(float(np.max(np.abs(c))) for c in currents)
    coulomb = float(np.clip(coulomb, 0.01 * drive, 0.8 * drive)) if drive > 0.0 else abs(coulomb)
    for record, speed in zip(records, speeds, strict=True):
        initial += [np.mean(speed[part][:SMOOTHING]) for part in record.segments[1:]]
    span = max(float(np.ptp(r.time)) for r in records)
    return StartValues(
        motor=motor,
        viscous=max(viscous, 0.0),
        coulomb=coulomb,
        initial_speeds=np.array(initial),
        speed_level=speed_level,
        current_level=current_level,
        span=span,
    )
