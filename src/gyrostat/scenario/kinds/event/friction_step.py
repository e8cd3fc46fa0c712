"""Change of a bearing's friction."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import FrictionChange
from gyrostat.scenario.schema import Key, Measured, friction_keys, size

if TYPE_CHECKING:
    from gyrostat.wheel.friction_laws import Law


@dataclass(frozen=True, eq=False)
class FrictionStep(FrictionChange):
    """The bearing friction of `wheel` changes; the controller is not notified.

    It is multiplied by `factor`, or parameters of the friction model, such as `coulomb`, get the
    values given here under their names.
    """

    name = "friction_step"
    factor: Annotated[
        Scalar,
        size("1", 1.0, "Factor on friction torques and viscous drag that are not given here."),
    ]
    rise_time: Annotated[
        Scalar, size("time", 0.0, "Time over which the friction changes linearly; 0: a step.")
    ]

    @classmethod
    def keys_of(
        cls, law: "Law", sensor: str | None, fields: Mapping[str, Measured]
    ) -> dict[str, Key]:
        """See `EventKind.keys_of`."""
        return super().keys_of(law, sensor, fields) | friction_keys(law)

    @classmethod
    def optional(cls, law: "Law") -> Collection[str]:
        """See `EventKind.optional`."""
        return law.dimensions()

    @classmethod
    def missing(cls, given: Collection[str], law: "Law") -> tuple[str, str] | None:
        """See `EventKind.missing`."""
        names = law.dimensions()
        if "factor" in given or any(name in names for name in given):
            return None
        return "factor", f"one, or values of {', '.join(names)}"

    def after(
        self, parameter: str, dimension: str, before: Scalar, values: Mapping[str, Scalar]
    ) -> Scalar:
        """See `FrictionChange.after`."""
        # the factor scales friction torques and drag, not the speeds of the friction curve
        factor = 1.0 if dimension == "speed" else self.factor
        return values.get(parameter, factor * before)
