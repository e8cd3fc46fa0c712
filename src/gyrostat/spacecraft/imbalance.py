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
    """U_s and U_d of every wheel: a force U_s W² and a torque U_d W² that go round with the rotor.

    R. A. Masterson, D. W. Miller, R. L. Grogan, "Development and validation of reaction wheel
    disturbance models", Journal of Sound and Vibration 249 (2002), the fundamental harmonic.

    Attributes:
        static: U_s (wheels,), mass times eccentricity, kg·m.
        dynamic: U_d (wheels,), product of inertia, kg·m².
        position: (3, wheels) of the wheels from the centre of mass, body axes, m.
    """

    static: Annotated[PerWheel, size("static imbalance", "kg·m")] = eqx.field(converter=listed)
    dynamic: Annotated[PerWheel, size("dynamic imbalance", "kg·m²")] = eqx.field(converter=listed)
    position: Annotated[Float[Array, "3 wheels"], signed("size of a wheel's position", "m")] = (
        eqx.field(converter=listed)
    )

    def loads(self, axes: Any, speed: PerWheel, angle: PerWheel) -> tuple[Vector3, Vector3]:
        """Force, N, and torque about the centre of mass, N·m, on the body, in body axes.

        Args:
            axes: (3, wheels) spin axes.
            speed: (wheels,) relative to the body, rad/s.
            angle: (wheels,) of the rotors, rad.
        """
        radial, tangent = _turning(axes, angle)
        force = self.static * speed**2 * radial
        arm = jnp.cross(jnp.asarray(self.position), force, axis=0)
        torque = arm - self.dynamic * speed**2 * tangent
        return jnp.sum(force, axis=1), jnp.sum(torque, axis=1)

    def jitter(self, spacecraft: Spacecraft, angle: PerWheel) -> Vector3:
        """Turn of the body that the rotors' angles make, rad, whatever their speeds.

        Args:
            spacecraft: whose body turns.
            angle: (wheels,) rad.
        """
        radial, tangent = _turning(spacecraft.wheels.axes, angle)
        return self._turned(spacecraft, radial, tangent)

    def jitter_rate(self, spacecraft: Spacecraft, speed: PerWheel, angle: PerWheel) -> Vector3:
        """Its derivative in time, rad/s."""
        radial, tangent = _turning(spacecraft.wheels.axes, angle)
        return self._turned(spacecraft, speed * tangent, -speed * radial)

    def peak(self, spacecraft: Spacecraft) -> Vector3:
        """Largest jitter about each body axis, when all wheels come together, rad."""
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
    """(3, wheels) unit vectors across the axes that turn with the rotors, and a quarter ahead."""
    axes = jnp.asarray(axes)
    # the body axis that a spin axis is farthest from is never along it
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
    """A gyrostat whose wheels are out of balance.

    The momentum of an imbalance, W p(angle), is part of the total: so the body's rate has the part
    -J^-1 W p(angle), and since W is the derivative of the angle its integral is a function of the
    angle alone. The jitter is thus added in closed form to the motion with balanced wheels, exact
    to the ratio of body rate to wheel speed; nothing at the wheels' rate is sampled or integrated,
    and a control period may be as long as without. What is measured at a time has the jitter of
    that time in it: a gyro that integrates has the mean of its rate.

    Attributes:
        gyrostat: with balanced wheels.
        imbalance: of its wheels.
    """

    gyrostat: Gyrostat
    imbalance: Imbalance

    @property
    def spacecraft(self) -> Spacecraft:
        """The body and its wheels."""
        return self.gyrostat.spacecraft

    @property
    def failures(self) -> Any:
        """Of the wheels; see `Gyrostat`."""
        return self.gyrostat.failures

    def check_own(self) -> None:
        """Validate shapes.

        Raises:
            InputError: Imbalances of another number of wheels.
        """
        count = self.spacecraft.wheels.count
        for name in ("static", "dynamic", "position"):
            found = np.shape(getattr(self.imbalance, name))[-1:]
            if found != (count,):
                raise InputError(f"imbalance {name}: found {found}, expected one of {count} wheels")

    def start(self, *, wheel_angle: Any = 0.0, **motion: Any) -> GyrostatState:
        """A state from what is measured.

        Args:
            wheel_angle: (wheels,) or one for all, rad.
            motion: see `Gyrostat.start`; attitude and rate are those without jitter.
        """
        state = self.gyrostat.start(**motion)
        angle = jnp.broadcast_to(jnp.asarray(wheel_angle, dtype=float), state.wheel_speed.shape)
        return self._turned(state, angle, 1.0)._replace(wheel_angle=angle)

    def check_state(self, state: GyrostatState) -> None:
        """Refuse what is no state of this spacecraft, by `InputError`."""
        self.gyrostat.check_state(state)
        if state.wheel_angle is None:
            raise InputError("wheel_angle: found none, expected the angles of the rotors, rad")

    def rate(self, state: Any) -> Vector3:
        """Body rate with its jitter, in body axes, rad/s."""
        jitter = self.imbalance.jitter_rate(self.spacecraft, state.wheel_speed, state.wheel_angle)
        return self.balanced_rate(state) + jitter

    def balanced_rate(self, state: Any) -> Vector3:
        """Body rate without jitter, in body axes, rad/s."""
        return self.gyrostat.rate(self._balanced(state))

    def __call__(
        self, state: Any, command: Any, time: Scalar, duration: Scalar
    ) -> tuple[GyrostatState, Bool[Array, ""]]:
        """Carry the spacecraft over an interval of held command; see `Gyrostat`."""
        after, resolved = self.gyrostat(self._balanced(state), command, time, duration)
        # exact where the wheels' acceleration is constant, as it is nearly under a held torque
        mean = 0.5 * (state.wheel_speed + after.wheel_speed)
        angle = state.wheel_angle + duration * mean
        return self._turned(after, angle, 1.0)._replace(wheel_angle=angle), resolved

    def _balanced(self, state: Any) -> GyrostatState:
        return self._turned(state, state.wheel_angle, -1.0)._replace(wheel_angle=None)

    def _turned(self, state: GyrostatState, angle: Any, sense: float) -> GyrostatState:
        jitter = from_rotation_vector(sense * self.imbalance.jitter(self.spacecraft, angle))
        return state._replace(attitude=product(state.attitude, jitter))

    def diverged(self, state: Any) -> Bool[Array, ""]:
        """See `Gyrostat.diverged`."""
        return self.gyrostat.diverged(self._balanced(state))

    def record(self, state: Any, command: Any) -> GyrostatRecord:
        """Rate, wheel momentum and jitter at the start of a control period."""
        record = self.gyrostat.record(self._balanced(state), command)
        return record._replace(jitter=self.imbalance.jitter(self.spacecraft, state.wheel_angle))
