"""Changes of bearing friction during a run."""

from typing import Annotated, Any

import equinox as eqx
import numpy as np

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, from_start, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel.array import listed
from gyrostat.wheel.friction import AnyFriction


class FrictionSteps(Checked):
    """Change of the friction of each wheel, as by a loss of lubricant: a step or a linear rise.

    Attributes:
        time: Times of the steps, (wheels,), s; infinite: no step.
        friction: Friction after the step, parameters (wheels,); the same model as before.
        duration: Time over which the parameters change linearly, (wheels,) or one for all, s; 0: a
            step. A rise is constant within an integration step.
    """

    time: Annotated[PerWheel, from_start("time of a friction step")] = eqx.field(converter=listed)
    friction: AnyFriction
    duration: Annotated[PerWheel | float, size("duration of a friction step", "s")] = eqx.field(
        converter=listed, default=0.0
    )

    def check_wheels(self, wheels: Any) -> None:
        """Validate the number of wheels and the friction model; raises `InputError`."""
        shape = np.shape(self.time)[-1:]
        if shape != (wheels.count,):
            raise InputError(
                f"friction steps: found times of shape {shape}, expected ({wheels.count},)"
            )
        if type(self.friction) is not type(wheels.friction):
            raise InputError(
                f"friction steps: found {self.friction.name} friction, expected "
                f"{wheels.friction.name} as the wheels have"
            )

    def at(self, time: Scalar, before: Any) -> Any:
        """Friction at a time, s, from the friction `before` the steps."""
        elapsed, length = time - jnp.asarray(self.time), jnp.asarray(self.duration)
        is_over = elapsed >= length
        share = jnp.clip(elapsed / jnp.where(length > 0.0, length, 1.0), 0.0, 1.0)
        return jax.tree.map(
            lambda new, old: jnp.where(is_over, new, old + share * (new - old)),
            self.friction,
            before,
        )
