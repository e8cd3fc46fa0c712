"""Current programme of a test, with the speed that the expected wheel then has."""

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.core.units import RPM
from gyrostat.identification.bench_tests.bench_sheet import BenchSheet

MOST_SAMPLES = 500_000
"""Largest number of samples in one record."""
LONGEST = 86_400.0
"""Longest record, s."""
TO_REST = 1.3
"""Time for a coast to rest over that of the expected wheel."""


class Program:
    """Currents in the order in which they are run.

    The speed is that of the expected wheel with viscous and Coulomb friction, by the closed
    solution of J dw/dt = k_m I - b w - sgn(w) c.
    """

    def __init__(self, sheet: BenchSheet, test: str, rate: float) -> None:
        """Start from rest.

        Args:
            sheet: Spec sheet.
            test: Name of the test, for messages.
            rate: Samples per second, Hz.
        """
        self.sheet, self.test, self.rate = sheet, test, rate
        self.motor, self.inertia = sheet.value("motor_constant"), sheet.value("inertia")
        self.viscous, self.coulomb = sheet.value("viscous"), sheet.value("coulomb")
        self.speed, self.parts = 0.0, [np.zeros(max(round(rate), 1))]

    def friction(self, speed: float) -> float:
        """Friction torque of the expected wheel at a speed of 0 or more, N·m."""
        return self.coulomb + self.viscous * abs(speed)

    def hold(self, current: float, duration: float) -> None:
        """Hold a current, A, for a time, s, without a change of the speed that counts."""
        self.parts.append(np.full(max(round(duration * self.rate), 1), current))

    def steady(self, duration: float) -> None:
        """Hold the current at which the expected wheel keeps its speed, for a time, s."""
        self.hold(np.sign(self.speed) * self.friction(self.speed) / self.motor, duration)

    def ramp(self, first: float, last: float, duration: float) -> None:
        """Change a current, A, linearly over a time, s."""
        self.parts.append(np.linspace(first, last, max(round(duration * self.rate), 2)))

    def drive(self, current: float, speed: float) -> None:
        """Hold a current, A, until the expected wheel has a speed of the same sense, rad/s."""
        if self.speed * speed < 0.0:
            self.drive(current, 0.0)
        duration = self.time_to(current, speed)
        if not 0.0 <= duration <= LONGEST:
            raise InputError(
                f"{self.sheet.path}: test.{self.test}: found {abs(current):.3g} A, which does not "
                f"bring the wheel to {abs(speed) / RPM:.0f} rpm, expected a larger current_limit "
                "or a lower speed"
            )
        self.hold(current, duration)
        self.speed = speed

    def coast(self, speed: float = 0.0) -> None:
        """Leave the wheel without current until a speed, rad/s, of the same sense."""
        duration = self.time_to(0.0, speed)
        if speed == 0.0:
            duration = TO_REST * duration + 2.0
        self.hold(0.0, duration)
        self.speed = speed

    def time_to(self, current: float, speed: float) -> float:
        """Time to a speed at a current, s; not finite if the wheel does not reach it."""
        sense = np.sign(self.speed) or np.sign(speed) or 1.0
        torque = self.motor * current - sense * self.coulomb
        if self.viscous == 0.0:
            return self.inertia * (speed - self.speed) / torque if torque else np.inf
        before, after = (torque - self.viscous * each for each in (self.speed, speed))
        ratio = before / after if after else np.inf
        return self.inertia / self.viscous * np.log(ratio) if ratio > 0.0 else np.inf

    def series(self) -> tuple[Vector, Vector]:
        """Sample times, (N,), s, and currents, (N,), A; a last sample without current.

        Raises:
            InputError: The record would be too long.
        """
        current = np.concatenate([*self.parts, [0.0]])
        if len(current) > MOST_SAMPLES:
            raise InputError(
                f"{self.sheet.path}: test.{self.test}: found {len(current)} samples, expected at "
                f"most {MOST_SAMPLES}: shorten the test or lower the rate"
            )
        limit = self.sheet.bench.current_limit
        if np.max(np.abs(current)) > limit * (1.0 + 1e-9):
            raise InputError(
                f"{self.sheet.path}: test.{self.test}: found a current of "
                f"{np.max(np.abs(current)):.3g} A, expected at most the current_limit of {limit:g}"
            )
        return np.arange(len(current)) / self.rate, current
