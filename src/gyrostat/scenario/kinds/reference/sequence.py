"""Modes that change by conditions."""

from dataclasses import dataclass

from gyrostat.control.guidance import Around, Reference
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.reference_kind import PlannedReference, ReferenceCase, Slewing


@dataclass(frozen=True, eq=False)
class Sequence(Slewing):
    """Modes, one for each table [[reference.mode]], which follow each other by their `until`.

    Each [[reference.transition]] leads from any mode to any other. See
    `gyrostat.control.guidance.Reference`. The limits are those of the rotation from mode to mode.
    """

    name = "sequence"
    tables = "reference.mode"

    def around(self, planned: PlannedReference) -> Around | None:
        """Instruments that turns keep from bright bodies; None: none are."""
        if planned.turns is None:
            return None
        kept = jnp.asarray(planned.kept)
        return Around(planned.keep_outs, kept, self.keep_out_margin, planned.measured)

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
            around=self.around(case.planned),
        )
