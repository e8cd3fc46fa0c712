"""Changes from mode to mode of a reference."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from gyrostat.control.guidance.condition import Condition, Measured, ModeChange, is_in_view
from gyrostat.control.guidance.transition import Transition
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.traced_once import one_function
from gyrostat.spacecraft import Spacecraft


class Watch(NamedTuple):
    """What the conditions of a reference remember between samples.

    Attributes:
        unmet: Last time at which the conditions of each change did not hold, (changes,), s.
        tracked: Time of the last measurement of the attitude, s.
        lost: Number of wheels that the controller takes to have failed.
        taken: Number of the change that led to the active mode, from 1; 0 before the first one.
        sampled: Time of the last sample, also of a missing one, s.
    """

    unmet: Float[Array, " changes"]
    tracked: Scalar
    lost: Scalar
    taken: Int[Array, ""]
    sampled: Scalar


class Mode(NamedTuple):
    """Active mode of a reference.

    Attributes:
        number: Number of the mode, from 0.
        start: Time at which it started, s.
        transition: Rotation to the mode; None: there is none.
        watch: What the conditions remember; None: the mode is only followed.
    """

    number: Int[Array, ""]
    start: Scalar
    transition: Transition | None = None
    watch: Watch | None = None


class Lasted(NamedTuple):
    """Active mode at a sample, before its changes are tested.

    Attributes:
        number: Number of the mode, from 0.
        start: Time at which it started, s.
        turning: Duration of the rotation to it, s.
    """

    number: Int[Array, ""]
    start: Scalar
    turning: Scalar


class Changes(Checked):
    """Changes from mode to mode, tested at each sample in their order.

    The conditions use the measurement of the sample; a sample without measurement neither fulfils
    nor interrupts those that need one: it counts for `held` only after a sample at which they held.
    The time for `held` goes on across a change between two modes in both of which a change starts;
    it begins anew in a mode that the change itself led to, or into which none of its modes led.

    Attributes:
        conditions: Conditions of each change, (changes,).
        dwell: Least time in each mode, (modes,), s.
        spacecraft: Spacecraft model for the momentum; None: no condition on it.
        views: Views along the orbit that modes wait for, each a callable time, s -> a number above
            0 while it lasts.
        user: Further condition of each change, see `ModeChange`.
        to: Mode to which each change leads.
        origins: Whether each change starts in each mode, (changes, modes).
        measured: Whether each change needs a measurement, (changes,).
    """

    conditions: Condition
    dwell: Float[Array, " modes"]
    measured: Bool[Array, " changes"]
    spacecraft: Spacecraft | None = None
    views: tuple[Callable[[Scalar], Scalar], ...] = ()
    user: tuple[Callable[[Any, Scalar], Any] | None, ...] = ()
    to: tuple[int, ...] = eqx.field(static=True, default=())
    origins: tuple[tuple[bool, ...], ...] = eqx.field(static=True, default=())

    @classmethod
    def of(
        cls,
        changes: Sequence[ModeChange],
        count: int,
        dwell: Any = 0.0,
        spacecraft: Spacecraft | None = None,
        views: Sequence[Callable[[Scalar], Scalar]] = (),
    ) -> Self:
        """Changes of a number of modes; see the attributes.

        Raises:
            InputError: A condition is on the momentum, and there is no spacecraft.
        """
        conditions = [change.condition for change in changes]
        users = tuple(change.user for change in changes)
        if spacecraft is None and any(bool(each.uses_momentum) for each in conditions):
            raise InputError(
                "reference: found a condition on the momentum and no spacecraft, expected the "
                "spacecraft from which the momentum is computed"
            )
        every = Condition.stacked(conditions)
        return cls(
            every,
            dwell * jnp.ones(count),
            every.needs_measurement | np.array([user is not None for user in users], bool),
            spacecraft,
            tuple(views),
            users,
            tuple(change.to for change in changes),
            tuple(tuple(map(change.starts_in, range(count))) for change in changes),
        )

    def start(self) -> Watch | None:
        """What the conditions remember before the first sample; None without changes."""
        zero = jnp.zeros(())
        if not self.to:
            return None
        return Watch(jnp.zeros(len(self.to)), zero, zero, jnp.zeros((), dtype=int), zero)

    def __call__(
        self, watch: Watch, mode: Lasted, measurement: Any, target: Quaternion, time: Scalar
    ) -> tuple[Bool[Array, ""], Int[Array, ""], Watch]:
        """Whether a change is taken at a sample, the mode from then on, and the next watch.

        Args:
            watch: What they remember from the sample before.
            mode: Active mode.
            measurement: See `Reference.advance`.
            target: Attitude of the reference, (4,).
            time: Time of the sample, s.
        """
        if measurement is None:
            met = jnp.logical_not(self.measured)
        else:
            is_measured = getattr(measurement, "attitude_measured", None)
            tracked = time if is_measured is None else jnp.where(is_measured, time, watch.tracked)
            watch = watch._replace(tracked=jnp.asarray(tracked, dtype=float))
            met = self._met(measurement, target, time)
        is_sampled = jnp.array(measurement is not None)
        changes, number, unmet, taken = self._taken(watch, mode, met, is_sampled, time)
        sampled = jnp.asarray(time, dtype=float)
        return changes, number, watch._replace(unmet=unmet, taken=taken, sampled=sampled)

    @one_function
    def _taken(
        self,
        watch: Watch,
        mode: Lasted,
        met: Bool[Array, " changes"],
        is_sampled: Bool[Array, ""],
        time: Scalar,
    ) -> tuple[Bool[Array, ""], Int[Array, ""], Float[Array, " changes"], Int[Array, ""]]:
        """Whether a change is taken, the mode, and fields `unmet` and `taken` of the watch.

        Args:
            watch: See `__call__`.
            mode: Active mode.
            met: Whether what the conditions say of measured quantities holds, (changes,).
            is_sampled: Whether there is a measurement.
            time: Time of the sample, s.
        """
        holds = met & self._hold(mode, watch, time)
        unmet = jnp.where(holds, watch.unmet, time)
        # unmet at the sample before: still unmet
        latest = jnp.where(watch.unmet >= watch.sampled, time, watch.unmet)
        unmet = jnp.where(jnp.asarray(self.measured) & jnp.logical_not(is_sampled), latest, unmet)
        held = jnp.asarray(self.conditions.held)
        # multiples of a control period are subject to rounding
        holds &= (held == 0.0) | (time - unmet > held + 1e-9)
        ripe = holds & (time - mode.start + 1e-9 >= jnp.asarray(self.dwell)[mode.number])
        starts = jnp.asarray(self.origins).T
        takes = ripe & starts[mode.number]
        number, taken = mode.number, watch.taken
        for k in reversed(range(len(self.to))):
            number = jnp.where(takes[k], self.to[k], number)
            taken = jnp.where(takes[k], k + 1, taken)
        changes = jnp.any(takes)
        begins = jnp.broadcast_to(changes, unmet.shape)
        can_go_on = self._can_go_on()
        if can_go_on.any():
            is_taken = jnp.arange(1, len(self.to) + 1) == taken
            goes_on = starts[mode.number] & starts[number] & can_go_on
            begins &= is_taken | jnp.logical_not(goes_on)
        return changes, number, jnp.where(begins, time, unmet), taken

    def _can_go_on(self) -> np.ndarray:
        """Whether the time for `held` of each change can go on across another one, (changes,)."""
        return np.array(
            [
                any(
                    other != change and starts and row[mode] and row[to]
                    for other, to in enumerate(self.to)
                    for mode, starts in enumerate(self.origins[other])
                )
                for change, row in enumerate(self.origins)
            ],
            bool,
        )

    def _hold(self, mode: Lasted, watch: Watch, time: Scalar) -> Bool[Array, " changes"]:
        """Whether the conditions of each change hold that need no measurement."""
        conditions, since = self.conditions, time - mode.start + 1e-9
        at = jnp.asarray(conditions.at)
        holds = (since >= conditions.after) & (watch.lost >= conditions.wheels_lost)
        holds &= time - watch.tracked + 1e-9 >= conditions.tracker_lost
        holds &= (at < 0.0) | ((time + 1e-9 >= at) & (mode.start < at - 1e-9))
        holds &= (conditions.reached == 0.0) | (since >= mode.turning)
        return holds & is_in_view(self.views, conditions.view, time) if self.views else holds

    def _met(self, measurement: Any, target: Quaternion, time: Scalar) -> Bool[Array, " changes"]:
        """Whether what the conditions of each change say of measured quantities holds."""
        met = self._measured(measurement, target).meet(self.conditions)
        for number, user in enumerate(self.user):
            if user is not None:
                met = met.at[number].set(met[number] & (user(measurement, time) > 0.0))
        return met

    def _measured(self, measurement: Any, target: Quaternion) -> Measured:
        """Measured quantities that conditions limit."""
        rate, momentum, spun = measurement.rate, jnp.zeros(3), jnp.zeros(3)
        if self.spacecraft is not None:
            wheels = self.spacecraft.wheels
            spun = jnp.asarray(wheels.axes) @ (wheels.inertia * measurement.wheel_speed)
            momentum = self.spacecraft.inertia_locked() @ rate + spun
        size, total, held = (jnp.sqrt(each @ each) for each in (rate, momentum, spun))
        error = rotations.error_angle(measurement.attitude, target)
        return Measured(size, error, total, held)
