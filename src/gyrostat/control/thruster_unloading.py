"""Momentum unloading of the wheels by thrusters."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.control.missing_sample import predicted
from gyrostat.control.unloading import acting, excess_momentum, with_unloading
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked, positive, share, signed, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.spacecraft import Thrusters
from gyrostat.wheel import WheelArray
from gyrostat.wheel.array import zeros


class _Thrust(NamedTuple):
    thrusters: Annotated[Float[Array, " thruster"], "s"]


class ThrusterUnloadingMemory(NamedTuple):
    """Memory of `ThrusterUnloading`.

    Attributes:
        controller: Memory of the controller.
        unloads: Whether each body axis is unloaded, (3,).
        period: Control period, s.
    """

    controller: Any
    unloads: Bool[Array, "3"]
    period: Scalar


class ThrusterUnloading(Checked):
    """Controller with momentum unloading by pairs of thrusters, with hysteresis about each axis.

    An axis is unloaded from the moment when the size of h - h_t along it exceeds `begin` until it
    is below `end`. Here h is the momentum of the wheels and h_t its target, in body axes. In each
    control period its pair fires for h - h_t over the torque of the pair, limited by `impulse`. The
    mean torque disturbs the attitude; with `compensation`, this share of it is added to the wheel
    torques at once. For controllers that estimate external torques, the share is 0. M. J. Sidi,
    "Spacecraft Dynamics and Control", section 7.6.

    The thrusters are those of `Thrusters.couples`, driven by the field `thrusters` of the command.

    Attributes:
        controller: Any controller that commands wheel torques.
        wheels: Wheels as the controller knows them.
        arm: Distance of each thruster from the centre of mass, m.
        force: Thrust of each thruster, N.
        begin: Momentum above which an axis is unloaded, N·m·s.
        end: Momentum below which unloading ends, N·m·s; at least the impulse of a pulse of minimum
            length, 2 `arm` `force` `minimum`.
        impulse: Largest angular impulse in a control period about each axis, N·m·s. Over the
            control period, it must stay below the torque that the wheels can give: until they have
            given the momentum up, it is commanded again.
        minimum: Minimum on-time, s; shorter pulses are not commanded.
        momentum: Target h_t of the wheels' momentum in body axes, (3,), N·m·s.
        compensation: Share of the thrusters' torque that is added to the wheel torques.
        in_modes: Whether it acts in each mode of the reference, (modes,), 0 or 1; None: always.
    """

    controller: Any
    wheels: WheelArray
    arm: Annotated[Scalar, positive("arm of the thrusters", "m")]
    force: Annotated[Scalar, positive("thrust", "N")]
    begin: Annotated[Scalar, positive("begin of the unloading", "N·m·s")]
    end: Annotated[Scalar, positive("end of the unloading", "N·m·s")]
    impulse: Annotated[Scalar, positive("impulse of the unloading", "N·m·s")]
    minimum: Annotated[Scalar, size("minimum on-time", "s")] = 0.0
    momentum: Annotated[Vector3, signed("size of the momentum target", "N·m·s")] = zeros()
    compensation: Annotated[Scalar, share("compensation of the unloading")] = 0.0
    in_modes: Float[Array, " modes"] | None = None

    def start(self, period: Scalar) -> ThrusterUnloadingMemory:
        """Initial memory: no axis is unloaded."""
        inner = self.controller.start(period)
        return ThrusterUnloadingMemory(inner, jnp.zeros(3, bool), jnp.asarray(period, dtype=float))

    def predicted(
        self, memory: ThrusterUnloadingMemory, measurement: Any, command: Any
    ) -> ThrusterUnloadingMemory:
        """Memory one period later without a sample; see `RodUnloading.predicted`."""
        inner = predicted(self.controller, memory.controller, measurement, command)
        return memory._replace(controller=inner)

    def __call__(
        self, memory: ThrusterUnloadingMemory, measurement: Any
    ) -> tuple[ThrusterUnloadingMemory, Any]:
        """Compute the command of the controller with the on-times `thrusters`, (12,), s.

        Args:
            memory: Memory.
            measurement: Measurement with `wheel_speed` (wheels,), rad/s, and with the fields that
                the controller needs.

        Raises:
            InputError: The controller commands thrusters itself.
        """
        inner, command = self.controller(memory.controller, measurement)
        excess = excess_momentum(self.wheels, measurement.wheel_speed, self.momentum)
        excess = excess * acting(self.in_modes, command)
        magnitude = jnp.abs(excess)
        unloads = (magnitude > self.begin) | (memory.unloads & (magnitude > self.end))
        impulse = jnp.where(unloads, -jnp.clip(excess, -self.impulse, self.impulse), 0.0)
        pairs = Thrusters.couples(self.arm, self.force, memory.period, minimum=self.minimum)
        levers = jnp.cross(jnp.asarray(pairs.positions), jnp.asarray(pairs.directions))
        # the two thrusters of a pair turn in the same sense, with one arm each
        on_time = pairs.on_time(
            jnp.maximum(levers @ impulse, 0.0) / (2.0 * self.arm**2 * self.force)
        )
        command = with_unloading(
            self.wheels,
            command,
            _Thrust(on_time),
            lambda added: (self.force * added / memory.period) @ levers,
            self.compensation,
            limit=memory.period,
            name="thrusters",
            in_modes=self.in_modes,
        )
        return memory._replace(controller=inner, unloads=unloads), command

    def check_own(self) -> None:
        """Validate the hysteresis.

        Raises:
            InputError: Unloading would end above the momentum at which it begins; or `end` or
                `impulse` is below the impulse of a pulse of minimum length.
        """
        shortest = 2.0 * self.arm * self.force * self.minimum
        if not np.all(np.asarray(self.end) < self.begin):
            raise InputError(
                f"end of the unloading: found {np.max(self.end):g} N·m·s, expected below its "
                f"begin, {np.min(self.begin):g} N·m·s"
            )
        for name, value in (("end", self.end), ("impulse", self.impulse)):
            if not np.all(np.asarray(value) >= shortest):
                raise InputError(
                    f"{name} of the unloading: found {np.min(value):g} N·m·s, expected at "
                    f"least the impulse of the shortest pulse, {np.max(shortest):g} N·m·s"
                )
