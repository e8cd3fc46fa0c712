"""Wheel on a fixed bench with torque commands, and a sensor of its momentum."""

from typing import Annotated, Any, NamedTuple

from jaxtyping import Array, Bool, PRNGKeyArray

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel import BearingEquation, Motion, Wheel, step_wheel
from gyrostat.wheel.friction import Bristles

FADING_STEP = 0.2
"""Integration segment of a decaying torque, relative to its time constant."""


class BenchWheelState(NamedTuple):
    """State of a wheel on a bench.

    Attributes:
        speed: Wheel speed, rad/s.
        bristle: Deflection of the bristles, rad; zero for friction without bristles.
    """

    speed: Annotated[Scalar, "rad/s"]
    bristle: Annotated[Scalar, "rad"]


class TorqueCommand(NamedTuple):
    """Motor torque u(t) = torque + fading_torque exp(-fading_rate t) in a control period.

    Attributes:
        torque: Constant part, N·m.
        fading_torque: Decaying part at the start of the period, N·m.
        fading_rate: Decay rate, 1/s.
    """

    torque: Annotated[Scalar, "N·m"]
    fading_torque: Annotated[Scalar, "N·m"] = 0.0
    fading_rate: Annotated[Scalar, "1/s"] = 0.0


class BenchRecord(NamedTuple):
    """Recorded signals.

    Attributes:
        momentum: Wheel momentum, N·m·s.
        friction: Friction torque, N·m; for a wheel at rest without bristles, the motor torque.
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
        wheel: Wheel; its motor constant is unused.
    """

    wheel: Wheel

    def start(self, *, speed: Scalar = 0.0, bristle: Scalar = 0.0) -> BenchWheelState:
        """State with the given speed, rad/s, and bristle deflection, rad."""
        return BenchWheelState(jnp.asarray(speed, float), jnp.asarray(bristle, float))

    def __call__(
        self, state: BenchWheelState, command: TorqueCommand, time: Scalar, duration: Scalar
    ) -> tuple[BenchWheelState, Bool[Array, ""]]:
        """Advance the wheel over an interval of constant command; return state and `resolved`."""
        contact = _OnBench(self.wheel.friction, self.wheel, command)
        motion = Motion(jnp.asarray(state.speed), ())
        motion, bristle, resolved = step_wheel(contact, motion, state.bristle, duration)
        return BenchWheelState(motion.speed, bristle), resolved

    def diverged(self, state: BenchWheelState) -> Bool[Array, ""]:
        """Whether the wheel is faster than any wheel bearing allows, 10 000 rad/s."""
        return ~(jnp.abs(state.speed) < 1e4)

    def record(self, state: BenchWheelState, command: TorqueCommand) -> BenchRecord:
        """Momentum and friction torque at the start of a control period."""
        friction = self.wheel.friction
        if isinstance(friction, Bristles):
            torque = friction.torque(state.speed, state.bristle)
        else:
            drive = command.torque + command.fading_torque
            direction = jnp.sign(state.speed)
            sense = jnp.sign(drive)
            stiction = sense * jnp.minimum(jnp.abs(drive), friction.breakaway_torque(sense))
            torque = jnp.where(direction == 0.0, stiction, friction.torque(state.speed, direction))
        return BenchRecord(self.wheel.inertia * state.speed, torque)


class MomentumMeasurement(NamedTuple):
    """Measured momentum.

    Attributes:
        momentum: Momentum, N·m·s.
    """

    momentum: Annotated[Scalar, "N·m·s"]


class MomentumSensor(Checked):
    """Momentum of the wheel with white noise: a measured speed times an inertia.

    Attributes:
        inertia: Rotor inertia assumed by the sensor, kg·m²; `BenchWheel` has the true one.
        sigma: Standard deviation of a sample, N·m·s.
    """

    inertia: Annotated[Scalar, positive("sensor inertia", "kg·m²")]
    sigma: Annotated[Scalar, size("momentum sigma", "N·m·s")] = 0.0

    def start(self, state: Any, period: Scalar) -> tuple[()]:
        """The sensor has no memory."""
        return ()

    def __call__(
        self, memory: tuple[()], state: Any, key: PRNGKeyArray
    ) -> tuple[tuple[()], MomentumMeasurement]:
        """Measure the momentum."""
        noise = self.sigma * jax.random.normal(key, jnp.shape(state.speed))
        return memory, MomentumMeasurement(self.inertia * state.speed + noise)
