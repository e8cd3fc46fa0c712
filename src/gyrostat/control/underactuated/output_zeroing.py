"""Two-wheel pointing by input-output linearisation of two quaternion components."""

from typing import Annotated, Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.control.adaptive.model_error_compensator import Compensation
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.core.rotations import to_body
from gyrostat.spacecraft import Spacecraft

Pair = Float[Array, "2"]

LEAST_COSINE = 1e-3
"""Smallest cosine of half the pointing error. Beyond 179.885 degrees the law uses its value
there."""
PARALLEL = 1e-6
"""Smallest sine of the angle between two wheels, and smallest relative determinant of their
effect."""


def check_two_wheels(name: str, spacecraft: Spacecraft) -> None:
    """Check that two wheels can turn body z in every direction.

    Args:
        name: Name of the controller in messages.
        spacecraft: Spacecraft with the wheels.

    Raises:
        InputError: There are not two wheels, they are parallel, or they turn the body z axis about
            one axis only.
    """
    axes = np.asarray(spacecraft.wheels.axes, dtype=float)
    if axes.shape[-1] != 2:
        raise InputError(f"{name}: found {axes.shape[-1]} wheels, expected 2")
    crossed = np.cross(axes[..., 0], axes[..., 1], axis=-1)
    sine = float(np.min(np.linalg.norm(crossed, axis=-1)))
    if not sine > PARALLEL:
        raise InputError(f"{name}: found parallel wheels (sine of angle {sine:.2g})")
    inertia = np.asarray(spacecraft.inertia, dtype=float)
    rows = np.linalg.solve(inertia, axes)[..., :2, :]
    size = np.sum(rows**2, axis=(-2, -1))
    if not np.min(np.abs(np.linalg.det(rows)) / size) > PARALLEL:
        raise InputError(
            f"{name}: found wheels that turn body z about one axis only, expected axes whose parts "
            "across z are independent"
        )


class ZeroingCommand(NamedTuple):
    """Wheel speed command, and the signals behind it.

    Attributes:
        speed: Commanded wheel speeds relative to the body, (2,), rad/s.
        virtual_input: Commanded rate of (q1, q2), (2,), 1/s.
        singular: Whether (q1, q2) could not be controlled, at half a turn from the target.
        model_error: Model error of a compensator, (2,); zero without one.
        gain: Gain of a compensator, or zero without one, (2, 2), 1/s.
    """

    speed: Annotated[Pair, "rad/s"]
    virtual_input: Annotated[Pair, "1/s"]
    singular: Bool[Array, ""]
    model_error: Annotated[Pair, "1"]
    gain: Annotated[Float[Array, "2 2"], "1/s"]


class OutputZeroing(Checked):
    """Output zeroing: turns body z to inertial z by wheel speeds.

    Endo, Sekiguchi and Nonaka, (9)-(12): u = -alpha(q) + beta(q) mu, mu = -F (q1, q2). With exact
    inertia and momentum, the outputs q1 and q2 obey y' = mu exactly; the rotation about z is not
    controlled. The pointing error is 2 asin(sqrt(q1^2 + q2^2)). At half a turn beta does not exist:
    from `LEAST_COSINE` on, the law uses the nearest attitude at which beta exists and sets
    `singular`. This is a controller of the loop, and also the law of a `ModelErrorCompensator`.

    Attributes:
        spacecraft: Model of body and two wheels in the controller.
        feedback: Diagonal of F, (2,), 1/s.
        total_momentum: Total momentum in inertial axes assumed by the controller, (3,), N·m·s.
        momentum_measured: Whether the momentum is computed from the measured body rate and wheel
            speeds instead.
    """

    spacecraft: Spacecraft
    feedback: Annotated[Pair, positive("output zeroing feedback", "1/s")]
    total_momentum: Vector3 = eqx.field(default_factory=lambda: np.zeros(3))
    momentum_measured: bool = eqx.field(static=True, default=False)

    def check_own(self) -> None:
        """Validate wheels and momentum.

        Raises:
            InputError: See `check_two_wheels`; also if the momentum is not finite.
        """
        check_two_wheels("output zeroing", self.spacecraft)
        if not np.all(np.isfinite(np.asarray(self.total_momentum))):
            raise InputError("output zeroing: found a momentum that is not finite")

    def wheel_speed(
        self, attitude: Quaternion, momentum: Vector3, virtual_input: Pair
    ) -> tuple[Pair, Bool[Array, ""]]:
        """Wheel speeds that give (q1, q2) a commanded rate.

        Args:
            attitude: Unit quaternion of the attitude, scalar first, (4,).
            momentum: Total momentum in body axes, (3,), N·m·s.
            virtual_input: Commanded rate of (q1, q2), (2,), 1/s.

        Returns:
            Wheel speeds relative to the body, (2,), rad/s, and whether the attitude is singular.
        """
        wheels = self.spacecraft.wheels
        inverse = inverse_definite(self.spacecraft.inertia_locked())
        along = jnp.stack([attitude[0], attitude[3]])
        length = jnp.sqrt(along @ along)
        is_far = length < LEAST_COSINE
        ahead = jnp.where(length > 0.0, along, jnp.array([1.0, 0.0]))
        ahead = LEAST_COSINE * ahead / jnp.where(length > 0.0, length, 1.0)
        q0, q3 = jnp.where(is_far, ahead, along)
        q1, q2 = attitude[1], attitude[2]
        rates = 0.5 * jnp.array([[q0, -q3, q2], [q3, q0, -q1]]) @ inverse
        (a, b), (c, d) = -rates @ (jnp.asarray(wheels.axes) * wheels.inertia)
        demand = virtual_input - rates @ momentum
        size = (a * a + b * b) + (c * c + d * d)
        determinant = a * d - b * c
        flat = jnp.abs(determinant) < PARALLEL * size
        floor = jnp.where(determinant < 0.0, -PARALLEL, PARALLEL) * size
        divisor = jnp.where(flat, floor, determinant)
        speed = jnp.stack([d * demand[0] - b * demand[1], a * demand[1] - c * demand[0]]) / divisor
        return speed, is_far | flat

    def start(self, period: Scalar) -> Quaternion:
        """Initial memory: zeros in place of the last attitude."""
        return jnp.zeros(4)

    def observe(self, memory: Quaternion, measurement: Any) -> tuple[Quaternion, Pair]:
        """Attitude quaternion with the sign nearer to the last one, and its q1 and q2."""
        attitude = measurement.attitude
        attitude = jnp.where(attitude @ memory < 0.0, -attitude, attitude)
        return attitude, attitude[1:3]

    def nominal_input(self, output: Pair) -> Pair:
        """Virtual input mu = -F y, (12)."""
        return -jnp.asarray(self.feedback) * output

    def command(
        self, memory: Quaternion, measurement: Any, input: Pair, compensation: Compensation
    ) -> ZeroingCommand:
        """Wheel speed command for a virtual input, (11)."""
        wheels = self.spacecraft.wheels
        if self.momentum_measured:
            rotors = jnp.asarray(wheels.axes) @ (wheels.inertia * measurement.wheel_speed)
            momentum = self.spacecraft.inertia_locked() @ measurement.rate + rotors
        else:
            momentum = to_body(memory, jnp.asarray(self.total_momentum))
        speed, singular = self.wheel_speed(memory, momentum, input)
        return ZeroingCommand(speed, input, singular, compensation.model_error, compensation.gain)

    def __call__(self, memory: Quaternion, measurement: Any) -> tuple[Quaternion, ZeroingCommand]:
        """Compute the wheel speed command."""
        memory, output = self.observe(memory, measurement)
        input = self.nominal_input(output)
        return memory, self.command(memory, measurement, input, Compensation.none(input))
