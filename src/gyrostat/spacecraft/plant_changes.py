"""Step changes of a plant during a run, such as a deployment or a change of its friction."""

from typing import Annotated, Any, Protocol

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked, from_start
from gyrostat.core.errors import InputError, placed
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.named_tuples import with_fields, without_fields
from gyrostat.core.validation import check_parts
from gyrostat.spacecraft.pieces import pieces
from gyrostat.spacecraft.spacecraft import Spacecraft

TOLERANCE = 1e-9
"""Time before a change at which it already counts, s; a multiple of a period has a rounding
error."""


class Change(Protocol):
    """Protocol of a step change of a plant."""

    def __call__(self, plant: Any) -> Any:
        """Plant after the change: the same structure with other numbers.

        `equinox.tree_at` replaces numbers of a plant; `plant.spacecraft` is the body of any plant
        with wheels.

        Args:
            plant: Plant before the change.
        """
        ...


class PlantChange(Checked):
    """Step change of a plant at a time.

    Attributes:
        name: Name of the change, for messages.
        time: Time of the change, s.
        change: Plant before the change -> plant after it.
    """

    name: str = eqx.field(static=True)
    time: Annotated[Scalar, from_start("time of a plant change")]
    change: Change

    def __call__(self, plant: Any, time: Scalar) -> Any:
        """Plant at a time, s; after the change if the time has come.

        Raises:
            InputError: The changed plant has another structure.
        """
        after = self.change(plant)
        self._compare(plant, after)
        happened = self.time <= time + TOLERANCE
        return jax.tree.map(
            lambda new, old: jnp.where(happened, new, old) if eqx.is_array_like(old) else old,
            after,
            plant,
        )

    def _compare(self, before: Any, after: Any) -> None:
        expected = f"expected the {type(before).__name__} with other numbers in the same structure"
        if type(after) is not type(before):
            raise InputError(
                f"event {self.name}: found a result of type {type(after).__name__}, {expected}"
            )
        if jax.tree.structure(after) != jax.tree.structure(before):
            raise InputError(
                f"event {self.name}: found a plant of another structure (a part added, removed or "
                f"replaced by one of another kind), {expected}"
            )
        old = jax.tree.leaves(before)
        for (path, new), leaf in zip(jax.tree.leaves_with_path(after), old, strict=True):
            if eqx.is_array_like(leaf) and np.shape(new) != np.shape(leaf):
                raise InputError(
                    f"event {self.name}: found plant{jax.tree_util.keystr(path)} of shape "
                    f"{np.shape(new)}, expected {np.shape(leaf)} as before"
                )


class ChangingPlant(Checked):
    """Plant that changes its numbers at given times.

    A change inside a control period acts from its exact time (within `TOLERANCE`). The state is
    continuous: for a spacecraft, attitude, total momentum and wheel speeds stay the same, so that
    the body rate steps if the inertia changes. At any time the plant is the one at the start with
    all changes up to this time, in the listed order. The state has the additional field `elapsed`,
    the time since the start of the run, s.

    Attributes:
        plant: Plant at the start; any plant whose state is a named tuple.
        changes: Changes.
    """

    plant: Any
    changes: tuple[PlantChange, ...]

    @property
    def spacecraft(self) -> Spacecraft:
        """Body and wheels at the start of the run."""
        return self.plant.spacecraft

    @property
    def failures(self) -> Any:
        """Wheel failures at the start of the run; see `Gyrostat`."""
        return self.plant.failures

    def at(self, time: Scalar) -> Any:
        """Plant at a time, s."""
        plant = self.plant
        for change in self.changes:
            plant = change(plant, time)
        return plant

    def check_own(self) -> None:
        """Validate the plant after each change; raises `InputError`."""
        plant = self.plant
        for change in self.changes:
            plant = change(plant, np.inf)
            with placed(f"event {change.name}"):
                check_parts(plant)

    def start(self, **motion: Any) -> Any:
        """Create a state; for the arguments see `start` of the plant."""
        state = self.at(0.0).start(**motion)
        return with_fields("Changing", state, {"elapsed": jnp.zeros(())}, {"elapsed": "s"})

    def check_state(self, state: Any) -> None:
        """Validate a state; raises `InputError`."""
        if getattr(state, "elapsed", None) is None:
            raise InputError("elapsed: found none, expected a state made by start() of the plant")
        check_state = getattr(self.plant, "check_state", None)
        if check_state is not None:
            check_state(without_fields(state))

    def __call__(
        self, state: Any, command: Any, time: Scalar, duration: Scalar
    ) -> tuple[Any, Bool[Array, ""]]:
        """Integrate over an interval of constant command; see the plant."""
        times = jnp.stack([jnp.asarray(change.time, dtype=float) for change in self.changes])

        def piece(carried, part):
            state, fine = carried
            start, length = part
            after, resolved = self.at(time + start)(state, command, time + start, length)
            passes = length > 0.0
            after = jax.tree.map(lambda new, old: jnp.where(passes, new, old), after, state)
            return (after, fine & (resolved | ~passes)), None

        begun = (without_fields(state), jnp.array(True))
        (after, resolved), _ = jax.lax.scan(piece, begun, pieces(times, time, duration))
        return type(state)(*after, time + duration), resolved

    def rate(self, state: Any) -> Vector3:
        """Body rate in body axes, (3,), rad/s."""
        return self.at(state.elapsed).rate(without_fields(state))

    def balanced_rate(self, state: Any) -> Vector3:
        """Body rate without the jitter of wheel imbalance, in body axes, (3,), rad/s."""
        plant = self.at(state.elapsed)
        return getattr(plant, "balanced_rate", plant.rate)(without_fields(state))

    def diverged(self, state: Any) -> Any:
        """See `Gyrostat.diverged`."""
        return self.at(state.elapsed).diverged(without_fields(state))

    def record(self, state: Any, command: Any) -> Any:
        """Record of the plant."""
        return self.at(state.elapsed).record(without_fields(state), command)
