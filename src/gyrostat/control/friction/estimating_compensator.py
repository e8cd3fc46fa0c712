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
"""Natural frequency of the momentum filter in `EstimatingCompensator.tune`, rad/s."""
BANDWIDTH = 6.0
"""Bandwidth of the rate observer in `EstimatingCompensator.tune`, rad/s."""
SLOWER = 3.0
"""Bandwidth of the observer over that of the rate loop."""
SCALES = (0.3, 3.0)
"""Lower and upper limit of the friction scale."""


class EstimatingMemory(NamedTuple):
    """State of the compensator between two samples.

    Attributes:
        law: Memory of the attitude law.
        momentum: Momentum estimate at the next sample.
        rate: Rate estimate at the next sample.
        scale: Friction of the wheel over friction of the model.
        undisturbed: Rate that the torque of the attitude law alone would give, predicted to the
            time at which the next command acts, rad/s.
        under_way: Known torques on the table from delayed commands, (delay,), N·m.
    """

    law: PIDMemory
    momentum: MomentumEstimate
    rate: RateEstimate
    scale: Float[Array, ""]
    undisturbed: Scalar
    under_way: Float[Array, " delay"]


class EstimatingCommand(NamedTuple):
    """Motor current command, its two terms and the estimates behind them.

    Attributes:
        current: Motor current after the limit, A.
        attitude_current: Current for the torque that attitude law, observer and rate loop demand,
            A.
        friction_current: Current for the expected friction, A.
        estimated_speed: Predicted speed of the wheel in the middle of the control period in which
            the command acts, rad/s.
        estimated_torque: External torque, N·m.
        friction_scale: Friction of the wheel over friction of the model.
    """

    current: Annotated[Scalar, "A"]
    attitude_current: Annotated[Scalar, "A"]
    friction_current: Annotated[Scalar, "A"]
    estimated_speed: Annotated[Scalar, "rad/s"]
    estimated_torque: Annotated[Scalar, "N·m"]
    friction_scale: Annotated[Scalar, "1"]


class EstimatingCompensator(Checked):
    """Friction compensation by a friction model at estimated speed, with adapted scale.

    - The speed estimate comes from the momentum of wheel and table, which friction does not change.
    - An observer of the table rate estimates the torque that the model does not explain, and the
      demanded torque cancels it. The part beyond the external torque of the momentum filter is
      friction; it adapts the scale of the friction model while the wheel turns.
    - Until the observer has found a jump dF of friction, the table takes up the angular momentum
      2 dF / bandwidth. A rate loop returns it: it holds the table to the undisturbed rate, which
      the torque of the attitude law alone would have given. Its torque is at most the jump of
      friction at zero speed. While the motor is saturated, the undisturbed rate follows the table
      (anti-windup by tracking; K. J. Åström and T. Hägglund, PID Controllers, section 3.5).
    - Near zero the sign of the speed is not known, and compensation by that sign could hold the
      wheel at rest. The direction of the compensation is therefore the sum of the speed over its
      uncertainty and of the needed torque over the breakaway torque, within -1 and 1. A small
      demand at rest gets only a part of the breakaway torque, so that there is no limit cycle.

    `tune` makes a compensator from a wheel model and the noise of its tachometer.

    Attributes:
        law: Attitude law, which gives the demanded wheel torque.
        friction: Friction model of the controller.
        motor_constant: Motor constant assumed by the controller, N·m/A.
        momentum: Momentum filter, which gives the wheel speed.
        observer: Observer of the table rate and of the unexplained torque.
        learning_rate: Adaptation rate of the friction scale, 1/s.
        band: Speed at which the compensation is complete without needed torque, in standard
            deviations of the speed. From three times this speed on, only the speed decides.
        softness: Needed torque over breakaway torque at which the compensation at rest is
            complete.
        current_limit: Limit of the motor current, A.
        delay: Number of control periods from a sample to the start of its command.
    """

    law: AttitudePID
    friction: Friction
    motor_constant: Annotated[Scalar, positive("motor_constant")]
    momentum: WheelMomentumFilter
    observer: RateObserver
    learning_rate: Scalar = 0.1
    band: Scalar = 3.0
    softness: Scalar = 0.6
    current_limit: Scalar = np.inf
    delay: int = eqx.field(static=True, default=0)

    @classmethod
    def design(
        cls,
        wheel: Wheel,
        *,
        table_inertia: Scalar,
        frequency: Scalar,
        speed_sigma: Scalar,
        period: Scalar,
        bandwidth: Scalar = BANDWIDTH,
        current_limit: Scalar = np.inf,
        delay: int = 0,
    ) -> "EstimatingCompensator":
        """Design the attitude law by `AttitudePID.design` and the filters by `tune`.

        Args:
            wheel: Identified wheel.
            table_inertia: Inertia of the body that the wheel turns, without its rotor, kg·m².
            frequency: Natural frequency of the attitude loop, rad/s.
            speed_sigma: Standard deviation of a tachometer sample, rad/s; see `tune`.
            period: Control period, s.
            bandwidth: Bandwidth of the rate observer, rad/s.
            current_limit: Limit of the motor current, A.
            delay: Number of control periods from a sample to the start of its command.
        """
        return cls.tune(
            AttitudePID.design(table_inertia, frequency),
            wheel,
            table_inertia,
            speed_sigma,
            period,
            bandwidth=bandwidth,
            current_limit=current_limit,
            delay=delay,
        )

    @classmethod
    def tune(
        cls,
        law: AttitudePID,
        wheel: Wheel,
        table_inertia: Scalar,
        speed_sigma: Scalar,
        period: Scalar,
        *,
        bandwidth: Scalar = BANDWIDTH,
        current_limit: Scalar = np.inf,
        delay: int = 0,
    ) -> "EstimatingCompensator":
        """Tune the filters by simple rules.

        The momentum filter has the natural frequency `MOMENTUM_FREQUENCY`, which is (q / r)^(1/4)
        for a random walk in torque of density q and a measured momentum of density r. The observer
        is as fast as control rate, delay and gyro noise allow: 6 rad/s at 10 Hz with one or two
        periods of delay. The rate loop is `SLOWER` times slower than the observer.

        Args:
            law: Attitude law.
            wheel: Identified wheel.
            table_inertia: Inertia of the body that the wheel turns, without its rotor, kg·m².
            speed_sigma: Standard deviation of a tachometer sample, rad/s. For pulses counted over a
                gate time, half the speed of one pulse is more than enough, and a fifth is best.
            period: Control period, s.
            bandwidth: Bandwidth of the rate observer, rad/s.
            current_limit: Limit of the motor current, A.
            delay: Number of control periods from a sample to the start of its command.
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

    # earlier names
    designed = design
    tuned = tune

    def start(self, period: Scalar) -> EstimatingMemory:
        """Initial memory."""
        return EstimatingMemory(
            self.law.start(period),
            self.momentum.start(),
            self.observer.start(),
            jnp.array(1.0),
            jnp.array(0.0),
            empty_line(jnp.zeros(()), self.delay),
        )

    def __call__(
        self, memory: EstimatingMemory, measurement: Any
    ) -> tuple[EstimatingMemory, EstimatingCommand]:
        """Compute the current command.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with attitude, rate and wheel `speed`, rad/s.
        """
        period = memory.law.period
        rate = self.observer.correct(memory.rate, measurement.rate, period)
        momentum = self.momentum.correct(memory.momentum, measurement.speed, measurement.rate)
        # prediction to the time at which the command will act
        ahead, later = rate, momentum
        for k in range(self.delay):
            ahead = self.observer.predict(ahead, memory.under_way[k], period)
            later = self.momentum.predict(later, period)
        attitude = measurement.attitude + self.delay * period * rate.rate
        prediction = measurement._replace(attitude=attitude, rate=ahead.rate)
        law, torque = self.law(memory.law, prediction)
        base_torque = torque + rate.torque
        breakaway = self.friction.breakaway_torque(jnp.where(base_torque < 0.0, -1.0, 1.0))
        gain = self.observer.inertia * self.observer.bandwidth / SLOWER
        # the rate by which the rate loop demands the jump of friction at zero speed
        jump = 2.0 * breakaway / gain
        rate_excess = jnp.clip(ahead.rate - memory.undisturbed, -jump, jump)
        demanded = base_torque + gain * rate_excess
        speed, sigma = self.momentum.speed(later, ahead.rate)
        # the command is held for a period, so the speed at its middle is used
        speed = speed + 0.5 * period * momentum.torque / self.momentum.wheel_inertia
        # limited, so that a large demand does not outweigh a speed of certain sign
        share = jnp.clip(base_torque / (self.softness * breakaway), -2.0, 2.0)
        drive = share + speed / (self.band * sigma)
        direction = jnp.where(drive < 0.0, -1.0, 1.0)
        model = self.friction.torque(direction * jnp.abs(speed), direction)
        error = (rate.torque - momentum.torque) / model
        # beyond 4 the wheel turns, whatever the demand
        change = jnp.where(jnp.abs(drive) > 4.0, self.learning_rate * period * error, 0.0)
        scale = jnp.clip(memory.scale + change, *SCALES)
        friction = scale * jnp.minimum(jnp.abs(drive), 1.0) * model
        parts = demanded / self.motor_constant, friction / self.motor_constant
        demand = parts[0] + parts[1]
        current = jnp.clip(demand, -self.current_limit, self.current_limit)
        law = self.law.within_limit(memory.law, law, demand - current)
        table_torque = friction - self.motor_constant * current
        under_way, acting = pushed(memory.under_way, table_torque)
        undisturbed = RateEstimate(ahead.rate - rate_excess, demanded - torque)
        memory = EstimatingMemory(
            law,
            self.momentum.predict(momentum, period),
            self.observer.predict(rate, acting, period),
            scale,
            self.observer.predict(undisturbed, table_torque, period).rate,
            under_way,
        )
        return memory, EstimatingCommand(current, *parts, speed, momentum.torque, scale)

    def predicted(
        self, memory: EstimatingMemory, measurement: Any, command: EstimatingCommand
    ) -> EstimatingMemory:
        """Memory after a period without a sample: the estimates are predicted.

        Args:
            memory: Memory from the last sample.
            measurement: Unused.
            command: Safe command that is sent; its friction term is from the last accepted
                sample.
        """
        period = memory.law.period
        table_torque = self.motor_constant * (command.friction_current - command.current)
        under_way, acting = pushed(memory.under_way, table_torque)
        undisturbed = RateEstimate(memory.undisturbed, memory.rate.torque)
        return memory._replace(
            momentum=self.momentum.predict(memory.momentum, period),
            rate=self.observer.predict(memory.rate, acting, period),
            undisturbed=self.observer.predict(undisturbed, table_torque, period).rate,
            under_way=under_way,
        )
