"""Friction compensation of any number of wheels by a friction model and estimated momenta."""

from typing import Annotated, Any, NamedTuple, Self

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat.control.measured import with_wheel_friction
from gyrostat.control.missing_sample import predicted
from gyrostat.control.recorded import recorded_with
from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.delay_line import empty_line, is_delay, pushed
from gyrostat.core.jax64 import jnp
from gyrostat.estimation import WheelArrayEstimate, WheelArrayFilter
from gyrostat.spacecraft import Spacecraft
from gyrostat.wheel.friction import Friction, static_curve


class EstimatingFeedForwardMemory(NamedTuple):
    """State of the compensator between two samples.

    Attributes:
        controller: Memory of the controller that demands the torques.
        estimate: Estimate of the momenta at the next sample.
        demanded: Momenta that the demanded torques alone would have given the rotors, predicted to
            the time at which the next command acts, (wheels,), N·m·s.
        friction: Friction of the model in the last command, (wheels,), N·m.
        under_way: Motor torques less friction of the model, of delayed commands, (delay, wheels),
            N·m.
        period: Control period, s.
    """

    controller: Any
    estimate: WheelArrayEstimate
    demanded: PerWheel
    friction: PerWheel
    under_way: Float[Array, "delay wheels"]
    period: Scalar


class _Recorded(NamedTuple):
    friction_torque: Annotated[PerWheel, "N·m"]
    estimated_speed: Annotated[PerWheel, "rad/s"]


class EstimatingFeedForward(Checked):
    """Friction feed-forward m = u + F + d + k (h_u - h) for each wheel, on any number of wheels.

    It makes a wheel with friction follow the demanded torque u as a wheel without friction would:

    - F is the torque of the friction model. `WheelArrayFilter` estimates the momentum h of each
      rotor and the friction d that the model does not explain. Their sum is within `largest` times
      the friction of the model.
    - Until d has been found, the wheel loses momentum. The last term returns it: h_u is the
      momentum that u alone would have given the rotor. Its torque is at most the jump of friction
      at zero speed. While the motor is at its limit, h_u follows the wheel (anti-windup).
    - Near zero the sign of the speed is not known. The direction of F is the sum of the speed over
      `band` standard deviations and of the needed torque u + d over `softness` breakaway torques,
      within -1 and 1, as in `EstimatingCompensator`. The variance of d is then at least the square
      of `doubt` breakaway torques, so that the filter follows a jump of friction within a few
      samples.

    A wheel with a demand of exactly zero, such as a failed one, is not compensated. The
    command is recorded with `friction_torque` F + d, N·m, and `estimated_speed`, rad/s, both
    (wheels,).

    Attributes:
        controller: Controller that demands the torques u. It gets the measurement with the field
            `wheel_friction`, the estimated friction of each wheel, (wheels,), N·m.
        friction: Friction model of the wheels in the controller.
        filter: Filter of the momenta.
        torque_limit: Torque limits, (wheels,), N·m.
        gain: Gain k of the returned momentum, 1/s.
        band: Speed at which the compensation is complete without needed torque, in standard
            deviations of the speed.
        softness: Needed torque over breakaway torque at which the compensation at rest is
            complete.
        doubt: Standard deviation of d of a wheel whose direction is not known, over the breakaway
            torque.
        largest: Largest compensated friction torque over that of the model. It keeps a wrong
            estimate, from a sensor that fails, from taking the whole torque of the motor.
        delay: Number of control periods from a sample to the start of its command.
    """

    controller: Any
    friction: Friction
    filter: WheelArrayFilter
    torque_limit: PerWheel
    gain: Annotated[Scalar, size("gain of the returned momentum", "1/s")] = 1.0
    band: Annotated[Scalar, positive("speed band of the compensator")] = 3.0
    softness: Annotated[Scalar, positive("softness of the compensator")] = 0.6
    doubt: Annotated[Scalar, size("doubt of the compensator")] = 0.5
    largest: Annotated[Scalar, positive("largest compensated friction")] = 3.0
    delay: Annotated[int, is_delay] = eqx.field(static=True, default=0)

    @classmethod
    def tune(
        cls,
        controller: Any,
        spacecraft: Spacecraft,
        *,
        speed_sigma: Scalar,
        rate_sigma: Scalar,
        period: Scalar,
        bandwidth: Scalar = 0.6,
        delay: int = 0,
    ) -> Self:
        """Tune the filters to the noise of the sensors.

        Args:
            controller: Controller that demands the torques.
            spacecraft: Spacecraft as the controller knows it.
            speed_sigma: Standard deviation of a tachometer sample, rad/s. For pulses counted over a
                control period, a fifth of the speed of one pulse.
            rate_sigma: Standard deviation of each component of a measured body rate, rad/s.
            period: Control period, s.
            bandwidth: Bandwidth of the friction estimate of a wheel that turns, rad/s.
            delay: Number of control periods from a sample to the start of its command.
        """
        wheels = spacecraft.wheels
        filter = WheelArrayFilter.tune(spacecraft, speed_sigma, rate_sigma, period, bandwidth)
        limit = jnp.ones(wheels.count) * wheels.torque_limit
        return cls(controller, static_curve(wheels.friction), filter, limit, delay=delay)

    # earlier name
    tuned = tune

    def start(self, period: Scalar) -> EstimatingFeedForwardMemory:
        """Initial memory."""
        zero = jnp.zeros(self.filter.axes.shape[-1])
        return EstimatingFeedForwardMemory(
            self.controller.start(period),
            self.filter.start(),
            zero,
            zero,
            empty_line(zero, self.delay),
            jnp.asarray(period, dtype=float),
        )

    def __call__(
        self, memory: EstimatingFeedForwardMemory, measurement: Any
    ) -> tuple[EstimatingFeedForwardMemory, Any]:
        """Compute the wheel torques.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with `attitude` (4,), `rate` (3,), rad/s, `wheel_speed`
                (wheels,), relative to the body, rad/s, `wheel_measured` (wheels,), and the fields
                that the controller needs.
        """
        period, rotor = memory.period, self.filter.rotor_inertia
        estimate = self.filter.correct(memory.estimate, measurement)
        walk = estimate.wheels
        inner_measurement = with_wheel_friction(measurement, memory.friction - walk.torque)
        controller, command = self.controller(memory.controller, inner_measurement)
        demand = command.torque
        # momentum at the time at which the command will act
        ahead = walk.momentum
        for k in range(self.delay):
            ahead = ahead + period * (memory.under_way[k] + walk.torque)
        base_torque = demand - walk.torque
        breakaway = self.friction.breakaway_torque(jnp.where(base_torque < 0.0, -1.0, 1.0))
        deficit = jnp.where(memory.estimate.begun(), memory.demanded - ahead, 0.0)
        # k times it is at most the jump of friction at zero speed
        largest = 2.0 * breakaway / jnp.maximum(self.gain, 1e-300)
        deficit = jnp.clip(deficit, -largest, largest)
        # the command is held for a period, so the speed at its middle is used
        speed = (ahead + 0.5 * period * demand) / rotor - self.filter.axes.T @ measurement.rate
        certainty = speed * rotor / (self.band * jnp.sqrt(walk.momentum_variance))
        share = base_torque / jnp.maximum(self.softness * breakaway, 1e-300)
        # limited, so that a large demand does not outweigh a speed of certain sign
        drive = jnp.clip(share, -2.0, 2.0) + certainty
        direction = jnp.where(drive < 0.0, -1.0, 1.0)
        model = self.friction.torque(direction * jnp.abs(speed), direction)
        friction = jnp.minimum(jnp.abs(drive), 1.0) * model
        bound = self.largest * jnp.maximum(jnp.abs(model), breakaway)
        friction_torque = jnp.clip(friction - walk.torque, -bound, bound)
        correction = friction_torque + self.gain * deficit
        torque = jnp.clip(demand + correction, -self.torque_limit, self.torque_limit)
        torque = jnp.where(demand == 0.0, 0.0, torque)
        target = jnp.where(demand == 0.0, ahead, ahead + deficit + period * (torque - correction))
        unsure = 1.0 - jnp.minimum(jnp.abs(certainty), 1.0) ** 2
        variance = jnp.maximum(walk.torque_variance, unsure * (self.doubt * breakaway) ** 2)
        estimate = estimate._replace(wheels=walk._replace(torque_variance=variance))
        under_way, acting = pushed(memory.under_way, torque - friction)
        next_memory = EstimatingFeedForwardMemory(
            controller,
            self.filter.predict(estimate, acting, period),
            target,
            friction,
            under_way,
            period,
        )
        command = command._replace(torque=torque)
        return next_memory, recorded_with("Estimating", command, _Recorded(friction_torque, speed))

    def predicted(
        self, memory: EstimatingFeedForwardMemory, measurement: Any, command: Any
    ) -> EstimatingFeedForwardMemory:
        """Memory after a period without a sample: the estimates are predicted.

        Args:
            memory: Memory from the last sample.
            measurement: Last accepted measurement.
            command: Safe command that is sent.
        """
        net, period = command.torque - memory.friction, memory.period
        under_way, acting = pushed(memory.under_way, net)
        return memory._replace(
            controller=predicted(self.controller, memory.controller, measurement, command),
            estimate=self.filter.predict(memory.estimate, acting, period),
            # no momentum is lost to the safe command
            demanded=memory.demanded + period * (net + memory.estimate.wheels.torque),
            under_way=under_way,
        )
