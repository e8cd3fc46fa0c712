"""Slews at given times."""

from dataclasses import dataclass

from gyrostat.control.guidance import Reference, Slews
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import normalised
from gyrostat.scenario.reference_kind import ReferenceCase, Slewing


@dataclass(frozen=True, eq=False)
class SlewsKind(Slewing):
    """Eigenaxis slews, one for each table [[reference.slew]], from the initial attitude.

    See `gyrostat.control.guidance.Slews`.
    """

    name = "slews"
    tables = "reference.slew"

    def reference(self, case: ReferenceCase) -> Reference:
        """See `ReferenceKind.reference`."""
        times = jnp.stack([jnp.asarray(slew.time) for slew in case.slews])
        targets = jnp.stack([normalised(slew.target) for slew in case.slews])
        limits, turns = self.limits(case), case.planned.turns
        return Reference.of(Slews.to(case.attitude, times, targets, limits, turns))
