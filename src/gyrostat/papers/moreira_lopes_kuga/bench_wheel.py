"""A wheel on a fixed bench that is commanded in torque, and a sensor of its momentum."""

from typing import Annotated, Any, NamedTuple

from jaxtyping import Array, Bool, PRNGKeyArray

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel import BearingEquation, Motion, Wheel, step_wheel
from gyrostat.wheel.friction import LuGre

FADING_STEP = 0.2
"""Share of its time constant in which a fading torque is resolved."""


class BenchWheelState(NamedTuple):
    """State of a wheel on a bench.

    Attributes:
        speed: rad/s.
        bristle: deflection of the bristles, rad; zero where the friction has none.
    """

    speed: Annotated[Scalar, "rad/s"]
    bristle: Annotated[Scalar, "rad"]


class TorqueCommand(NamedTuple):
    """Motor torque u(t) = torque + fading_torque exp(-fading_rate t) through a control period.

    Attributes:
        torque: N·m.
        fading_torque: N·m.
        fading_rate: 1/s.
    """

    torque: Annotated[Scalar, "N·m"]
    fading_torque: Annotated[Scalar, "N·m"] = 0.0
    fading_rate: Annotated[Scalar, "1/s"] = 0.0


class BenchRecord(NamedTuple):
    """What is worth recording.

    Attributes:
        momentum: of the wheel, N·m·s.
        friction: torque in the bearing, N·m; of a resting wheel without bristles the motor torque.
    """

    momentum: Annotated[Scalar, "N·m·s"]
    friction: Annotated[Scalar, "N·m"]


class _OnBench(BearingEquation):
    friction: Any
    wheel: Wheel
    command: TorqueCommand

    def inertia(self) -> Scalar:
        return self.wheel.inertia

    def load(self, carrier: tuple[()], time: Scalar) -> Scalar:
        fading = self.command.fading_torque * jnp.exp(-self.command.fading_rate * time)
        return self.command.torque + fading

    def carrier_rate(
        self, carrier: tuple[()], speed: Scalar, friction: Scalar, time: Scalar
    ) -> tuple[()]:
        return ()

    def longest_segment(self, time: Scalar) -> Scalar:
        fades = self.command.fading_rate > 0.0
        rate = jnp.where(fades, self.command.fading_rate, 1.0)
        return jnp.where(fades, FADING_STEP / rate, jnp.inf)


class BenchWheel(Checked):
    """J dw/dt = u - N, the friction N static or of bristles.

    Moreira, Lopes and Kuga, "Estimation of torque in a reaction wheel using a bristle model for
    friction", eq. (5), with h = J w.

    Attributes:
        wheel: its motor constant is not used.
    """

    wheel: Wheel

    def start(self, *, speed: Scalar = 0.0, bristle: Scalar = 0.0) -> BenchWheelState:
        """A state: speed, rad/s, and deflection of the bristles, rad."""
        return BenchWheelState(jnp.asarray(speed, float), jnp.asarray(bristle, float))

    def __call__(
        self, state: BenchWheelState, command: TorqueCommand, time: Scalar, duration: Scalar
    ) -> tuple[BenchWheelState, Bool[Array, ""]]:
        """Carry the wheel over an interval of one command; the new state, and whether resolved."""
        contact = _OnBench(self.wheel.friction, self.wheel, command)
        motion = Motion(jnp.asarray(state.speed), ())
        motion, bristle, resolved = step_wheel(contact, motion, state.bristle, duration)
        return BenchWheelState(motion.speed, bristle), resolved

    def diverged(self, state: BenchWheelState) -> Bool[Array, ""]:
        """Whether the wheel is faster than any bearing bears: 10 000 rad/s."""
        return ~(jnp.abs(state.speed) < 1e4)

    def record(self, state: BenchWheelState, command: TorqueCommand) -> BenchRecord:
        """Momentum and friction at the start of a control period."""
        friction = self.wheel.friction
        if isinstance(friction, LuGre):
            torque = friction.torque(state.speed, state.bristle)
        else:
            drive = command.torque + command.fading_torque
            direction = jnp.sign(state.speed)
            sense = jnp.sign(drive)
            held = sense * jnp.minimum(jnp.abs(drive), friction.breakaway_torque(sense))
            torque = jnp.where(direction == 0.0, held, friction.torque(state.speed, direction))
        return BenchRecord(self.wheel.inertia * state.speed, torque)


class MomentumMeasurement(NamedTuple):
    """A measured momentum.

    Attributes:
        momentum: N·m·s.
    """

    momentum: Annotated[Scalar, "N·m·s"]


class MomentumSensor(Checked):
    """Momentum of the wheel with white noise: a measured speed times an inertia.

    Attributes:
        inertia: of the rotor as whoever measures believes it, kg·m²; `BenchWheel` has the true one.
        sigma: standard deviation of a sample, N·m·s.
    """

    inertia: Annotated[Scalar, positive("sensor inertia", "kg·m²")]
    sigma: Annotated[Scalar, size("momentum sigma", "N·m·s")] = 0.0

    def start(self, state: Any, period: Scalar) -> tuple[()]:
        """It has no memory."""
        return ()

    def __call__(
        self, memory: tuple[()], state: Any, key: PRNGKeyArray
    ) -> tuple[tuple[()], MomentumMeasurement]:
        """Measure."""
        noise = self.sigma * jax.random.normal(key, jnp.shape(state.speed))
        return memory, MomentumMeasurement(self.inertia * state.speed + noise)
