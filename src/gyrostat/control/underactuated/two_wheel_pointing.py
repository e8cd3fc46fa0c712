"""Two-wheel pointing with torque limits, momentum and error compensation."""

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
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive, positive_share, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import error, rotation_vector, to_body, to_inertial
from gyrostat.estimation import SteadyAttitudeEstimate, SteadyAttitudeFilter
from gyrostat.spacecraft import Spacecraft

COMPENSATOR = ConditionedCompensator(Integrators())


class PointingCommand(NamedTuple):
    """Wheel speeds, and how they came about.

    Attributes:
        speed: (2,) of the wheels relative to the body, rad/s.
        share: of the way to what the law wanted that the governor let go.
        model_error: (2,) turn about body x and y that the nominal model has made more than the
            body, rad.
        compensator_gain: (2,) in use, 1/s.
    """

    speed: Annotated[Pair, "rad/s"]
    share: Annotated[Scalar, "1"]
    model_error: Annotated[Pair, "rad"]
    compensator_gain: Annotated[Pair, "1/s"]


class PointingMemory(NamedTuple):
    """Between two samples.

    Attributes:
        estimate: of the attitude.
        momentum: (3,) estimate of the total, inertial axes, N·m·s.
        speed: (2,) last command, rad/s.
        acting: (2,) body rates that momentum and measured wheel speeds make, rad/s.
        turned: (2,) about body x and y since the start, rad.
        compensator: of the compensator.
        tuning: of its gain; None where it is fixed.
        cut: whether the governor cut the last command.
        period: of control, s.
    """

    estimate: SteadyAttitudeEstimate
    momentum: Vector3
    speed: Pair
    acting: Pair
    turned: Pair
    compensator: ConditionedMemory
    tuning: SafeFritMemory | None
    cut: Bool[Array, ""]
    period: Scalar


class TwoWheelPointing(Checked):
    """Leads body z to a direction fixed in space by two wheels that take commanded speeds.

    The body rates about x and y follow from total momentum and wheel speeds (`WheelMap`), so wheel
    speeds command them. `BoresightLaw` says which; a governor scales the change of both wheels
    alike, so that neither needs more than its torque. The momentum, from measured rate and wheel
    speeds, passes a slow filter in inertial axes. What is left, of momentum, inertia and gyro
    bias, is a slow rate error: a compensator learns it from the estimated turn about x and y,
    whose rate the nominal model gives from the measured wheel speeds. A controller of the loop.

    Attributes:
        spacecraft: body and two wheels, as the controller knows them.
        law: how fast to turn.
        filter: of attitude and gyro bias.
        momentum_time: time constant of the momentum's filter, s.
        gain: (2,) of the compensator, 1/s; not used where a tuner is given.
        torque_share: of the wheels' torque, that the governor lets a change of speed need; the
            rest is for friction.
        tuner: that gives the gain on line; None for none.
        along: (3,) unit vector that body z is led to, inertial axes.
    """

    spacecraft: Spacecraft
    law: BoresightLaw = BoresightLaw()
    filter: SteadyAttitudeFilter = SteadyAttitudeFilter()
    momentum_time: Annotated[Scalar, positive("momentum time", "s")] = 30.0
    gain: Annotated[Pair, size("compensator gain", "1/s")] = eqx.field(
        default_factory=lambda: np.full(2, 0.05)
    )
    torque_share: Annotated[Scalar, positive_share("torque share")] = 0.98
    tuner: SafeFrit | None = None
    along: Vector3 = eqx.field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))

    def check_own(self) -> None:
        """Validate wheels and direction.

        Raises:
            InputError: See `check_two_wheels`; wheels without a torque limit, a direction that is
                no unit vector.
        """
        check_two_wheels("two-wheel pointing", self.spacecraft)
        limit = np.asarray(self.spacecraft.wheels.torque_limit)
        if not np.all(np.isfinite(limit)):
            raise InputError(f"two-wheel pointing: found a torque limit of {limit}, expected N·m")
        length = np.linalg.norm(np.asarray(self.along, dtype=float), axis=-1)
        # comparisons with NaN are false
        if not np.all(np.abs(length - 1.0) < 1e-6):
            raise InputError(f"pointing direction: found {self.along}, expected a unit vector")

    def check_own_period(self, period: float) -> None:
        """Refuse a gain beyond which the compensator is unstable at a control period, s.

        Raises:
            InputError: 2 / period or more.
        """
        highest = self.gain if self.tuner is None else self.tuner.highest
        found = float(np.max(np.asarray(highest)))
        if found >= 2.0 / period:
            raise InputError(
                f"compensator gain: found {found:g} 1/s at a control period of {period:g} s, "
                f"expected below {2.0 / period:g} 1/s: it would diverge"
            )

    def start(self, period: Scalar) -> PointingMemory:
        """Memory before the first measurement."""
        none = jnp.zeros(2)
        return PointingMemory(
            estimate=self.filter.start(),
            momentum=jnp.zeros(3),
            speed=none,
            acting=none,
            turned=none,
            compensator=COMPENSATOR.start(none),
            tuning=None if self.tuner is None else self.tuner.start(none),
            cut=jnp.array(False),
            period=jnp.asarray(period, dtype=float),
        )

    def _momentum(self, memory: PointingMemory, attitude: Quaternion, rate, wheels) -> Vector3:
        rotors = jnp.asarray(self.spacecraft.wheels.axes) @ wheels
        measured = to_inertial(attitude, self.spacecraft.inertia_locked() @ rate + rotors)
        share = memory.period / (self.momentum_time + memory.period)
        share = jnp.where(memory.estimate.begun, share, 1.0)
        return memory.momentum + share * (measured - memory.momentum)

    def _compensated(self, memory: PointingMemory, acting: Pair, turn: Pair) -> PointingMemory:
        """Memory with the compensator at this sample."""
        given = 0.5 * (memory.acting + acting)
        turned, tuning, gain = memory.turned + turn, memory.tuning, jnp.asarray(self.gain)
        if self.tuner is not None and tuning is not None:
            tuning = self.tuner(
                tuning,
                error=memory.compensator.error,
                input=given,
                output=memory.turned,
                cut=memory.cut,
                period=memory.period,
            )
            gain = tuning.gain
        compensator = COMPENSATOR(memory.compensator, given, turned, gain, memory.period)
        after = memory._replace(turned=turned, tuning=tuning, compensator=compensator)
        # before the first sample there was neither turn nor input
        return jax.tree.map(lambda a, b: jnp.where(memory.estimate.begun, a, b), after, memory)

    def __call__(
        self, memory: PointingMemory, measurement: Any
    ) -> tuple[PointingMemory, PointingCommand]:
        """Command wheel speeds.

        Args:
            memory: from the last sample.
            measurement: has `attitude` (4,), `rate` (3,), rad/s, and `wheel_speed` (2,), rad/s.
        """
        wheels, period = self.spacecraft.wheels, memory.period
        speed = measurement.wheel_speed
        estimate = self.filter(memory.estimate, measurement.attitude, measurement.rate, period)
        attitude = estimate.attitude
        inertial = self._momentum(memory, attitude, estimate.rate, wheels.inertia * speed)
        momentum, map = to_body(attitude, inertial), WheelMap.of(self.spacecraft)
        acting = map.rate(momentum, speed)
        turn = rotation_vector(error(attitude, memory.estimate.attitude))[:2]
        memory = self._compensated(memory, acting, turn)
        fastest = jnp.broadcast_to(wheels.momentum_limit / wheels.inertia, (2,))
        quickest = jnp.broadcast_to(self.torque_share * wheels.torque_limit / wheels.inertia, (2,))
        resting = map.speed(momentum, jnp.zeros(2))
        along = to_body(attitude, jnp.asarray(self.along))
        rate = self.law(along, resting, map, (quickest, fastest))
        wanted = map.speed(momentum, rate + memory.compensator.correction)
        before = jnp.where(memory.estimate.begun, memory.speed, speed)
        wanted = jnp.clip(wanted, -fastest, fastest)
        commanded, share = governed(before, wanted, quickest * period)
        after = memory._replace(
            estimate=estimate,
            momentum=inertial,
            speed=commanded,
            acting=acting,
            cut=share < 1.0,
        )
        tuning = after.tuning
        gain = jnp.asarray(self.gain) if tuning is None else tuning.gain
        return after, PointingCommand(commanded, share, after.compensator.error, gain)
