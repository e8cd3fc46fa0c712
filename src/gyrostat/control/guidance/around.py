"""Instruments that the turns of a reference keep from bright bodies, found when a turn starts."""

from collections.abc import Callable, Sequence
from typing import Any

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat.control.guidance.attitude_reference import AttitudeReference, Profile
from gyrostat.control.guidance.planned_turns import turned_beside
from gyrostat.control.guidance.sampled_sky import SampledSky, longest
from gyrostat.control.guidance.slew import SlewLimits
from gyrostat.control.guidance.slew_profile import SlewProfile
from gyrostat.control.guidance.transition import Transition
from gyrostat.control.guidance.way_around import Start, Way, way_around
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rarely import rarely
from gyrostat.core.traced_once import one_function
from gyrostat.spacecraft.sensors.keep_out import KeepOut


@one_function
def _attitude(mode: Profile, time: Scalar) -> Quaternion:
    """Attitude of a mode at a time."""
    return rotations.normalised(jnp.asarray(mode(time), dtype=float))


class Around(Checked):
    """Instruments that turns keep from bright bodies.

    Attributes:
        keep_outs: Instruments along the same orbit.
        kept: Whether the turn to each mode keeps each of them, 1 or 0, (modes, instruments).
        margin: Angle that the turns keep beside those of the instruments, rad.
        measured: Whether a turn from each mode starts at the measured attitude, as the controller
            of that mode does not follow the reference.
    """

    keep_outs: tuple[KeepOut, ...]
    kept: Float[Array, "modes instruments"]
    margin: Scalar
    measured: tuple[bool, ...] = eqx.field(static=True, default=())

    def keeps(self, number: Any) -> Any:
        """Whether the turn to a mode keeps an instrument."""
        return jnp.any(jnp.asarray(self.kept)[number] > 0.0)

    def begin(
        self, now: AttitudeReference, origin: Any, number: Any, measurement: Any
    ) -> AttitudeReference:
        """Motion from which a turn to another mode starts.

        Args:
            now: Motion of the reference.
            origin: Number of the mode before.
            number: Number of the mode after.
            measurement: Measurement; None for a missing sample: the reference goes on.
        """
        if measurement is None:
            return now
        starts = jnp.asarray(self.measured)[origin] & (number != origin) & self.keeps(number)
        at_body = AttitudeReference(measurement.attitude, measurement.rate, jnp.zeros(3))
        return jax.tree.map(lambda one, other: jnp.where(starts, one, other), at_body, now)

    def taken(
        self,
        modes: Sequence[Profile],
        number: Any,
        start: Scalar,
        limits: SlewLimits,
        fits: Callable[[Vector3, tuple[Scalar, Scalar]], Any] | None,
        changes: Any,
        direct: Transition,
    ) -> Way:
        """Way of a turn to a mode: that of `way` unless it is planned, or keeps no instrument.

        Of a batch by `vmap`, only runs in which a turn starts are searched for a way.

        Args:
            modes: Attitude over time of each mode.
            number: Number of the mode.
            start: Time of its start, s.
            limits: Limits of the rotations.
            fits: Function of the rotation vector and the relative motion, see
                `PlannedTurns.fits`; None: no turn is planned.
            changes: Whether the turn starts; the way is unused otherwise.
            direct: The turn, planned or about its eigenaxis.
        """
        is_free = changes & self.keeps(number)
        if fits is not None:
            is_free &= jnp.logical_not(fits(-direct.turn, direct.moves))
        given = self, tuple(modes), number, start, limits, direct
        arrays, rest = eqx.partition(given, eqx.is_array)

        def straight(is_free: Any, arrays: Any) -> tuple[Way, Any]:
            *_, direct = eqx.combine(arrays, rest)
            return Way.straight(direct.turn, direct.profile), jnp.logical_not(is_free)

        def found(is_free: Any, arrays: Any) -> Way:
            around, modes, number, start, limits, direct = eqx.combine(arrays, rest)
            return jax.lax.cond(
                is_free,
                lambda: around.way(direct, modes, number, start, limits),
                lambda: Way.straight(direct.turn, direct.profile),
            )

        return rarely(straight, found)(is_free, arrays)

    def way(
        self,
        direct: Transition,
        modes: Sequence[Profile],
        number: Any,
        start: Scalar,
        limits: SlewLimits,
    ) -> Way:
        """Way of a turn to a mode.

        Args:
            direct: The turn about its eigenaxis.
            modes: Attitude over time of each mode.
            number: Number of the mode.
            start: Time of its start, s.
            limits: Limits of the rotations.
        """

        def attitude(time: Scalar) -> Quaternion:
            branches = [lambda time, mode=mode: _attitude(mode, time) for mode in modes]
            return jax.lax.switch(number, branches, jnp.asarray(time, dtype=float))

        rate, gain = direct.moves
        now = attitude(start)

        def lasts(turn: Vector3) -> Scalar:
            return limits.profile(turn, now, start, rate).duration

        span = jnp.maximum(longest(lasts), direct.duration)
        sky = SampledSky.of(attitude, self.keep_outs[0].sights, start, span)

        def profile(turn: Vector3, offset: Quaternion, time: Scalar) -> SlewProfile:
            # a target that moves has turned until the later rotations start
            origin = rotations.product(sky.attitude(time), offset)
            return limits.profile(turn, origin, time, rate)

        offset = rotations.from_rotation_vector(direct.turn)
        wider = self.margin + turned_beside(rate, gain, direct.duration)
        bodies = sky.seen(*self._cones(number))
        way = way_around(Start(offset, start, profile, wider + sky.bend, self.margin), bodies)
        is_late = jnp.sum(jnp.asarray(way.profiles.duration)) + way.profile.duration > span
        is_clear = (way.blocked == 0.0) | (way.blocked == 2.0)
        return way._replace(blocked=way.blocked + jnp.where(is_late & is_clear, 1.0, 0.0))

    def _cones(self, number: Any) -> tuple[Array, Array]:
        """Boresights, and angles to the bodies that a turn to a mode keeps, 0 for none."""
        angles = jnp.stack([jnp.stack([*map(jnp.asarray, x.angles)]) for x in self.keep_outs])
        kept = jnp.asarray(self.kept)[number]
        axes = jnp.stack([jnp.asarray(each.boresight, dtype=float) for each in self.keep_outs])
        return jax.vmap(rotations.normalised)(axes), kept[:, None] * angles
