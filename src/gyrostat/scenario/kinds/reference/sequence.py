"""Modes that change by conditions."""

from dataclasses import dataclass

from gyrostat.control.guidance import Reference
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.reference_kind import ReferenceCase, Slewing


@dataclass(frozen=True, eq=False)
class Sequence(Slewing):
    """Modes, one for each table [[reference.mode]], which follow each other by their `until`.

    Each [[reference.transition]] leads from any mode to any other. See
    `gyrostat.control.guidance.Reference`. The limits are those of the rotation from mode to mode.
    """

    name = "sequence"
    tables = "reference.mode"

    def reference(self, case: ReferenceCase) -> Reference:
        """See `ReferenceKind.reference`."""
        envelope = case.planned.envelope
        return Reference.branching(
            [mode.profile for mode in case.modes],
            case.changes,
            dwell=jnp.stack([jnp.asarray(mode.dwell, dtype=float) for mode in case.modes]),
            limits=self.limits(case),
            spacecraft=None if envelope is None else envelope.spacecraft,
            views=case.planned.views,
            planned=case.planned.turns,
        )
