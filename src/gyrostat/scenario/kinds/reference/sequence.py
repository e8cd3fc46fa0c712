"""Modes that follow each other."""

from dataclasses import dataclass

from gyrostat.control.guidance import Reference
from gyrostat.scenario.reference_kind import ReferenceCase, Slewing


@dataclass(frozen=True, eq=False)
class Sequence(Slewing):
    """Modes that follow each other, one for each table [[reference.mode]].

    See `gyrostat.control.guidance.Reference`. The limits are those of the rotation from mode to
    mode.
    """

    name = "sequence"
    tables = "reference.mode"

    def reference(self, case: ReferenceCase) -> Reference:
        """See `ReferenceKind.reference`."""
        envelope = case.planned.envelope
        return Reference.sequence(
            *case.modes,
            limits=self.limits(case),
            spacecraft=None if envelope is None else envelope.spacecraft,
            views=case.planned.views,
        )
