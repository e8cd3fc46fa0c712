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
        attitude: Attitude angle of the table, rad.
        rate: Rate of the table, rad/s.
        speed: Wheel speed relative to the table, rad/s; exactly zero while the wheel sticks.
        wheel_angle: Rotor angle relative to the table, rad.
        current: Motor current, A.
        bristle: Deflection of the bristles, rad; zero for friction models without bristles.
    """

    attitude: Annotated[Scalar, "rad"]
    rate: Annotated[Scalar, "rad/s"]
    speed: Annotated[Scalar, "rad/s"]
    wheel_angle: Annotated[Scalar, "rad"]
    current: Annotated[Scalar, "A"]
    bristle: Annotated[Scalar, "rad"]


class TableCommand(NamedTuple):
    """Command of a table; controllers may add fields.

    Attributes:
        current: Motor current, A.
    """

    current: Annotated[Scalar, "A"]


class DriveRecord(NamedTuple):
    """Recorded signals of the drive.

    Attributes:
        saturated: Whether a limit reduces the commanded current.
        power: Power drawn from the bus, W.
    """

    saturated: Annotated[Scalar, "1"]
    power: Annotated[Scalar, "W"]


class _Carrier(NamedTuple):
    attitude: Scalar
    rate: Scalar
    wheel_angle: Scalar


class _OnTable(BearingEquation):
    """Bearing equation of the wheel on the table over one interval of constant command."""

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
        # a sticking wheel rotates with the table and takes its share of the external torque
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
    """Air-bearing table: J dΩ/dt = T_d - (k_m I - F), J_w (dw/dt + dΩ/dt) = k_m I - F.

    Carrara and Kuga, "Estimating friction parameters in reaction wheels for attitude control", eq.
    (17). J is the inertia of the table and w the wheel speed relative to the table, on which
    friction and tachometer depend. Positive motor torque accelerates the wheel and decelerates the
    table. The momentum J_w w + (J + J_w) Ω changes only by the external torque T_d.

    Attributes:
        inertia: Inertia of the table without the rotor of the wheel, kg·m².
        wheel: Reaction wheel.
        driver: Motor electronics of the wheel.
        external_torque: Constant torque on the table, for example from a fan, N·m.
        torque_history: External torque over time, s -> N·m, added to the constant; a function of
            JAX arrays. It is sampled only three times in an integration step, so it must be smooth
            and slow: a short peak may be missed. Choose `step` of `simulate` accordingly.
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
        """Create a state without current.

        Args:
            attitude: Attitude angle, rad.
            rate: Rate, rad/s.
            speed: Wheel speed relative to the table, rad/s.
        """
        values = (attitude, rate, speed, 0.0, 0.0, 0.0)
        return TableState(*(jnp.asarray(value, dtype=float) for value in values))

    def __call__(
        self, state: TableState, command: Any, time: Scalar, duration: Scalar
    ) -> tuple[TableState, Bool[Array, ""]]:
        """Integrate over an interval of constant command.

        Args:
            state: State at the start.
            command: Command with `current`, A.
            time: Time at the start, s.
            duration: Length of the interval, s.

        Returns:
            The state at the end, and whether the friction curve was resolved.
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
        """Whether the attitude is beyond half a turn, or NaN."""
        return ~(jnp.abs(state.attitude) < jnp.pi)

    def record(self, state: TableState, command: Any) -> DriveRecord:
        """Saturation and power of the drive at the start of a control period."""
        motor = self.wheel.motor_constant
        target = self.driver.set_point(command.current, state.speed, motor)
        # without a lag the current jumps to its set point
        current = self.driver.current(state.current, target, 0.0)
        return DriveRecord(
            saturated=self.driver.limited(command.current, target),
            power=self.driver.power(current, state.speed, motor),
        )

    def momentum(self, state: TableState) -> Scalar:
        """Total momentum J_w w + (J + J_w) Ω, N·m·s."""
        wheel = self.wheel.inertia
        return wheel * state.speed + (self.inertia + wheel) * state.rate

    def kinetic_energy(self, state: TableState) -> Scalar:
        """Kinetic energy of table and rotor, J."""
        rotor = state.speed + state.rate
        return 0.5 * (self.inertia * state.rate**2 + self.wheel.inertia * rotor**2)
