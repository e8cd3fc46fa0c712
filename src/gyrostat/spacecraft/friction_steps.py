"""Step changes of bearing friction during a run."""

from typing import Annotated, Any

import equinox as eqx
import numpy as np

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, from_start
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel.array import listed
from gyrostat.wheel.friction import Friction


class FrictionSteps(Checked):
    """The friction of each wheel is another from a time on, as when a lubricant gives out.

    Attributes:
        time: (wheels,) of the step, s; infinite: there is none.
        friction: from then on, of the model that the wheels have before; its parameters (wheels,).
    """

    time: Annotated[PerWheel, from_start("time of a friction step")] = eqx.field(converter=listed)
    friction: Friction

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
