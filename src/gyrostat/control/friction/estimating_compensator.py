"""Friction compensation with on-line estimation of speed and friction."""

from typing import Annotated, Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from gyrostat.control.attitude.attitude_pid import AttitudePID, PIDMemory
from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive
from gyrostat.core.delay_line import empty_line, pushed
from gyrostat.core.jax64 import jnp
from gyrostat.estimation import MomentumEstimate, RateEstimate, RateObserver, WheelMomentumFilter
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import Friction, static_curve

MOMENTUM_FREQUENCY = 0.05
"""rad/s: natural frequency of the momentum filter in `EstimatingCompensator.tuned`."""
SCALES = (0.3, 3.0)
"""Between which the friction scale is kept."""


class EstimatingMemory(NamedTuple):
    """Between two samples.

    Attributes:
        law: of the attitude law.
        momentum: estimate at the coming sample.
        rate: estimate at the coming sample.
        scale: friction of the wheel over friction of the model.
        under_way: (delay,) known torques on the table, N·m, of commands not yet over.
    """

    law: PIDMemory
    momentum: MomentumEstimate
    rate: RateEstimate
    scale: Float[Array, ""]
    under_way: Float[Array, " delay"]


class EstimatingCommand(NamedTuple):
    """A motor current, its parts and what they rest on.

    Attributes:
        current: of the motor, A.
        attitude_current: for the torque that the attitude law and the observer demand, A.
        friction_current: for the friction that is expected, A.
        estimated_speed: Predicted speed of the wheel in the middle of the control period in which
            the command acts, rad/s.
        estimated_torque: external torque, N·m.
        friction_scale: friction of the wheel over friction of the model.
    """

    current: Annotated[Scalar, "A"]
    attitude_current: Annotated[Scalar, "A"]
    friction_current: Annotated[Scalar, "A"]
    estimated_speed: Annotated[Scalar, "rad/s"]
    estimated_torque: Annotated[Scalar, "N·m"]
    friction_scale: Annotated[Scalar, "1"]


class EstimatingCompensator(Checked):
    """Friction of the model under an estimated speed, its level learned, the rest observed away.

    - The speed comes from the momentum of wheel and table, which friction cannot disturb.
    - An observer on the table's rate finds the torque that the model misses, and the demanded
      torque cancels it. What it finds beyond the external torque of the momentum filter is
      friction: it corrects the level of the friction model while the wheel turns.
    - Where the speed may be zero its sign says nothing, and a wheel that sticks would be held by
      it. There the friction is that of a wheel at rest, in the sense of the demanded torque; a
      small demand gets a share of it, so that nothing hunts about rest.

    `tuned` makes one from a wheel model and the noise of its tachometer.

    Attributes:
        law: gives the demanded wheel torque.
        friction: as the controller knows it.
        motor_constant: as the controller knows it, N·m/A.
        momentum: filter that gives the wheel speed.
        observer: of the table's rate and of the torque that the model misses.
        learning_rate: of the friction scale, 1/s.
        band: standard deviations of the speed within which the wheel may stick.
        softness: demanded torque at which the stick rule is fully on, over the breakaway torque.
        current_limit: A.
        delay: control periods from a sample to the command's start.
    """

    law: AttitudePID
    friction: Friction
    motor_constant: Annotated[Scalar, positive("motor_constant")]
    momentum: WheelMomentumFilter
    observer: RateObserver
    learning_rate: Scalar = 0.1
    band: Scalar = 4.0
    softness: Scalar = 0.2
    current_limit: Scalar = np.inf
    delay: int = eqx.field(static=True, default=0)

    @classmethod
    def designed(
        cls,
        wheel: Wheel,
        *,
        table_inertia: Scalar,
        frequency: Scalar,
        speed_sigma: Scalar,
        period: Scalar,
        bandwidth: Scalar = 3.0,
        current_limit: Scalar = np.inf,
        delay: int = 0,
    ) -> "EstimatingCompensator":
        """Design the attitude law by `AttitudePID.designed` and the filters by `tuned`.

        Args:
            wheel: identified wheel.
            table_inertia: inertia of what the wheel turns, without its rotor, kg·m².
            frequency: natural frequency of the attitude loop, rad/s.
            speed_sigma: standard deviation of a tachometer sample, rad/s; see `tuned`.
            period: control period, s.
            bandwidth: bandwidth of the rate observer, rad/s.
            current_limit: limit of the motor current, A.
            delay: control periods from a sample to the command's start.
        """
        return cls.tuned(
            AttitudePID.designed(table_inertia, frequency),
            wheel,
            table_inertia,
            speed_sigma,
            period,
            bandwidth=bandwidth,
            current_limit=current_limit,
            delay=delay,
        )

    @classmethod
    def tuned(
        cls,
        law: AttitudePID,
        wheel: Wheel,
        table_inertia: Scalar,
        speed_sigma: Scalar,
        period: Scalar,
        *,
        bandwidth: Scalar = 3.0,
        current_limit: Scalar = np.inf,
        delay: int = 0,
    ) -> "EstimatingCompensator":
        """Tune by rule.

        The momentum filter settles at `MOMENTUM_FREQUENCY`: of a random walk in torque of density
        q and a measured momentum of density r it is (q / r)^(1/4). The observer is made as quick as
        the control rate and the delay allow: about 3 rad/s at 10 Hz with one period of delay.

        Args:
            law: attitude law.
            wheel: as identified.
            table_inertia: without the rotor, kg·m².
            speed_sigma: noise of a sample of the tachometer, rad/s; for pulses counted over a gate
                time, half of what one pulse more is in speed is more than enough, a fifth best.
            period: control period, s.
            bandwidth: of the observer, rad/s.
            current_limit: A.
            delay: control periods from a sample to the command's start.
        """
        drift = MOMENTUM_FREQUENCY**2 * wheel.inertia * speed_sigma * jnp.sqrt(period)
        return cls(
            law=law,
            friction=static_curve(wheel.friction),
            motor_constant=wheel.motor_constant,
            momentum=WheelMomentumFilter(wheel.inertia, table_inertia, speed_sigma, drift),
            observer=RateObserver(table_inertia, bandwidth),
            current_limit=current_limit,
            delay=delay,
        )

    def start(self, period: Scalar) -> EstimatingMemory:
        """Nothing seen yet."""
        return EstimatingMemory(
            self.law.start(period),
            self.momentum.start(),
            self.observer.start(),
            jnp.array(1.0),
            empty_line(jnp.zeros(()), self.delay),
        )

    def __call__(
        self, memory: EstimatingMemory, measurement: Any
    ) -> tuple[EstimatingMemory, EstimatingCommand]:
        """Command a current.

        Args:
            memory: from the last sample.
            measurement: attitude, rate and the wheel's `speed`.
        """
        period = memory.law.period
        rate = self.observer.correct(memory.rate, measurement.rate, period)
        momentum = self.momentum.correct(memory.momentum, measurement.speed, measurement.rate)
        # what is known of the moment when the command will act
        ahead, later = rate, momentum
        for k in range(self.delay):
            ahead = self.observer.predict(ahead, memory.under_way[k], period)
            later = self.momentum.predict(later, period)
        turned = measurement.attitude + self.delay * period * rate.rate
        seen = measurement._replace(attitude=turned, rate=ahead.rate)
        law, torque = self.law(memory.law, seen)
        demanded = torque + rate.torque
        speed, sigma = self.momentum.speed(later, ahead.rate)
        # the command is held for a period: its middle counts
        speed = speed + 0.5 * period * momentum.torque / self.momentum.wheel_inertia
        scale = self._learned(memory.scale, rate, momentum, speed, sigma, period)
        friction = scale * self._expected_friction(speed, sigma, demanded)
        parts = demanded / self.motor_constant, friction / self.motor_constant
        wished = parts[0] + parts[1]
        current = jnp.clip(wished, -self.current_limit, self.current_limit)
        law = self.law.within_limit(memory.law, law, wished - current)
        known = friction - self.motor_constant * current
        under_way, acting = pushed(memory.under_way, known)
        memory = EstimatingMemory(
            law,
            self.momentum.predict(momentum, period),
            self.observer.predict(rate, acting, period),
            scale,
            under_way,
        )
        return memory, EstimatingCommand(current, *parts, speed, momentum.torque, scale)

    def predicted(
        self, memory: EstimatingMemory, measurement: Any, command: EstimatingCommand
    ) -> EstimatingMemory:
        """Memory one period later without a sample: both estimates predicted, the rest unchanged.

        Args:
            memory: from the last sample.
            measurement: not used.
            command: that is sent; its friction is that of the last accepted sample.
        """
        period = memory.law.period
        known = self.motor_constant * (command.friction_current - command.current)
        under_way, acting = pushed(memory.under_way, known)
        return EstimatingMemory(
            memory.law,
            self.momentum.predict(memory.momentum, period),
            self.observer.predict(memory.rate, acting, period),
            memory.scale,
            under_way,
        )

    def _expected_friction(self, speed: Scalar, sigma: Scalar, demanded: Scalar) -> Scalar:
        """Friction of the model; near zero speed in the sense of the torque that it resists."""
        breakaway = self.friction.breakaway_torque(jnp.where(demanded < 0.0, -1.0, 1.0))
        stick = jnp.clip(demanded / (self.softness * breakaway), -1.0, 1.0)
        drive = jnp.where(jnp.abs(speed) < self.band * sigma, stick, jnp.sign(speed))
        direction = jnp.where(drive < 0.0, -1.0, 1.0)
        return jnp.abs(drive) * self.friction.torque(direction * jnp.abs(speed), direction)

    def _learned(self, scale, rate, momentum, speed, sigma, period):
        """Friction scale: what the observer finds beyond the external torque is friction."""
        direction = jnp.where(speed < 0.0, -1.0, 1.0)
        model = self.friction.torque(speed, direction)
        missed = (rate.torque - momentum.torque) / model
        turning = jnp.abs(speed) > 2.0 * self.band * sigma
        return jnp.where(
            turning, jnp.clip(scale + self.learning_rate * period * missed, *SCALES), scale
        )
