"""Step changes of bearing friction during a run."""

from typing import Annotated, Any

import equinox as eqx
import numpy as np

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, from_start
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel.array import listed
from gyrostat.wheel.friction import Friction, LuGre


class FrictionSteps(Checked):
    """Step change of the friction of each wheel, as by a loss of lubricant.

    Attributes:
        time: Times of the steps, (wheels,), s; infinite: no step.
        friction: Friction after the step, parameters (wheels,); the same model as before.
    """

    time: Annotated[PerWheel, from_start("time of a friction step")] = eqx.field(converter=listed)
    friction: Friction | LuGre

    def check_wheels(self, wheels: Any) -> None:
        """Validate the number of wheels and the friction model; raises `InputError`."""
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

    def at(self, time: Scalar, before: Any) -> Any:
        """Friction at a time, s, from the friction `before` the steps."""
        done = jnp.asarray(self.time) <= time
        return jax.tree.map(lambda new, old: jnp.where(done, new, old), self.friction, before)
