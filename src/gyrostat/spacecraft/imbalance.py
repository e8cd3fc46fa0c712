"""Static and dynamic wheel imbalance, and the jitter that it causes."""

from typing import Annotated, Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import PerWheel, Scalar, Vector3
from gyrostat.core.checked import Checked, signed, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.core.rotations import from_rotation_vector, product
from gyrostat.spacecraft.gyrostat import Gyrostat
from gyrostat.spacecraft.gyrostat_state import GyrostatRecord, GyrostatState
from gyrostat.spacecraft.spacecraft import Spacecraft
from gyrostat.wheel.array import listed


class Imbalance(Checked):
    """Static imbalance U_s and dynamic imbalance U_d of every wheel.

    They cause a force U_s W² and a torque U_d W² that rotate with the rotor, where W is the wheel
    speed: the fundamental harmonic of R. A. Masterson, D. W. Miller, R. L. Grogan, "Development and
    validation of reaction wheel disturbance models", Journal of Sound and Vibration 249 (2002).

    Attributes:
        static: Static imbalance U_s, mass times eccentricity, (wheels,), kg·m.
        dynamic: Dynamic imbalance U_d, product of inertia, (wheels,), kg·m².
        position: Wheel positions from the centre of mass, body axes, (3, wheels), m.
    """

    static: Annotated[PerWheel, size("static imbalance", "kg·m")] = eqx.field(converter=listed)
    dynamic: Annotated[PerWheel, size("dynamic imbalance", "kg·m²")] = eqx.field(converter=listed)
    position: Annotated[Float[Array, "3 wheels"], signed("size of a wheel's position", "m")] = (
        eqx.field(converter=listed)
    )

    def loads(self, axes: Any, speed: PerWheel, angle: PerWheel) -> tuple[Vector3, Vector3]:
        """Force, N, and torque about the centre of mass, N·m, on the body, in body axes.

        Args:
            axes: Spin axes, (3, wheels).
            speed: Wheel speeds relative to the body, (wheels,), rad/s.
            angle: Rotor angles, (wheels,), rad.
        """
        radial, tangent = _turning(axes, angle)
        force = self.static * speed**2 * radial
        arm = jnp.cross(jnp.asarray(self.position), force, axis=0)
        torque = arm - self.dynamic * speed**2 * tangent
        return jnp.sum(force, axis=1), jnp.sum(torque, axis=1)

    def jitter(self, spacecraft: Spacecraft, angle: PerWheel) -> Vector3:
        """Rotation vector of the jitter, (3,), rad; it depends on the rotor angles only.

        Args:
            spacecraft: Spacecraft with these wheels.
            angle: Rotor angles, (wheels,), rad.
        """
        radial, tangent = _turning(spacecraft.wheels.axes, angle)
        return self._turned(spacecraft, radial, tangent)

    def jitter_rate(self, spacecraft: Spacecraft, speed: PerWheel, angle: PerWheel) -> Vector3:
        """Time derivative of `jitter`, (3,), rad/s."""
        radial, tangent = _turning(spacecraft.wheels.axes, angle)
        return self._turned(spacecraft, speed * tangent, -speed * radial)

    def peak(self, spacecraft: Spacecraft) -> Vector3:
        """Largest jitter about each body axis, (3,), rad; all wheels at their worst phase."""
        none = jnp.zeros(spacecraft.wheels.count)

        def size(own: PerWheel) -> Vector3:
            alone = Imbalance(self.static * own, self.dynamic * own, self.position)
            quarter = alone.jitter(spacecraft, none + jnp.pi / 2.0)
            return jnp.hypot(alone.jitter(spacecraft, none), quarter)

        return jnp.sum(jax.vmap(size)(jnp.eye(len(none))), axis=0)

    def _turned(self, spacecraft: Spacecraft, radial: Any, tangent: Any) -> Vector3:
        arm = jnp.cross(jnp.asarray(self.position), self.static * radial, axis=0)
        inverse = inverse_definite(jnp.asarray(spacecraft.inertia))
        return inverse @ jnp.sum(self.dynamic * tangent - arm, axis=1)


def _turning(axes: Any, angle: PerWheel) -> tuple[Any, Any]:
    """Radial unit vectors that rotate with the rotors, and those 90° ahead, (3, wheels) each."""
    axes = jnp.asarray(axes)
    # the body axis farthest from the spin axis is never parallel to it
    x, y, z = jnp.abs(axes)
    by_x = (x <= y) & (x <= z)
    by_y = ~by_x & (y <= z)
    least = jnp.stack([by_x, by_y, ~by_x & ~by_y]).astype(float)
    first = jnp.cross(least, axes, axis=0)
    first = first / jnp.sqrt(jnp.sum(first**2, axis=0))
    second = jnp.cross(axes, first, axis=0)
    cosine, sine = jnp.cos(angle), jnp.sin(angle)
    return cosine * first + sine * second, cosine * second - sine * first


class ImbalancedGyrostat(Checked):
    """Gyrostat with imbalanced wheels, which cause jitter of the body.

    The momentum of an imbalance, W p(angle), is part of the total momentum. The body rate therefore
    contains the term -J^-1 W p(angle). W is the derivative of the angle, so the integral of this
    term is a function of the angle alone. The jitter is added in closed form to the motion with
    balanced wheels; the relative error is of the order of body rate over wheel speed. Nothing is
    sampled or integrated at the wheel frequency, so imbalance does not limit the control period.
    Flexible modes do not follow the jitter: J is the inertia without that of the modes, and no mode
    is excited. This holds for wheel speeds W well above the frequencies of the modes on the free
    body; the relative error is of the order of their squared ratio, and resonance is not modelled.
    Measurements contain the jitter at their time; an integrating gyro measures its mean rate.

    Attributes:
        gyrostat: Gyrostat with balanced wheels.
        imbalance: Imbalance of its wheels.
    """

    gyrostat: Gyrostat
    imbalance: Imbalance

    @property
    def spacecraft(self) -> Spacecraft:
        """Body and wheels."""
        return self.gyrostat.spacecraft

    @property
    def failures(self) -> Any:
        """Wheel failures; see `Gyrostat`."""
        return self.gyrostat.failures

    def check_own(self) -> None:
        """Validate shapes.

        Raises:
            InputError: The imbalance has another number of wheels.
        """
        count = self.spacecraft.wheels.count
        for name in ("static", "dynamic", "position"):
            found = np.shape(getattr(self.imbalance, name))[-1:]
            if found != (count,):
                raise InputError(f"imbalance {name}: found {found}, expected one of {count} wheels")

    def start(self, *, wheel_angle: Any = 0.0, **motion: Any) -> GyrostatState:
        """Create a state from attitude, rate, wheel speeds and rotor angles.

        Args:
            wheel_angle: Rotor angles, (wheels,), or one value for all, rad.
            motion: See `Gyrostat.start`; attitude and rate without jitter.
        """
        state = self.gyrostat.start(**motion)
        angle = jnp.broadcast_to(jnp.asarray(wheel_angle, dtype=float), state.wheel_speed.shape)
        return self._turned(state, angle, 1.0)._replace(wheel_angle=angle)

    def check_state(self, state: GyrostatState) -> None:
        """Validate a state; raises `InputError`."""
        self.gyrostat.check_state(state)
        if state.wheel_angle is None:
            raise InputError("wheel_angle: found none, expected the angles of the rotors, rad")

    def rate(self, state: Any) -> Vector3:
        """Body rate with jitter, in body axes, (3,), rad/s."""
        jittered, _ = self.gyrostat.without_modes()
        jitter = self.imbalance.jitter_rate(jittered, state.wheel_speed, state.wheel_angle)
        return self.balanced_rate(state) + jitter

    def balanced_rate(self, state: Any) -> Vector3:
        """Body rate without jitter, in body axes, (3,), rad/s."""
        return self.gyrostat.rate(self._balanced(state))

    def __call__(
        self, state: Any, command: Any, time: Scalar, duration: Scalar
    ) -> tuple[GyrostatState, Bool[Array, ""]]:
        """Integrate over an interval of constant command; see `Gyrostat`."""
        after, resolved = self.gyrostat(self._balanced(state), command, time, duration)
        # exact for constant wheel acceleration, which a constant torque gives approximately
        mean = 0.5 * (state.wheel_speed + after.wheel_speed)
        angle = state.wheel_angle + duration * mean
        return self._turned(after, angle, 1.0)._replace(wheel_angle=angle), resolved

    def _balanced(self, state: Any) -> GyrostatState:
        return self._turned(state, state.wheel_angle, -1.0)._replace(wheel_angle=None)

    def _turned(self, state: GyrostatState, angle: Any, sense: float) -> GyrostatState:
        jitter = from_rotation_vector(sense * self._jitter(angle))
        return state._replace(attitude=product(state.attitude, jitter))

    def diverged(self, state: Any) -> Bool[Array, ""]:
        """See `Gyrostat.diverged`."""
        return self.gyrostat.diverged(self._balanced(state))

    def record(self, state: Any, command: Any) -> GyrostatRecord:
        """Rate, wheel momentum and jitter at the start of a control period."""
        record = self.gyrostat.record(self._balanced(state), command)
        return record._replace(jitter=self._jitter(state.wheel_angle))

    def _jitter(self, angle: Any) -> Vector3:
        jittered, _ = self.gyrostat.without_modes()
        return self.imbalance.jitter(jittered, angle)
