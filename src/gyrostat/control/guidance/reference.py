"""Reference of one or several modes, which follow each other by conditions."""

from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any, NamedTuple, Self, TypeVar, cast

import equinox as eqx
from jaxtyping import Array, Bool, Int

from gyrostat.control.guidance.attitude_reference import (
    AttitudeReference,
    Motion,
    Profile,
    reference_at,
)
from gyrostat.control.guidance.condition import NEVER, Condition, is_in_view
from gyrostat.control.guidance.slew import SlewLimits, Transition
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import Spacecraft


class Mode(NamedTuple):
    """Active mode of a reference.

    Attributes:
        number: Number of the mode, from 0.
        start: Time at which it started, s.
        transition: Rotation from the mode before; None: it is computed where it is needed.
    """

    number: Int[Array, ""]
    start: Scalar
    transition: Transition | None = None


Method = TypeVar("Method", bound=Callable[..., Any])


def _traced_once(method: Method) -> Method:
    """Method that a program traces only where it calls it first.

    A reference is evaluated in many places of a program; this halves the time that a program with a
    sequence of modes takes to be made. A profile that is not made of numbers only may change
    without notice, and is traced in each place.
    """
    compiled: Any = eqx.filter_jit  # its type does not show the options of `jax.jit`
    traced = compiled(method, inline=True)

    @wraps(method)
    def call(self: Any, *arguments: Any) -> Any:
        of_numbers = all(map(eqx.is_array_like, jax.tree.leaves(self)))
        return (traced if of_numbers else method)(self, *arguments)

    return cast(Method, call)


class Reference(Checked):
    """Reference attitude of one or several modes.

    Each mode has its own attitude over time. From mode to mode, the reference turns by a
    `Transition` within the slew limits. A mode ends when its transition is complete and all of its
    conditions hold; then the next mode starts. The last mode never ends. The conditions use the
    measurement of the sample at which they are tested.

    Attributes:
        modes: Attitude over time of each mode, a `Profile`.
        until: Conditions under which the modes end, each (modes,).
        limits: Limits of the rotation from mode to mode; None for one mode.
        spacecraft: Spacecraft model for the total momentum; None: no condition on it.
        views: Views along the orbit that modes wait for, each a callable time, s -> a number above
            0 while it lasts.
    """

    modes: tuple[Callable[..., Any], ...]
    until: Condition
    limits: SlewLimits | None = None
    spacecraft: Spacecraft | None = None
    views: tuple[Callable[[Scalar], Scalar], ...] = ()

    @classmethod
    def of(cls, profile: Profile) -> Self:
        """Reference of one mode.

        Args:
            profile: Attitude over time.
        """
        return cls.sequence((profile, NEVER))

    @classmethod
    def sequence(
        cls,
        *modes: tuple[Profile, Condition],
        limits: SlewLimits | None = None,
        spacecraft: Spacecraft | None = None,
        views: Sequence[Callable[[Scalar], Scalar]] = (),
    ) -> Self:
        """Reference of several modes.

        Args:
            modes: Attitude over time and end conditions of each mode.
            limits: Limits of the rotation from mode to mode; required for several modes.
            spacecraft: Spacecraft model; required for conditions on the momentum.
            views: Views along the orbit, for conditions on them.

        Raises:
            InputError: There is no mode, or `limits` or `spacecraft` is required and None.
        """
        if not modes:
            raise InputError("reference: found no mode, expected one or more")
        ends = [condition for _, condition in modes]
        if limits is None and len(modes) > 1:
            raise InputError(
                f"reference of {len(modes)} modes: found no slew limits, expected limits for the "
                "rotation from mode to mode"
            )
        if spacecraft is None and any(end.momentum_above >= 0.0 for end in ends):
            raise InputError(
                "reference: found a condition on the momentum and no spacecraft, expected the "
                "spacecraft from which the momentum is computed"
            )
        until = Condition(*(jnp.asarray(each, dtype=float) for each in zip(*ends, strict=True)))
        return cls(tuple(profile for profile, _ in modes), until, limits, spacecraft, tuple(views))

    def start(self) -> Mode:
        """Mode before the first sample: the first mode, from time 0."""
        transition = None if self.limits is None else Transition.none()
        return Mode(jnp.zeros((), dtype=int), jnp.zeros(()), transition)

    def entered(self, mode: Mode, number: Int[Array, ""], start: Scalar) -> Mode:
        """Active mode; the rotation to it is computed if it is another one.

        Args:
            mode: Mode before.
            number: Number of the active mode.
            start: Time at which the active mode started, s.
        """
        if self.limits is None:
            return mode
        if mode.transition is None:
            return Mode(number, start, self._transition(number, start))
        transition = jax.lax.cond(
            (number != mode.number) | (start != mode.start),
            lambda: self._transition(number, start),
            lambda: jax.tree.map(jnp.asarray, mode.transition),
        )
        return Mode(number, start, transition)

    def bound(self, mode: Mode) -> "BoundReference":
        """Reference in a mode, as a function of time.

        Args:
            mode: Active mode.
        """
        has_transition = mode.transition is not None or self.limits is None
        return BoundReference(self, mode if has_transition else self.entered(mode, *mode[:2]))

    def at(self, mode: Mode, time: Scalar) -> AttitudeReference:
        """Attitude, rate and acceleration at a time.

        Args:
            mode: Active mode.
            time: Time, s.
        """
        return self.bound(mode)(time)

    def step(self, mode: Mode, measurement: Any, time: Scalar) -> Mode:
        """Mode that is active from a sample on.

        Args:
            mode: Mode before the sample.
            measurement: Measurement with `attitude` (4,), `rate` (3,), rad/s, and `wheel_speed`
                (wheels,), rad/s; None for a missing sample, at which only modes end whose
                conditions need no measurement.
            time: Time of the sample, s.
        """
        if self.limits is None:
            return mode
        assert mode.transition is not None
        until = Condition(*(jnp.asarray(each)[mode.number] for each in self.until))
        # multiples of a control period are subject to rounding
        elapsed = time - mode.start + 1e-9
        ends = (elapsed >= until.after) & (elapsed >= mode.transition.duration)
        ends &= mode.number < len(self.modes) - 1
        if self.views:
            ends = jax.lax.cond(
                ends,
                lambda: is_in_view(self.views, until.view, time),
                lambda: jnp.zeros((), bool),
            )
        if measurement is None:
            ends &= jnp.isinf(until.rate_below) & jnp.isinf(until.error_below)
            ends &= until.momentum_above < 0.0
        else:
            ends = jax.lax.cond(
                ends,
                lambda: self._is_met(until, measurement, self._ending(mode.number, time)),
                lambda: jnp.zeros((), bool),
            )
        return self.entered(mode, mode.number + ends, jnp.where(ends, time, mode.start))

    def _ending(self, number: Int[Array, ""], time: Scalar) -> Quaternion:
        """Attitude of a mode that may end: not the last one, and the rotation to it is over."""
        count = max(len(self.modes) - 1, 1)
        every = self._motions([number == k for k in range(count)], time)
        return jax.tree.map(lambda rows: rows[number], every).reference.attitude

    def _is_met(self, until: Condition, measurement: Any, target: Quaternion) -> Bool[Array, ""]:
        """Whether the conditions of a mode on the measurement hold."""
        rate = measurement.rate
        holds = rate @ rate < until.rate_below**2
        holds &= rotations.error_angle(measurement.attitude, target) < until.error_below
        if self.spacecraft is None:
            return holds
        wheels = self.spacecraft.wheels
        spun = jnp.asarray(wheels.axes) @ (wheels.inertia * measurement.wheel_speed)
        momentum = self.spacecraft.inertia_locked() @ rate + spun
        return holds & (jnp.sqrt(momentum @ momentum) > until.momentum_above)

    def _transition(self, number: Int[Array, ""], start: Scalar) -> Transition:
        """Rotation to a mode that starts at a time, s."""
        assert self.limits is not None
        return Transition.of(*self.motions(number, start, True), start, self.limits)

    @_traced_once
    def motions(
        self, number: Int[Array, ""], time: Scalar, turning: Bool[Array, ""] | bool
    ) -> tuple[Motion, Motion]:
        """Motions of the mode before a mode and of the mode itself; others are not computed.

        Args:
            number: Number of the mode.
            time: Time, s.
            turning: Whether that of the mode before is needed; if not, it may be wrong.
        """
        previous = jnp.maximum(number - 1, 0)
        needed = [(number == k) | (turning & (previous == k)) for k in range(len(self.modes))]
        every = self._motions(needed, time)
        first, second = (jax.tree.map(lambda rows, k=k: rows[k], every) for k in (previous, number))
        return first, second

    def _motions(self, needed: Sequence[Bool[Array, ""]], time: Scalar) -> Motion:
        """Motions of the first modes, of which those that are not needed may be wrong."""
        every = [
            jax.lax.cond(
                is_needed,
                lambda time, mode=mode: Motion.of(mode, time),
                lambda time: Motion(jnp.full(4, 0.5), jnp.zeros(4), jnp.zeros(4)),
                jnp.asarray(time, dtype=float),
            )
            for is_needed, mode in zip(needed, self.modes, strict=False)
        ]
        return Motion(*(jnp.stack(each) for each in zip(*every, strict=True)))


class BoundReference(eqx.Module):
    """Reference in one mode: a function of time, for controllers with a field `reference`.

    Attributes:
        reference: Reference.
        mode: Active mode.
    """

    reference: Reference
    mode: Mode

    @_traced_once
    def __call__(self, time: Scalar) -> AttitudeReference:
        """Attitude, rate and acceleration at a time, s, if the mode does not end before."""
        reference, (number, start, transition) = self.reference, self.mode
        if transition is None:
            return reference_at(reference.modes[0], time)
        since = time - start
        turning = since < transition.duration
        previous, present = reference.motions(number, time, turning)

        def attitude(later: Scalar) -> Quaternion:
            return transition(since + later, previous.after(later), present.after(later))

        return jax.lax.cond(turning, lambda: reference_at(attitude, 0.0), lambda: present.reference)
