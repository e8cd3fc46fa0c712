"""Reference of one or several modes, which change by conditions."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Self

import equinox as eqx
from jaxtyping import Array, Bool, Int

from gyrostat.control.guidance.around import Around
from gyrostat.control.guidance.attitude_reference import (
    AttitudeReference,
    Profile,
    reference_at,
)
from gyrostat.control.guidance.condition import Condition, ModeChange
from gyrostat.control.guidance.mode_changes import Changes, Lasted, Mode
from gyrostat.control.guidance.planned_turns import PlannedTurns
from gyrostat.control.guidance.slew import SlewLimits
from gyrostat.control.guidance.transition import Transition
from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import Tracer, jax, jnp
from gyrostat.core.traced_once import one_function
from gyrostat.spacecraft import Spacecraft

_profile_motion = one_function(reference_at)


class Reference(Checked):
    """Reference attitude of one or several modes.

    Each mode has its own attitude over time. From mode to mode, the reference turns by a
    `Transition` within the slew limits, also from the middle of another one. At each sample, the
    first change whose conditions hold, and which starts in the active mode, is taken.

    Attributes:
        modes: Attitude over time of each mode, a `Profile`.
        limits: Limits of the rotation from mode to mode; None for one mode.
        changes: Changes from mode to mode.
        planned: Planned rotation from each mode to each other one, with the number (mode before) *
            modes + (mode after); None: there are no plans.
        around: Instruments that rotations without a plan keep from bright bodies; None: none are.
    """

    modes: tuple[Callable[..., Any], ...]
    limits: SlewLimits | None = None
    changes: Changes = Changes.of([], 1)
    planned: PlannedTurns | None = None
    around: Around | None = None

    @classmethod
    def of(cls, profile: Profile) -> Self:
        """Reference of one mode.

        Args:
            profile: Attitude over time.
        """
        return cls.branching([profile], [])

    @classmethod
    def sequence(
        cls,
        *modes: tuple[Profile, Condition],
        limits: SlewLimits | None = None,
        spacecraft: Spacecraft | None = None,
        views: Sequence[Callable[[Scalar], Scalar]] = (),
    ) -> Self:
        """Reference of modes that follow each other; the last one never ends.

        Args:
            modes: Attitude over time and end conditions of each mode.
            limits: Limits of the rotation from mode to mode; required for several modes.
            spacecraft: Spacecraft model; required for conditions on the momentum.
            views: Views along the orbit, for conditions on them.

        Raises:
            InputError: There is no mode, or `limits` or `spacecraft` is required and None.
        """
        return cls.branching(
            [profile for profile, _ in modes],
            [ModeChange(k + 1, end, (k,)) for k, (_, end) in enumerate(modes[:-1])],
            limits=limits,
            spacecraft=spacecraft,
            views=views,
        )

    @classmethod
    def branching(
        cls,
        modes: Sequence[Profile],
        changes: Sequence[ModeChange],
        *,
        dwell: Any = 0.0,
        limits: SlewLimits | None = None,
        spacecraft: Spacecraft | None = None,
        views: Sequence[Callable[[Scalar], Scalar]] = (),
        planned: PlannedTurns | None = None,
        around: Around | None = None,
    ) -> Self:
        """Reference of modes with changes from any mode to any other.

        Args:
            modes: Attitude over time of each mode; the first one is active at the start.
            changes: Changes of mode, in the order in which they are tested.
            dwell: Least time in each mode, (modes,), or one for all, s.
            limits: Limits of the rotation from mode to mode; required for several modes.
            spacecraft: Spacecraft model; required for conditions on the momentum.
            views: Views along the orbit, for conditions on them.
            planned: Planned rotation from each mode to each other one, see the attributes.
            around: See the attributes.

        Raises:
            InputError: There is no mode, or `limits` or `spacecraft` is required and None.
        """
        if not modes:
            raise InputError("reference: found no mode, expected one or more")
        if limits is None and len(modes) > 1:
            raise InputError(
                f"reference of {len(modes)} modes: found no slew limits, expected limits for the "
                "rotation from mode to mode"
            )
        every = Changes.of(changes, len(modes), dwell, spacecraft, views)
        return cls(tuple(modes), limits, every, planned, around)

    def start(self, *, watched: bool = True) -> Mode:
        """Mode before the first sample: the first mode, from time 0.

        Args:
            watched: Whether its changes are to be tested.
        """
        number, zero = jnp.zeros((), dtype=int), jnp.zeros(())
        if self.limits is None:
            return Mode(number, zero)
        watch = self.changes.start() if watched else None
        parts = {"bowed": self.planned is not None, "around": self.around is not None}
        return Mode(number, zero, Transition.none(**parts), watch)

    def entered(
        self,
        mode: Mode,
        number: Int[Array, ""],
        start: Scalar,
        begin: Callable[[AttitudeReference], AttitudeReference] | None = None,
    ) -> Mode:
        """Active mode; the rotation to it is computed if it is another one.

        Args:
            mode: Mode before.
            number: Number of the active mode.
            start: Time at which the active mode started, s.
            begin: Motion from which the rotation starts, of that of the reference before; None:
                the same.
        """
        if self.limits is None:
            return mode
        changes = (number != mode.number) | (start != mode.start)

        def before() -> AttitudeReference:
            now = self.at(mode, start)
            return now if begin is None else begin(now)

        return self._entered(mode, number, start, changes, before)

    def _entered(
        self,
        mode: Mode,
        number: Int[Array, ""],
        start: Scalar,
        changes: Bool[Array, ""],
        before: Callable[[], AttitudeReference],
    ) -> Mode:
        """Active mode; `before` gives the reference at its start if it `changes`."""
        assert mode.transition is not None

        def new() -> Transition:
            return self._transition(before(), mode.number, number, start, changes)

        if isinstance(changes, Tracer):
            transition = jax.lax.cond(
                changes, new, lambda: jax.tree.map(jnp.asarray, mode.transition)
            )
        else:  # JAX would compile a `cond` anew in each call
            transition = new() if changes else mode.transition
        return mode._replace(number=number, start=start, transition=transition)

    @one_function
    def _transition(
        self,
        before: AttitudeReference,
        origin: Int[Array, ""],
        number: Int[Array, ""],
        start: Scalar,
        changes: Bool[Array, ""],
    ) -> Transition:
        """Rotation from one mode to another, from the motion at its start, if it `changes`."""
        assert self.limits is not None
        fitted = None
        row = origin * len(self.modes) + number
        if self.planned is not None:
            fitted = partial(self.planned.fitted, row)
        around = None
        if self.around is not None:
            fits = None if self.planned is None else partial(self.planned.fits, row)
            known = self.modes, number, start, self.limits, fits, changes
            around = partial(self.around.taken, *known)
        after = self.motion(number, start)
        return Transition.of(before, after, start, self.limits, fitted, around)

    def bound(self, mode: Mode) -> "BoundReference":
        """Reference in a mode, as a function of time.

        Args:
            mode: Active mode.
        """
        return BoundReference(self, mode)

    def at(self, mode: Mode, time: Scalar) -> AttitudeReference:
        """Attitude, rate and acceleration at a time.

        Args:
            mode: Active mode.
            time: Time, s.
        """
        number, start, transition, _ = mode
        if transition is None:
            return self.motion(number, time)
        return self._reference(number, start, transition, time)

    def step(self, mode: Mode, measurement: Any, time: Scalar) -> Mode:
        """Mode that is active from a sample on; see `advance`."""
        return self.advance(mode, measurement, time)[0]

    def advance(self, mode: Mode, measurement: Any, time: Scalar) -> tuple[Mode, AttitudeReference]:
        """Mode that is active from a sample on, and the reference at the sample.

        Args:
            mode: Mode before the sample.
            measurement: Measurement with `attitude` (4,), `rate` (3,), rad/s, and `wheel_speed`
                (wheels,), rad/s; None for a missing sample. With `attitude_measured`, it also says
                whether the attitude was measured.
            time: Time of the sample, s.
        """
        now = self.at(mode, time)
        if mode.watch is None:
            return mode, now
        assert mode.transition is not None
        lasted = Lasted(mode.number, mode.start, mode.transition.duration)
        tested = self.changes(mode.watch, lasted, measurement, now.attitude, time)
        changes, number, watch = tested
        start = jnp.where(changes, time, mode.start)
        # the reference is continuous, so that `now` holds in both modes
        if self.around is not None and any(self.around.measured):
            now = self.around.begin(now, mode.number, number, measurement)
        later = self._entered(mode, number, start, changes, lambda: now)
        return later._replace(watch=watch), now

    @one_function
    def _reference(
        self, number: Int[Array, ""], start: Scalar, transition: Transition, time: Scalar
    ) -> AttitudeReference:
        """Motion in a mode, with the rotation to it."""
        present, since = self.motion(number, time), time - start
        return jax.lax.cond(
            since < transition.duration,
            lambda: transition(since, present),
            lambda: present,
        )

    @one_function
    def motion(self, number: Int[Array, ""], time: Scalar) -> AttitudeReference:
        """Motion of a mode; those of the others are not computed.

        Args:
            number: Number of the mode.
            time: Time, s.
        """
        time = jnp.asarray(time, dtype=float)
        branches = [lambda time, mode=mode: _profile_motion(mode, time) for mode in self.modes]
        return jax.lax.switch(number, branches, time)


class BoundReference(eqx.Module):
    """Reference in one mode: a function of time, for controllers with a field `reference`.

    Attributes:
        reference: Reference.
        mode: Active mode.
    """

    reference: Reference
    mode: Mode

    def __call__(self, time: Scalar) -> AttitudeReference:
        """Attitude, rate and acceleration at a time, s, if the mode does not end before."""
        return self.reference.at(self.mode, time)
