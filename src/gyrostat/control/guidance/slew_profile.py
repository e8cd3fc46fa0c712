"""Seven-segment profile: fastest rotation from rest to rest within rate, acceleration and jerk."""

from typing import NamedTuple, Self

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp

NO_LIMIT = 1e30
"""Value that replaces an infinite limit, so that no quotient of two limits is undefined."""


class SlewProfile(NamedTuple):
    """Angle over time of the fastest rotation from rest to rest within three limits.

    Seven segments: the jerk is +j, 0, -j in the first half, then zero at the largest rate, and -j,
    0, +j. Segments that a short rotation does not reach have no length. L. Biagiotti, C.
    Melchiorri, "Trajectory Planning for Automatic Machines and Robots", section 3.4 (double S).
    Every field has a closed form, so that JAX can differentiate and batch the profile.

    Attributes:
        angle: Angle of the rotation, rad, 0 or more.
        acceleration: Largest acceleration reached, rad/s².
        ramp: Time in which the acceleration rises or falls, s.
        hold: Time at the largest acceleration, s.
        cruise: Time at the largest rate, s.
    """

    angle: Scalar
    acceleration: Scalar
    ramp: Scalar
    hold: Scalar
    cruise: Scalar

    @classmethod
    def fastest(cls, angle: Scalar, rate: Scalar, acceleration: Scalar, jerk: Scalar) -> Self:
        """Fastest profile within limits.

        Args:
            angle: Angle of the rotation, rad, 0 or more.
            rate: Rate limit, rad/s, above 0; may be infinite.
            acceleration: Acceleration limit, rad/s², above 0; may be infinite if the jerk is not.
            jerk: Jerk limit, rad/s³, above 0; may be infinite if the acceleration is not.
        """
        rate, acceleration, jerk = (jnp.minimum(x, NO_LIMIT) for x in (rate, acceleration, jerk))
        # the ramp ends at the first of: the largest acceleration, the largest rate, half the angle
        ramps = (acceleration / jerk, jnp.sqrt(rate / jerk), jnp.cbrt(angle / (2.0 * jerk)))
        ramp = jnp.minimum(jnp.minimum(ramps[0], ramps[1]), ramps[2])
        peak = jnp.where(ramp == ramps[0], acceleration, jerk * ramp)
        # held until the largest rate or half the angle; negative where the ramp has reached them
        halfway = 0.5 * (jnp.sqrt(ramp**2 + 4.0 * angle / acceleration) - 3.0 * ramp)
        hold = jnp.maximum(jnp.minimum(rate / acceleration - ramp, halfway), 0.0)
        top = peak * (ramp + hold)
        cruise = jnp.maximum(angle / jnp.where(top > 0.0, top, 1.0) - (2.0 * ramp + hold), 0.0)
        return cls(angle, peak, ramp, hold, jnp.where(top > 0.0, cruise, 0.0))

    @property
    def duration(self) -> Scalar:
        """Duration of the rotation, s."""
        return 4.0 * self.ramp + 2.0 * self.hold + self.cruise

    @property
    def rate(self) -> Scalar:
        """Largest rate reached, rad/s."""
        return self.acceleration * (self.ramp + self.hold)

    def __call__(self, time: Scalar) -> Scalar:
        """Angle at a time after the start, s; constant before the start and after the end."""
        in_first_half = time < 0.5 * self.duration
        half = self._first_half(jnp.where(in_first_half, time, self.duration - time))
        return jnp.where(in_first_half, half, self.angle - half)

    def progress(self, time: Scalar) -> Scalar:
        """Angle over the whole angle, from 0 to 1; 1 after the start of a rotation by zero."""
        turns = self.angle > 0.0
        share = self(time) / jnp.where(turns, self.angle, 1.0)
        return jnp.where(turns, share, jnp.where(time < 0.0, 0.0, 1.0))

    def _first_half(self, time: Scalar) -> Scalar:
        """Angle up to half the duration; the second half is its mirror image."""
        ramp, top = self.ramp, self.rate
        rise = 2.0 * ramp + self.hold
        safe = jnp.where(ramp > 0.0, ramp, 1.0)
        middle, time_left = time - 0.5 * ramp, rise - time
        rise_angle = 0.5 * top * rise
        ramp_up = self.acceleration * time**3 / (6.0 * safe)
        hold_angle = self.acceleration * (0.5 * middle**2 + ramp**2 / 24.0)
        ramp_down = rise_angle - top * time_left + self.acceleration * time_left**3 / (6.0 * safe)
        cruising = rise_angle + top * (time - rise)
        angle = jnp.where(time < rise, ramp_down, cruising)
        angle = jnp.where(time < ramp + self.hold, hold_angle, angle)
        angle = jnp.where(time < ramp, ramp_up, angle)
        return jnp.where(time < 0.0, 0.0, angle)
