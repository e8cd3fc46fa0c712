"""Target attitude of the controller."""

from dataclasses import dataclass

from gyrostat.scenario.reference_kind import ReferenceCase, ReferenceKind


@dataclass(frozen=True, eq=False)
class FixedReference(ReferenceKind):
    """The target attitude of the controller, which events of the kind `slew` change.

    It is without rate and acceleration.
    """

    name = "fixed"
    moves = False

    def reference(self, case: ReferenceCase) -> None:
        """See `ReferenceKind.reference`."""
