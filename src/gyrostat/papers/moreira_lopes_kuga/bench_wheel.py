"""Wheel on a fixed bench with torque commands, and a sensor of its momentum."""

from typing import Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Bool, PRNGKeyArray

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.validation import check_parts, require
from gyrostat.wheel import Contact, Motion, Wheel, carry
from gyrostat.wheel.friction import LuGre

FADING_STEP = 0.2
"""Integration segment of a decaying torque, relative to its time constant."""


class BenchWheelState(NamedTuple):
    """State of a wheel on a bench.

    Attributes:
        speed: Wheel speed, rad/s.
        bristle: Deflection of the bristles, rad; zero for friction without bristles.
    """

    speed: Scalar
    bristle: Scalar

    UNITS = {"speed": "rad/s", "bristle": "rad"}  # noqa: RUF012


class TorqueCommand(NamedTuple):
    """Motor torque u(t) = torque + fading_torque exp(-fading_rate t) in a control period.

    Attributes:
        torque: Constant part, N·m.
        fading_torque: Decaying part at the start of the period, N·m.
        fading_rate: Decay rate, 1/s.
    """

    torque: Scalar
    fading_torque: Scalar = 0.0
    fading_rate: Scalar = 0.0

    UNITS = {"torque": "N·m", "fading_torque": "N·m", "fading_rate": "1/s"}  # noqa: RUF012


class BenchRecord(NamedTuple):
    """Recorded signals.

    Attributes:
        momentum: Wheel momentum, N·m·s.
        friction: Friction torque, N·m; for a wheel at rest without bristles, the motor torque.
    """

    momentum: Scalar
    friction: Scalar

    UNITS = {"momentum": "N·m·s", "friction": "N·m"}  # noqa: RUF012


class _OnBench(Contact):
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


class BenchWheel(eqx.Module):
    """J dw/dt = u - N with static or bristle friction N.

    Moreira, Lopes and Kuga, "Estimation of torque in a reaction wheel using a bristle model for
    friction", eq. (5), with h = J w.

    Attributes:
        wheel: Wheel; its motor constant is unused.
    """

    wheel: Wheel

    def check(self) -> None:
        """Validate parameters.

        Raises:
            InputError: The inertia is not finite or not above zero, or `Friction.check` or
                `LuGre.check` fails.
        """
        require("wheel inertia", self.wheel.inertia, "kg·m²", positive=True)
        check_parts(self.wheel.friction)

    def start(self, *, speed: Scalar = 0.0, bristle: Scalar = 0.0) -> BenchWheelState:
        """State with the given speed, rad/s, and bristle deflection, rad."""
        return BenchWheelState(jnp.asarray(speed, float), jnp.asarray(bristle, float))

    def __call__(
        self, state: BenchWheelState, command: TorqueCommand, time: Scalar, duration: Scalar
    ) -> tuple[BenchWheelState, Bool[Array, ""]]:
        """Advance the wheel over an interval of constant command; return state and `resolved`."""
        contact = _OnBench(self.wheel.friction, self.wheel, command)
        motion = Motion(jnp.asarray(state.speed), ())
        motion, bristle, resolved = carry(contact, motion, state.bristle, duration)
        return BenchWheelState(motion.speed, bristle), resolved

    def diverged(self, state: BenchWheelState) -> Bool[Array, ""]:
        """Whether the wheel is faster than any wheel bearing allows, 10 000 rad/s."""
        return ~(jnp.abs(state.speed) < 1e4)

    def record(self, state: BenchWheelState, command: TorqueCommand) -> BenchRecord:
        """Momentum and friction torque at the start of a control period."""
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
    """Measured momentum.

    Attributes:
        momentum: Momentum, N·m·s.
    """

    momentum: Scalar

    UNITS = {"momentum": "N·m·s"}  # noqa: RUF012


class MomentumSensor(eqx.Module):
    """Sensor of wheel momentum with white noise: measured speed times an assumed inertia.

    Attributes:
        inertia: Rotor inertia assumed by the sensor, kg·m²; `BenchWheel` has the true one.
        sigma: Standard deviation of a sample, N·m·s.
    """

    inertia: Scalar
    sigma: Scalar = 0.0

    def check(self) -> None:
        """Validate parameters; raises `InputError`."""
        require("sensor inertia", self.inertia, "kg·m²", positive=True)
        require("momentum sigma", self.sigma, "N·m·s")

    def start(self, state: Any, period: Scalar) -> tuple[()]:
        """The sensor has no memory."""
        return ()

    def __call__(
        self, memory: tuple[()], state: Any, key: PRNGKeyArray
    ) -> tuple[tuple[()], MomentumMeasurement]:
        """Measure the momentum."""
        noise = self.sigma * jax.random.normal(key, jnp.shape(state.speed))
        return memory, MomentumMeasurement(self.inertia * state.speed + noise)
