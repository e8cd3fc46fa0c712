"""Bases of the kinds of events, whose classes are in kinds/event."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Any, ClassVar, Self

from gyrostat.core.annotations import notes_of
from gyrostat.core.arrays import Scalar
from gyrostat.scenario.schema import EVENT_TIME, Key, Measured, size

if TYPE_CHECKING:
    from gyrostat.wheel.friction_laws import Law

DETECTED = size(
    "time",
    1.0,
    "Time until the failure is notified; an error for a controller that is not notified.",
)
ADDED_DRAG = size("viscous", 0.0, "Viscous drag added to the bearing.")
UNTIL = size("time", inf, "End of the fault.")
SHARE = size("1", 1.0, "Probability that a sample is affected.", most=1.0)


@dataclass(frozen=True, eq=False)
class EventKind:
    """Kind of event; the docstring of a subclass is its documentation.

    The fields of a subclass are its keys beside the time, as those of
    `gyrostat.scenario.component.Kind`; None where an event need not have one.

    Attributes:
        name: Name in scenario files.
        affects: Key that names what it affects: "target", "wheel" or "sensor".
        changes_target: Whether it gives the controller another target.
        loses_wheel: Whether a controller that knows of it no longer uses the wheel.
        stops_rotor: Whether the rotor of the wheel is fixed to the body.
    """

    name: ClassVar[str]
    affects: ClassVar[str] = ""
    changes_target: ClassVar[bool] = False
    loses_wheel: ClassVar[bool] = False
    stops_rotor: ClassVar[bool] = False

    @classmethod
    def keys(cls) -> dict[str, Key]:
        """Name of each number beside the time -> its key."""
        return notes_of(cls, Key)

    @classmethod
    def of(cls, options: Mapping[str, Any]) -> Self:
        """Event with the values of its keys, SI."""
        return cls(**{name: options.get(name) for name in notes_of(cls, Key)})

    @classmethod
    def keys_of(
        cls, law: "Law", sensor: str | None, fields: Mapping[str, Measured]
    ) -> dict[str, Key]:
        """All numbers of an event of this kind.

        Args:
            law: Friction law of the wheels.
            sensor: Affected measured field, or None.
            fields: Measured fields, see `gyrostat.scenario.schema.MEASURED`.
        """
        return {"time": EVENT_TIME, **cls.keys()}

    @classmethod
    def suits(cls, field: Measured) -> bool:
        """Whether it can affect a measured field, see `gyrostat.scenario.schema.MEASURED`."""
        return True

    @classmethod
    def optional(cls, law: "Law") -> Collection[str]:
        """Numbers that an event need not have, and that have no default."""
        return ()

    @classmethod
    def missing(cls, given: Collection[str], law: "Law") -> tuple[str, str] | None:
        """Key that must be given beside these ones, and what is expected; None if all are."""
        return None


class WheelFailure(EventKind):
    """Failure of a wheel; a wheel can have one."""

    affects = "wheel"

    def effect(self) -> dict[str, Any]:
        """Changed fields of `gyrostat.spacecraft.WheelFailures`, but for time, drag, `seized`."""
        return {}


class FrictionChange(EventKind):
    """Change of the friction of a wheel, beside its failure; a wheel can have one."""

    affects = "wheel"

    def after(
        self, parameter: str, dimension: str, before: Scalar, values: Mapping[str, Scalar]
    ) -> Scalar:
        """Parameter of the friction law after the change.

        Args:
            parameter: Name of the parameter.
            dimension: Its dimension.
            before: Its value before the change, SI.
            values: Numbers of the event with those of the friction law, SI.
        """
        raise NotImplementedError


class SensorFailure(EventKind):
    """Fault of a measured field.

    Attributes:
        fault: Kind of `gyrostat.spacecraft.SensorFault`.
    """

    affects = "sensor"
    fault: ClassVar[str]
