"""Momentum unloading of the wheels by torque rods."""

from typing import Annotated, Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat.control.magnetic.b_cross import rod_dipole
from gyrostat.control.measured import measured
from gyrostat.control.missing_sample import predicted
from gyrostat.control.unloading import acting, excess_momentum, with_unloading
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked, positive, positive_share, share, signed, size
from gyrostat.core.jax64 import jnp
from gyrostat.wheel import WheelArray
from gyrostat.wheel.array import listed, zeros


class _Rods(NamedTuple):
    torque_rods: Annotated[Vector3, "A·m²"]


class RodUnloading(Checked):
    """Controller with momentum unloading by the cross-product law.

    The dipole moment is m = k / (s |B|²) (h - h_t) x B, where h is the momentum of the wheels, h_t
    its target and B the measured field, both in body axes. Its mean torque is -k times the part of
    h - h_t across B. The attitude controller makes the wheels take it up, so that h approaches h_t
    while B turns along the orbit. If a dipole is limited, |h - h_t| still decreases. J. R. Wertz,
    "Spacecraft Attitude Determination and Control", chapter 19; M. J. Sidi, "Spacecraft Dynamics
    and Control", section 7.5.

    The torque of the rods disturbs the attitude. With `compensation`, this share of it is added to
    the wheel torques at once. Controllers that estimate external torques (`WheelArrayControl`)
    compensate for it themselves, with a lag; for them the share is 0.

    The field is that of the sensor `magnetometer`. The rods are driven by the field `torque_rods`
    of the command.

    Attributes:
        controller: Any controller that commands wheel torques.
        wheels: Wheels as the controller knows them.
        limit: Largest commanded dipole moment along each body axis, (3,), or one value for all,
            A·m²; in modes whose law commands rods too, of the sum.
        gain: Gain k, 1/s; slow compared with the attitude loop.
        momentum: Target h_t of the wheels' momentum in body axes, (3,), N·m·s.
        duty: Share s of each control period in which the rods are on.
        compensation: Share of the rods' torque that is added to the wheel torques.
        in_modes: Whether it acts in each mode of the reference, (modes,), 0 or 1; None: always.
    """

    controller: Any
    wheels: WheelArray
    limit: Annotated[Vector3 | Scalar, size("dipole limit of the unloading", "A·m²")] = eqx.field(
        converter=listed
    )
    gain: Annotated[Scalar, positive("gain of the unloading", "1/s")] = 1e-3
    momentum: Annotated[Vector3, signed("size of the momentum target", "N·m·s")] = zeros()
    duty: Annotated[Scalar, positive_share("duty of the unloading")] = 1.0
    compensation: Annotated[Scalar, share("compensation of the unloading")] = 0.0
    in_modes: Float[Array, " modes"] | None = None

    def start(self, period: Scalar) -> Any:
        """Initial memory of the controller."""
        return self.controller.start(period)

    def predicted(self, memory: Any, measurement: Any, command: Any) -> Any:
        """Memory of the controller one period later without a sample.

        Args:
            memory: Memory of the controller.
            measurement: Last accepted measurement.
            command: Safe command that is sent.
        """
        return predicted(self.controller, memory, measurement, command)

    def __call__(self, memory: Any, measurement: Any) -> tuple[Any, Any]:
        """Compute the command of the controller with the dipole moments `torque_rods`, (3,), A·m².

        Args:
            memory: Memory of the controller.
            measurement: Measurement with `magnetometer` (3,), T, and `wheel_speed` (wheels,),
                rad/s, and with the fields that the controller needs.

        Raises:
            InputError: The measurement has no field `magnetometer`; or the controller commands rods
                itself, and `in_modes` is None.
        """
        field = measured(measurement, "magnetometer", "unloading")
        memory, command = self.controller(memory, measurement)
        excess = excess_momentum(self.wheels, measurement.wheel_speed, self.momentum)
        excess = excess * acting(self.in_modes, command)
        demand = self.gain / self.duty * rod_dipole(excess, field)
        dipole = jnp.clip(demand, -self.limit, self.limit)
        return memory, with_unloading(
            self.wheels,
            command,
            _Rods(dipole),
            lambda added: self.duty * jnp.cross(added, field),
            self.compensation,
            limit=self.limit,
            name="rods",
            in_modes=self.in_modes,
        )
