"""One-axis air-bearing table with a reaction wheel."""

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Bool

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, finite, positive
from gyrostat.core.jax64 import jnp
from gyrostat.wheel import BearingEquation, Driver, Motion, Wheel, step_wheel


class TableState(NamedTuple):
    """State of the table and its wheel.

    Attributes:
        attitude: of the table, rad.
        rate: of the table, rad/s.
        speed: of the wheel relative to the table, rad/s; exactly zero while it sticks.
        wheel_angle: turned by the wheel relative to the table, rad.
        current: in the motor, A.
        bristle: deflection of the bristles, rad; zero where the friction has none.
    """

    attitude: Annotated[Scalar, "rad"]
    rate: Annotated[Scalar, "rad/s"]
    speed: Annotated[Scalar, "rad/s"]
    wheel_angle: Annotated[Scalar, "rad"]
    current: Annotated[Scalar, "A"]
    bristle: Annotated[Scalar, "rad"]


class TableCommand(NamedTuple):
    """The least that a controller commands.

    Attributes:
        current: of the motor, A.
    """

    current: Annotated[Scalar, "A"]


class DriveRecord(NamedTuple):
    """What is worth recording of the drive.

    Attributes:
        saturated: whether a limit kept the current from its command.
        power: drawn from the bus, W.
    """

    saturated: Annotated[Scalar, "1"]
    power: Annotated[Scalar, "W"]


class _Carrier(NamedTuple):
    attitude: Scalar
    rate: Scalar
    wheel_angle: Scalar


class _OnTable(BearingEquation):
    """Wheel and table over one interval of held command."""

    friction: Any
    table: "AirBearingTable"
    started_current: Scalar
    set_point: Scalar
    started: Scalar

    def inertia(self) -> Scalar:
        table, wheel = self.table.inertia, self.table.wheel.inertia
        return table * wheel / (table + wheel)

    def _motor_torque(self, time: Scalar) -> Scalar:
        current = self.table.driver.current(self.started_current, self.set_point, time)
        return self.table.wheel.motor_constant * current

    def load(self, carrier: _Carrier, time: Scalar) -> Scalar:
        # a held wheel turns with the table, which takes its share of the external torque
        wheel = self.table.wheel.inertia
        share = wheel / (self.table.inertia + wheel)
        return self._motor_torque(time) - share * self.table.torque(self.started + time)

    def carrier_rate(
        self, carrier: _Carrier, speed: Scalar, friction: Scalar, time: Scalar
    ) -> _Carrier:
        external = self.table.torque(self.started + time)
        rate = (external - self._motor_torque(time) + friction) / self.table.inertia
        return _Carrier(carrier.rate, rate, speed)

    def longest_segment(self, time: Scalar) -> Scalar:
        return self.table.driver.longest_segment(time)


class AirBearingTable(Checked):
    """J dΩ/dt = T_d - (k_m I - F) and J_w (dw/dt + dΩ/dt) = k_m I - F.

    Carrara and Kuga, "Estimating friction parameters in reaction wheels for attitude control", eq.
    (17), with J the table's inertia and the wheel speed w relative to the table, which is what its
    bearing feels and its tachometer sees. Positive motor torque speeds the wheel up and pushes the
    table back. Momentum J_w w + (J + J_w) Ω changes by T_d alone.

    Attributes:
        inertia: of the table without the rotor of the wheel, kg·m².
        wheel: what it carries.
        driver: of the wheel's motor.
        external_torque: constant torque on the table, N·m, as of a fan.
        torque_history: external torque over time, s -> N·m, added to the constant; a function of
            JAX arrays. It is sampled only thrice in an integration step, so it must be smooth and
            slow there: a peak inside a step may pass unseen. Choose `step` of `simulate` by it.
    """

    inertia: Annotated[Scalar, positive("table inertia", "kg·m²")]
    wheel: Wheel
    driver: Driver = Driver()
    external_torque: Annotated[Scalar, finite("external torque", "N·m")] = 0.0
    torque_history: Callable[[Scalar], Scalar] | None = eqx.field(static=True, default=None)

    def torque(self, time: Scalar) -> Scalar:
        """External torque T_d on the table, N·m, at a time, s."""
        extra = 0.0 if self.torque_history is None else self.torque_history(time)
        return self.external_torque + extra

    def start(
        self, *, attitude: Scalar = 0.0, rate: Scalar = 0.0, speed: Scalar = 0.0
    ) -> TableState:
        """A state without current.

        Args:
            attitude: rad.
            rate: rad/s.
            speed: of the wheel relative to the table, rad/s.
        """
        values = (attitude, rate, speed, 0.0, 0.0, 0.0)
        return TableState(*(jnp.asarray(value, dtype=float) for value in values))

    def __call__(
        self, state: TableState, command: Any, time: Scalar, duration: Scalar
    ) -> tuple[TableState, Bool[Array, ""]]:
        """Carry the table over an interval of held command.

        Args:
            state: at its start.
            command: has `current`, A.
            time: of its start, s.
            duration: s.

        Returns:
            The state at its end, and whether the friction curve could be resolved.
        """
        target = self.driver.set_point(command.current, state.speed, self.wheel.motor_constant)
        contact = _OnTable(self.wheel.friction, self, state.current, target, time)
        carrier = _Carrier(state.attitude, state.rate, state.wheel_angle)
        motion = Motion(jnp.asarray(state.speed), carrier)
        motion, bristle, resolved = step_wheel(contact, motion, state.bristle, duration)
        return (
            TableState(
                attitude=motion.carrier.attitude,
                rate=motion.carrier.rate,
                speed=motion.speed,
                wheel_angle=motion.carrier.wheel_angle,
                current=self.driver.current(state.current, target, duration),
                bristle=bristle,
            ),
            resolved,
        )

    def diverged(self, state: TableState) -> Bool[Array, ""]:
        """Whether the table has left every attitude that a controller could mean: half a turn."""
        return ~(jnp.abs(state.attitude) < jnp.pi)

    def record(self, state: TableState, command: Any) -> DriveRecord:
        """What the drive does at the start of a control period."""
        motor = self.wheel.motor_constant
        target = self.driver.set_point(command.current, state.speed, motor)
        # without a lag the current jumps to its set point at once
        current = self.driver.current(state.current, target, 0.0)
        return DriveRecord(
            saturated=self.driver.limited(command.current, target),
            power=self.driver.power(current, state.speed, motor),
        )

    def momentum(self, state: TableState) -> Scalar:
        """J_w w + (J + J_w) Ω, N·m·s."""
        wheel = self.wheel.inertia
        return wheel * state.speed + (self.inertia + wheel) * state.rate

    def kinetic_energy(self, state: TableState) -> Scalar:
        """Of table and rotor, J."""
        rotor = state.speed + state.rate
        return 0.5 * (self.inertia * state.rate**2 + self.wheel.inertia * rotor**2)
