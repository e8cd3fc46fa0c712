"""Equation of motion as a linear regression on the parameters that are estimated."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.drive.weak_form import Rows
from gyrostat.identification.fit.friction_torques import friction_torques
from gyrostat.wheel.friction import Friction


@dataclass(frozen=True)
class Equation:
    """Linear regression k_m (I + bias) = J dw/dt + F(w).

    With a known motor constant it is a regression of the torque. Otherwise it is one of the current
    on 1/k_m, the ratios of the parameters to k_m, and the bias.

    Attributes:
        law: Friction law.
        held: Name -> value that is not estimated, SI.
        names: Names of the n estimates.
    """

    law: type[Friction]
    held: Mapping[str, float]
    names: tuple[str, ...]

    @property
    def scaled(self) -> bool:
        """Whether the motor constant is known."""
        return "motor_constant" in self.held

    def start(self) -> dict[str, float]:
        """Parameters of the law with the held ones, SI, at which it is differentiated."""
        values = self.law.start_values(0.0, 0.0)
        return {**values, **{n: v for n, v in self.held.items() if n in values}}

    def named(self, values: Vector) -> dict[str, float]:
        """Held values and estimates by name, SI."""
        return {**self.held, **dict(zip(self.names, values.tolist(), strict=True))}

    def check(self) -> None:
        """Check that the friction is linear in the estimates.

        Raises:
            InputError: It is not.
        """
        speed = np.array([-200.0, -3.0, -0.2, 0.2, 3.0, 200.0])
        free = [n for n in self.law.dimensions() if n in self.names]
        rng = np.random.default_rng(0)
        values = {**self.start(), **dict(zip(free, rng.uniform(0.5, 1.5, len(free)), strict=True))}
        start, other = (
            friction_torques(self.law, each, speed).by_parameters for each in (self.start(), values)
        )
        # the column of a held scale is not used
        used = [n in free or n not in self.law.scales() for n in self.law.dimensions()]
        if not np.allclose(start[:, used], other[:, used], rtol=1e-6, atol=1e-9):
            names = ", ".join(n for n in self.law.scales() if n in self.names)
            raise InputError(
                f"--method inverse: found {self.law.name} with {names or ', '.join(free)} to "
                "estimate, expected a friction that is linear in the estimates: hold the others"
            )

    def system(self, rows: Rows) -> tuple[Matrix, Vector]:
        """Regressors (m, n) and left-hand side (m,)."""
        friction = dict(zip(self.law.dimensions(), rows.friction.T, strict=True))
        columns = {**friction, "inertia": rows.acceleration}
        linear = {*columns} - {*self.law.scales()}
        known = np.zeros_like(rows.current)
        for name in linear & {*self.held}:
            known = known + self.held[name] * columns[name]
        one = np.ones_like(rows.current)
        current = rows.current + self.held.get("current_bias", 0.0)
        if self.scaled:
            motor = self.held["motor_constant"]
            every = {**columns, "current_bias": -motor * one}
            return np.column_stack([every[n] for n in self.names]), motor * current - known
        every = {**columns, "motor_constant": known, "current_bias": -one}
        return np.column_stack([every[n] for n in self.names]), current

    def torque_error(self, rows: Rows, values: Mapping[str, float]) -> tuple[Vector, Vector]:
        """Motor torque that the parameters do not explain, and motor torque, each (m,), N·m.

        Args:
            rows: Terms of the equation of motion.
            values: Name -> held values and estimates, SI.
        """
        motor = values["motor_constant"]
        torque = motor * (rows.current + values.get("current_bias", 0.0))
        error = torque - values["inertia"] * rows.acceleration
        for name, column in zip(self.law.dimensions(), rows.friction.T, strict=True):
            if name not in self.law.scales():
                error = error - values[name] * column
        return error, motor * rows.current

    def estimates(self, solution: Vector, covariance: Matrix) -> tuple[Vector, Matrix]:
        """Parameters and their covariance, SI, from the solution of the regression."""
        if self.scaled:
            return solution, covariance
        at = self.names.index("motor_constant")
        ratio = 1.0 / solution[at]
        values, slopes = solution.copy(), np.eye(len(solution))
        for k, name in enumerate(self.names):
            if k == at:
                values[k], slopes[k, k] = ratio, -(ratio**2)
            elif name != "current_bias":
                values[k], slopes[k, k] = solution[k] * ratio, ratio
                slopes[k, at] = -solution[k] * ratio**2
        return values, slopes @ covariance @ slopes.T
