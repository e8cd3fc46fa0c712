"""Candidate effects for the diagnosis: columns of derivatives of the speed.

Each is linearised at a fit, like the nuisances of `gyrostat.identification.uncertainty.effects`.
They are tested after the fit and are included in it only if the user asks for them.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.friction_torques import friction_torques
from gyrostat.identification.fit.prediction import Linearisation, SpeedPrediction
from gyrostat.identification.uncertainty.effects import (
    Nuisance,
    accumulated,
    dry_friction,
    share_of_range,
)
from gyrostat.telemetry import Record
from gyrostat.telemetry.signals import trapezoidal
from gyrostat.wheel.friction.stribeck import DEFAULT_STRIBECK_SPEED

SHARES = (0.01, 0.03, 0.1, 0.3)
"""Prior sigmas of a torque included in the fit, fractions of the friction torque."""
HARMONICS = (1, 2, 3, 4)
"""Multiples of the wheel's angle at which a torque ripple is sought."""
WARMING = 1.0
"""Smallest temperature range in a record for temperature to be a candidate cause of drift, °C."""
CLIPPED_RUNS = (2, 16)
"""Smallest and largest number of intervals at the same largest current that may be clipped."""
SUBSTEPS = 5
"""Points of a sample interval at which a narrow friction curve is averaged."""

Shape = Callable[[Record, Linearisation], Matrix | None]
"""Record and its linearisation -> change of the speed at the end of each interval per unit of each
coefficient, (N - 1, k); None if the effect does not occur in the record."""


def _share_of_temperature(record: Record) -> Vector | None:
    """Temperature in each interval, from -1 (coldest) to 1 (warmest); None if it is constant."""
    if record.temperature is None or np.ptp(record.temperature) < WARMING:
        return None
    return share_of_range(record.temperature)


def _angle(record: Record, linear: Linearisation) -> Vector:
    """Angle of the wheel at the samples, (N,), rad: the integral of its speed."""
    speed = np.where(record.valid, record.speed, linear.speed)
    return trapezoidal(speed, record.time)


def _runs_at_limit(current: Vector) -> Matrix | None:
    """Current in each run of samples at the largest current, (N - 1, runs).

    None if there is no limit: all samples, only one run, or too many runs have this current.
    """
    at = np.abs(current) == np.max(np.abs(current))
    number = np.cumsum(np.diff(np.concatenate([[0], at.astype(int)])) == 1)
    if at.all() or not CLIPPED_RUNS[0] <= number[-1] <= CLIPPED_RUNS[1]:
        return None
    runs = number[:, None] == np.arange(1, number[-1] + 1)
    return (np.where(at, current, 0.0)[:, None] * runs)[:-1]


def _inside(linear: Linearisation) -> Matrix:
    """Speed at points inside each interval, (N - 1, SUBSTEPS), rad/s."""
    share = (np.arange(SUBSTEPS) + 0.5) / SUBSTEPS
    return linear.speed[:-1, None] + share * np.diff(linear.speed)[:, None]


class _Candidates:
    """Builder of the candidates for one fit."""

    def __init__(
        self,
        prediction: SpeedPrediction,
        linear: Sequence[Linearisation],
        values: Mapping[str, float],
    ) -> None:
        self.prediction, self.linear, self.values = prediction, linear, values
        dimensions = prediction.model.dimensions()
        self.dry = [n for n, d in dimensions.items() if d == "torque"]
        self.viscous = [n for n, d in dimensions.items() if d == "viscous"]
        self.entries: list[tuple[str, str, str, list[Matrix]]] = []

    def local(self, linear: Linearisation, name: str) -> Vector:
        """Derivative of the speed at the end of each interval by a parameter in it alone."""
        return linear.local[:, self.prediction.names.index(name)]

    def torque(self, linear: Linearisation, names: Sequence[str]) -> Vector:
        """Change of the speed in each interval by the torque of some friction parameters."""
        return np.sum([self.values[n] * self.local(linear, n) for n in names], axis=0)

    def dry_torque(self, speed: Matrix) -> Matrix:
        """Dry friction torque at speeds of 0 or more, N·m, of any shape."""
        torques = friction_torques(self.prediction.model, self.values, speed.ravel())
        return torques.dry.reshape(speed.shape)

    def per_torque(self, linear: Linearisation) -> Vector:
        """Change of the speed at the end of each interval per torque in it, rad/s per N·m."""
        motor = self.values["motor_constant"]
        return self.local(linear, "current_bias") / (motor if motor else 1.0)

    def add(self, name: str, title: str, unit: str, shape: Shape, *, each: bool = False) -> None:
        """Add a candidate.

        Args:
            name: Identifier.
            title: Title in reports.
            unit: Unit of the coefficients.
            shape: Function that gives the effect on the speed in a record.
            each: Whether every record has its own coefficient.
        """
        inputs = list(map(shape, self.prediction.records, self.linear))
        present = [k for k, columns in enumerate(inputs) if columns is not None]
        if not present:
            return
        width = next(columns.shape[1] for columns in inputs if columns is not None)
        blocks = []
        for k, (columns, linear) in enumerate(zip(inputs, self.linear, strict=True)):
            block = np.zeros((len(linear.transition), width * (len(present) if each else 1)))
            if columns is not None:
                first = width * present.index(k) if each else 0
                block[:, first : first + width] = columns
            blocks.append(block)
        if any(np.any(block) for block in blocks):
            self.entries.append((name, title, unit, blocks))

    def nuisances(self) -> list[Nuisance]:
        """Candidates added, with their changes of the speed accumulated over each record."""
        ends = np.cumsum([blocks[0].shape[1] for *_, blocks in self.entries])[:-1]
        split = []
        for linear in self.linear:
            # taken out of the lists: those of a long record need the memory
            every = np.column_stack([blocks.pop(0) for *_, blocks in self.entries])
            split.append(np.split(accumulated(linear, every), ends, axis=1))
        return [
            Nuisance(name, title, unit, SHARES, tuple(columns[index] for columns in split))
            for index, (name, title, unit, _) in enumerate(self.entries)
        ]


def candidates(
    prediction: SpeedPrediction, linear: Sequence[Linearisation], values: Mapping[str, float]
) -> list[Nuisance]:
    """Effects that the diagnosis tests in addition to those included in every fit.

    Args:
        prediction: Records and friction model.
        linear: Linearisation of each record at the fit.
        values: Name -> value of all parameters, SI.
    """
    make = _Candidates(prediction, linear, values)

    def over_temperature(names: Sequence[str]) -> Shape:
        def shape(record: Record, linear: Linearisation) -> Matrix | None:
            shares = _share_of_temperature(record)
            return None if shares is None else (shares * make.torque(linear, names))[:, None]

        return shape

    def one_sided_dry(_, linear: Linearisation) -> Matrix:
        # constant in sign: where the wheel turns back within an interval, as elsewhere
        dry = make.dry_torque(np.abs(_inside(linear)))
        return (-np.mean(dry, axis=1) * make.per_torque(linear))[:, None]

    def one_sided_viscous(_, linear: Linearisation) -> Matrix:
        sense = np.sign(linear.speed[1:] + linear.speed[:-1])
        return (sense * make.torque(linear, make.viscous))[:, None]

    if not any(np.any(each.jacobian[:, prediction.names.index("current_bias")]) for each in linear):
        return []
    make.add(
        "current_offset",
        "current offset",
        "A",
        lambda _, each: make.local(each, "current_bias")[:, None],
    )
    if len(make.viscous) == 1:
        make.add("asymmetry", "direction asymmetry of the dry friction", "1", one_sided_dry)
        title = "direction asymmetry of the viscous friction"
        make.add("viscous_asymmetry", title, "1", one_sided_viscous)
    for names, name, kind in (
        (make.viscous, "viscous_over_temperature", "viscous"),
        (make.dry, "coulomb_over_temperature", "dry"),
    ):
        title = f"change of the {kind} friction over half the range of temperature"
        make.add(name, title, "1", over_temperature(names))
    level = dry_friction(prediction.model, values) or abs(values["motor_constant"])

    def ripple(order: int) -> Shape:
        def shape(record: Record, linear: Linearisation) -> Matrix:
            phase = order * _angle(record, linear)
            phase_step = np.diff(phase)
            # mean over the interval at constant speed
            attenuation = np.sinc(phase_step / (2.0 * np.pi))
            middle = phase[:-1] + 0.5 * phase_step
            waves = np.column_stack([np.cos(middle), np.sin(middle)])
            return level * (attenuation * make.per_torque(linear))[:, None] * waves

        return shape

    for order in HARMONICS:
        title = f"torque ripple, {order} per turn, fraction of the dry friction"
        make.add(f"ripple_{order}", title, "1", ripple(order))

    def limited(record: Record, linear: Linearisation) -> Matrix | None:
        at = _runs_at_limit(record.current)
        return None if at is None else at * make.local(linear, "current_bias")[:, None]

    title = "clipped current: true minus recorded, fraction of the limit"
    make.add("clipped_current", title, "1", limited, each=True)
    if not prediction.model.vanishing_at:

        def rise(_, linear: Linearisation) -> Matrix:
            speed = _inside(linear)
            bend = np.sign(speed) * np.exp(-((speed / DEFAULT_STRIBECK_SPEED) ** 2))
            return (-level * np.mean(bend, axis=1) * make.per_torque(linear))[:, None]

        title = "friction that rises towards rest (Stribeck), fraction of the dry friction"
        make.add("stribeck", title, "1", rise)
    return make.nuisances()
