"""Step changes of bearing friction during a run."""

from typing import Any

import equinox as eqx
import numpy as np

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.validation import check_parts
from gyrostat.wheel.array import listed
from gyrostat.wheel.friction import Friction


class FrictionSteps(eqx.Module):
    """The friction of each wheel is another from a time on, as when a lubricant gives out.

    Attributes:
        time: (wheels,) of the step, s; infinite: there is none.
        friction: from then on, of the model that the wheels have before; its parameters (wheels,).
    """

    time: PerWheel = eqx.field(converter=listed)
    friction: Friction

    def check(self) -> None:
        """Refuse times before the start or NaN, and friction that is none, by `InputError`."""
        time = np.asarray(self.time, dtype=float)
        if not np.all(time >= 0.0):
            odd = time[~(time >= 0.0)].flat[0]
            raise InputError(
                f"time of a friction step: found {odd:g} s, expected 0 s (the start) or later"
            )
        check_parts(self.friction)

    def check_wheels(self, wheels: Any) -> None:
        """Refuse steps of another number of wheels, or to another model, by `InputError`."""
        told = np.shape(self.time)[-1:]
        if told != (wheels.count,):
            raise InputError(
                f"friction steps: found times of shape {told}, expected ({wheels.count},)"
            )
        if type(self.friction) is not type(wheels.friction):
            raise InputError(
                f"friction steps: found {self.friction.name} friction, expected "
                f"{wheels.friction.name} as the wheels have"
            )

    def at(self, time: Scalar, before: Friction) -> Friction:
        """Friction at a time, s, of wheels that had another before their step."""
        done = jnp.asarray(self.time) <= time
        return jax.tree.map(lambda new, old: jnp.where(done, new, old), self.friction, before)
