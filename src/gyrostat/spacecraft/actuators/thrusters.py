"""Thrusters, commanded by their on-time in each control period."""

from typing import Annotated, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.wheel.array import UNIT_TOLERANCE, listed

STANDARD_GRAVITY = 9.80665
"""Standard acceleration of gravity, m/s²; it defines the specific impulse."""
PerThruster = Float[Array, " thrusters"]
"""One real number for each thruster."""


class Thrusters(Checked):
    """Mean torque of thrusters over a control period, T = sum (r_i x d_i) F_i t_i / t.

    The command is the on-time t_i of each thruster in the control period t. It is limited to the
    period. A thruster does not open for a command below its minimum on-time, which is the minimum
    impulse bit over the thrust. The torque acts with its mean over the period, which is accurate if
    the body turns little in a period. The force does not change the orbit. M. J. Sidi, "Spacecraft
    Dynamics and Control", chapter 9.

    Attributes:
        positions: Position of each thruster from the centre of mass, body axes, (thrusters, 3), m.
        directions: Direction of the force on the spacecraft, against the jet, body axes, unit
            length, (thrusters, 3).
        force: Thrust of each thruster, (thrusters,), or one value for all, N.
        period: Control period, s.
        minimum: Minimum on-time of each thruster, (thrusters,), or one value for all, s.
        specific_impulse: Specific impulse, s; for `propellant`.
    """

    positions: Float[Array, "thrusters 3"] = eqx.field(converter=listed)
    directions: Float[Array, "thrusters 3"] = eqx.field(converter=listed)
    force: Annotated[PerThruster | float, positive("thrust", "N")] = eqx.field(converter=listed)
    period: Annotated[Scalar, positive("control period of the thrusters", "s")]
    minimum: Annotated[PerThruster | float, size("minimum on-time", "s")] = eqx.field(
        converter=listed, default=0.0
    )
    specific_impulse: Annotated[Scalar, positive("specific impulse", "s")] = 70.0

    @classmethod
    def couples(cls, arm: Scalar, force: Scalar, period: Scalar, **options: Scalar) -> Self:
        """Twelve thrusters in six pairs without net force: +x, -x, +y, -y, +z, -z.

        The pair of +z has thrusters at +x and -x with forces along +y and -y, and so on
        cyclically.

        Args:
            arm: Distance of each thruster from the centre of mass, m.
            force: Thrust of each, N.
            period: Control period, s.
            options: Other attributes.
        """
        axes, rows = np.eye(3), []
        for number in range(3):
            position, along = axes[(number + 1) % 3], axes[(number + 2) % 3]
            for sense in (1.0, -1.0):
                rows += [(position, sense * along), (-position, -sense * along)]
        positions, directions = (np.array(each) for each in zip(*rows, strict=True))
        return cls(arm * jnp.asarray(positions), directions, force, period, **options)

    def check_own(self) -> None:
        """Validate shapes and directions.

        Raises:
            InputError: Positions or directions are not (thrusters, 3), or a direction is not of
                unit length.
        """
        positions, directions = (
            np.asarray(x, dtype=float) for x in (self.positions, self.directions)
        )
        if positions.ndim < 2 or positions.shape[-1] != 3 or positions.shape != directions.shape:
            raise InputError(
                f"thrusters: found positions of shape {positions.shape} and directions of shape "
                f"{directions.shape}, expected (thrusters, 3)"
            )
        if not np.all(np.abs(np.linalg.norm(directions, axis=-1) - 1.0) < UNIT_TOLERANCE):
            raise InputError("directions of the thrusters: expected unit vectors")

    def on_time(self, value: PerThruster) -> PerThruster:
        """On-times that are carried out, (thrusters,), s.

        Args:
            value: Commanded on-times, (thrusters,), s.
        """
        return jnp.where(value < self.minimum, 0.0, jnp.clip(value, 0.0, self.period))

    def propellant(self, value: PerThruster) -> Scalar:
        """Propellant that a command uses in its control period, kg: sum F_i t_i / (g_0 I_sp).

        A controller can add it up and return the sum as a further field of its command.

        Args:
            value: Commanded on-times, (thrusters,), s.
        """
        return jnp.sum(self.force * self.on_time(value)) / (
            STANDARD_GRAVITY * self.specific_impulse
        )

    def __call__(self, value: PerThruster, attitude: Quaternion, time: Scalar) -> Vector3:
        """Torque in body axes, (3,), N·m.

        Args:
            value: Commanded on-times, (thrusters,), s.
            attitude: Unused.
            time: Unused.

        Raises:
            InputError: There is not one on-time for each thruster.
        """
        arms = jnp.cross(jnp.asarray(self.positions), jnp.asarray(self.directions))
        if jnp.shape(value) != arms.shape[:1]:
            raise InputError(
                f"thrusters: found a command of shape {jnp.shape(value)}, expected "
                f"({len(arms)},), one on-time for each thruster"
            )
        return (self.force * self.on_time(value) / self.period) @ arms
