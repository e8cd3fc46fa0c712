"""Two-wheel pointing with torque limits, total momentum and model error compensation."""

from typing import Annotated, Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from gyrostat.control.adaptive.conditioned_compensator import (
    ConditionedCompensator,
    ConditionedMemory,
)
from gyrostat.control.adaptive.model_error_compensator import Integrators
from gyrostat.control.adaptive.safe_frit import SafeFrit, SafeFritMemory
from gyrostat.control.underactuated.boresight import BoresightLaw, Pair, WheelMap, governed
from gyrostat.control.underactuated.output_zeroing import check_two_wheels
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked, positive, positive_share, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import error, rotation_vector, to_body, to_inertial
from gyrostat.estimation import (
    RotorScaleEstimate,
    RotorScaleFilter,
    SteadyAttitudeEstimate,
    SteadyAttitudeFilter,
)
from gyrostat.spacecraft import Spacecraft

COMPENSATOR = ConditionedCompensator(Integrators())


class PointingCommand(NamedTuple):
    """Wheel speed command, and the signals behind it.

    Attributes:
        speed: Commanded wheel speeds relative to the body, (2,), rad/s.
        share: Fraction of the demanded speed change that the torque governor allowed.
        model_error: Rotation of the nominal model about body x and y minus that of the body, (2,),
            rad.
        compensator_gain: Gain in use, (2,), 1/s.
    """

    speed: Annotated[Pair, "rad/s"]
    share: Annotated[Scalar, "1"]
    model_error: Annotated[Pair, "rad"]
    compensator_gain: Annotated[Pair, "1/s"]


class PointingMemory(NamedTuple):
    """State of the controller between two samples.

    Attributes:
        estimate: Attitude estimate.
        momentum: Estimate of the total momentum in inertial axes, (3,), N·m·s, or of momentum and
            rotor inertias.
        speed: Last commanded wheel speeds, (2,), rad/s.
        acting: Body rates about x and y from momentum and measured wheel speeds, (2,), rad/s.
        turned: Angles about body x and y since the start, (2,), rad.
        compensator: Memory of the compensator.
        tuning: State of the gain tuner; None if the gain is fixed.
        cut: Whether the governor limited the last command.
        period: Control period, s.
    """

    estimate: SteadyAttitudeEstimate
    momentum: Vector3 | RotorScaleEstimate
    speed: Pair
    acting: Pair
    turned: Pair
    compensator: ConditionedMemory
    tuning: SafeFritMemory | None
    cut: Bool[Array, ""]
    period: Scalar


class TwoWheelPointing(Checked):
    """Boresight pointing of body z to an inertial direction, by the speeds of two wheels.

    The body rates about x and y follow from total momentum and wheel speeds (`WheelMap`), so that
    wheel speeds command them. `BoresightLaw` gives the rates. A governor scales the speed changes
    of both wheels by one factor, so that neither wheel exceeds its torque. Momentum and true rotor
    inertias are estimated from measured rate and wheel speeds (`RotorScaleFilter`). Errors of
    momentum, inertia and gyro bias remain as a slowly varying rate error. A compensator
    estimates it from the estimated rotation about x and y, whose rate the nominal model gives from
    the measured wheel speeds. This is a controller of the loop.

    Attributes:
        spacecraft: Model of body and two wheels in the controller.
        law: Boresight law, which gives the body rates.
        filter: Filter of attitude and gyro bias.
        momentum_time: Time constant of the momentum filter, s.
        rotor_sigma: Relative standard deviation of the rotor inertias of the model. The controller
            then estimates them with the momentum (`RotorScaleFilter`); None: it trusts them.
        gain: Fixed gain of the compensator, (2,), 1/s; unused if there is a tuner.
        torque_share: Fraction of the wheels' torque that the governor allows for speed changes; the
            rest is for friction and for rotors heavier than those of the model.
        tuner: Tuner that gives the gain on line; None for a fixed gain.
        along: Target direction of body z, a unit vector in inertial axes, (3,).
    """

    spacecraft: Spacecraft
    law: BoresightLaw = BoresightLaw()
    filter: SteadyAttitudeFilter = SteadyAttitudeFilter()
    momentum_time: Annotated[Scalar, positive("momentum time", "s")] = 30.0
    rotor_sigma: Scalar | None = 0.05
    gain: Annotated[Pair, size("compensator gain", "1/s")] = eqx.field(
        default_factory=lambda: np.full(2, 0.05)
    )
    torque_share: Annotated[Scalar, positive_share("torque share")] = 0.93
    tuner: SafeFrit | None = None
    along: Vector3 = eqx.field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))

    def check_own(self) -> None:
        """Validate wheels and direction.

        Raises:
            InputError: See `check_two_wheels`; also if a wheel has no torque limit, or if the
                direction is not a unit vector.
        """
        check_two_wheels("two-wheel pointing", self.spacecraft)
        rotors = self._rotors()
        if rotors is not None:
            rotors.check()
        limit = np.asarray(self.spacecraft.wheels.torque_limit)
        if not np.all(np.isfinite(limit)):
            raise InputError(f"two-wheel pointing: found a torque limit of {limit}, expected N·m")
        length = np.linalg.norm(np.asarray(self.along, dtype=float), axis=-1)
        # comparisons with NaN are false
        if not np.all(np.abs(length - 1.0) < 1e-6):
            raise InputError(f"pointing direction: found {self.along}, expected a unit vector")

    def check_own_period(self, period: float) -> None:
        """Check that the compensator is stable at a control period, s.

        Raises:
            InputError: The gain is 2 / period or more.
        """
        highest = self.gain if self.tuner is None else self.tuner.highest
        gain = float(np.max(np.asarray(highest)))
        if gain >= 2.0 / period:
            raise InputError(
                f"compensator gain: found {gain:g} 1/s at a control period of {period:g} s, "
                f"expected below {2.0 / period:g} 1/s: it would diverge"
            )

    def start(self, period: Scalar) -> PointingMemory:
        """Initial memory."""
        zero, rotors = jnp.zeros(2), self._rotors()
        return PointingMemory(
            estimate=self.filter.start(),
            momentum=jnp.zeros(3) if rotors is None else rotors.start(),
            speed=zero,
            acting=zero,
            turned=zero,
            compensator=COMPENSATOR.start(zero),
            tuning=None if self.tuner is None else self.tuner.start(zero),
            cut=jnp.array(False),
            period=jnp.asarray(period, dtype=float),
        )

    def _rotors(self) -> RotorScaleFilter | None:
        if self.rotor_sigma is None:
            return None
        return RotorScaleFilter(self.spacecraft, self.momentum_time, rotor_sigma=self.rotor_sigma)

    def _momentum(
        self, memory: PointingMemory, estimate: SteadyAttitudeEstimate, speed: Pair
    ) -> tuple[Vector3 | RotorScaleEstimate, Vector3, Pair | float]:
        """Memory of the momentum, the momentum in body axes, N·m·s, and the rotors' scales."""
        attitude, rate, period = estimate.attitude, estimate.rate, memory.period
        previous, rotors = memory.momentum, self._rotors()
        if isinstance(previous, RotorScaleEstimate):
            assert rotors is not None
            update = rotors(previous, attitude, rate, speed, period)
            return update, to_body(attitude, update.momentum), update.scale
        wheels = self.spacecraft.wheels
        wheel_momentum = jnp.asarray(wheels.axes) @ (wheels.inertia * speed)
        sample = to_inertial(attitude, self.spacecraft.inertia_locked() @ rate + wheel_momentum)
        share = period / (self.momentum_time + period)
        share = jnp.where(memory.estimate.begun, share, 1.0)
        update = previous + share * (sample - previous)
        return update, to_body(attitude, update), 1.0

    def _compensate(self, memory: PointingMemory, acting: Pair, turn: Pair) -> PointingMemory:
        """Memory with the compensator updated at this sample."""
        mean_rate = 0.5 * (memory.acting + acting)
        angles, tuning, gain = memory.turned + turn, memory.tuning, jnp.asarray(self.gain)
        if self.tuner is not None and tuning is not None:
            tuning = self.tuner(
                tuning,
                error=memory.compensator.error,
                input=mean_rate,
                output=memory.turned,
                cut=memory.cut,
                period=memory.period,
            )
            gain = tuning.gain
        compensator = COMPENSATOR(memory.compensator, mean_rate, angles, gain, memory.period)
        update = memory._replace(turned=angles, tuning=tuning, compensator=compensator)
        # at the first sample there is neither rotation nor input yet
        return jax.tree.map(lambda a, b: jnp.where(memory.estimate.begun, a, b), update, memory)

    def __call__(
        self, memory: PointingMemory, measurement: Any
    ) -> tuple[PointingMemory, PointingCommand]:
        """Compute the wheel speed command.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with `attitude` (4,), `rate` (3,), rad/s, and `wheel_speed`
                (2,), rad/s.
        """
        wheels, period = self.spacecraft.wheels, memory.period
        speed = measurement.wheel_speed
        estimate = self.filter(memory.estimate, measurement.attitude, measurement.rate, period)
        attitude = estimate.attitude
        momentum_memory, momentum, scale = self._momentum(memory, estimate, speed)
        map = WheelMap.of(self.spacecraft, scale)
        acting = map.rate(momentum, speed)
        turn = rotation_vector(error(attitude, memory.estimate.attitude))[:2]
        memory = self._compensate(memory, acting, turn)
        fastest = jnp.broadcast_to(wheels.momentum_limit / wheels.inertia, (2,))
        quickest = jnp.broadcast_to(self.torque_share * wheels.torque_limit / wheels.inertia, (2,))
        resting = map.speed(momentum, jnp.zeros(2))
        along = to_body(attitude, jnp.asarray(self.along))
        rate = self.law(along, resting, map, (quickest, fastest))
        target_speed = map.speed(momentum, rate + memory.compensator.correction)
        previous_speed = jnp.where(memory.estimate.begun, memory.speed, speed)
        target_speed = jnp.clip(target_speed, -fastest, fastest)
        command, share = governed(previous_speed, target_speed, quickest * period)
        next_memory = memory._replace(
            estimate=estimate,
            momentum=momentum_memory,
            speed=command,
            acting=acting,
            cut=share < 1.0,
        )
        tuning = next_memory.tuning
        gain = jnp.asarray(self.gain) if tuning is None else tuning.gain
        return next_memory, PointingCommand(command, share, next_memory.compensator.error, gain)
