"""Bases of the references and modes that a scenario can name."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Annotated, Any, ClassVar, NamedTuple, Self

from jaxtyping import Array

from gyrostat.control.guidance import (
    NEVER,
    Aim,
    Condition,
    Pointing,
    Profile,
    Reference,
    SlewLimits,
    WheelEnvelope,
)
from gyrostat.core.arrays import Quaternion, Scalar
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.component import Context, Kind, Need, Options
from gyrostat.scenario.schema import Key, positive, size
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.orbit.time_scales import Epoch

POSITION_ERROR = "reference.position_error"
"""Key of the error of the position that the reference of the controller is computed from."""
ERROR = Key(
    "length",
    None,
    "Error of the position, GCRS, from which the controller computes the reference.",
    shape=(3,),
    source="position error",
)
TARGET = Key("1", None, "Attitude, a quaternion, scalar first.", shape=(4,))
UNTIL: dict[str, Key] = {
    "until_time": size("time", 0.0, "End condition: least time since the start of the mode."),
    "until_rate_below": positive("speed", inf, "End condition: body rate below this value."),
    "until_momentum_above": Key(
        "momentum", -1.0, "End condition: total momentum above this value.", least=-1.0
    ),
    "until_error_below": positive("angle", inf, "End condition: pointing error below this value."),
    "until": Key(
        "1",
        0.0,
        "End condition, a text: `pass of NAME` or `end of pass of NAME`, a [[station]], `eclipse` "
        "or `sunlight`; `end of pass` also holds before a pass.",
    ),
}
"""Keys of the conditions under which a mode ends."""
_AUTO = '; none or `"auto"`: the fastest slew within the wheels.'


class PlannedReference(NamedTuple):
    """Part of a reference that is computed once for a scenario.

    Attributes:
        envelope: Torque and momentum of the working wheels; None if no slew needs it.
        tables: Place of a reference or mode with a file -> result of `ProfileKind.tabulated`.
        orbit: Orbit of the run; None without one.
        views: Views along the orbit that modes wait for; empty if none does.
    """

    envelope: WheelEnvelope | None
    tables: Mapping[str, Any]
    orbit: OrbitEnvironment | None = None
    views: tuple[Callable[[Scalar], Scalar], ...] = ()

    def pointing(self, aim: Aim, axis: Array, second: Array) -> Pointing:
        """Pointing of a body axis along the orbit."""
        assert self.orbit is not None  # the kind needs it
        return Pointing.of(self.orbit, aim, axis, second)


class ReferenceCase(NamedTuple):
    """What references are made of.

    Attributes:
        planned: Part that is computed once, with the momentum and the orbit of the run.
        attitude: Initial attitude of the scenario, (4,).
        modes: Attitude over time and end of each mode of a sequence.
        slews: Each [[reference.slew]], in their order in the file.
    """

    planned: PlannedReference
    attitude: Quaternion
    modes: Sequence[tuple[Profile, Condition]]
    slews: Sequence[Any]


@dataclass(frozen=True, eq=False)
class ReferenceKind(Kind):
    """Reference attitude of a whole run.

    Attributes:
        tables: List of tables that it is made of, and that no other reference may have.
        moves: Whether the reference replaces the target of the controller.
    """

    tables: ClassVar[str] = ""
    moves: ClassVar[bool] = True

    def reference(self, case: ReferenceCase) -> Reference | None:
        """Reference; None for the targets of the controller."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class Slewing(ReferenceKind):
    """Reference with slews within limits."""

    rate: Annotated[Scalar, positive("speed", inf, f"Largest rate of a slew{_AUTO}")]
    acceleration: Annotated[
        Scalar, positive("rad/s²", inf, f"Largest acceleration of a slew{_AUTO}")
    ]
    jerk: Annotated[Scalar, positive("rad/s³", inf, "Largest jerk of a slew.")]
    torque_share: Annotated[
        Scalar,
        positive("1", 0.8, "Fraction of the wheels' torque limits that slews may use.", most=1.0),
    ]
    momentum_share: Annotated[
        Scalar,
        positive("1", 0.9, "Fraction of the wheels' momentum limits that slews may use.", most=1.0),
    ]

    @classmethod
    def row(cls, row: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
        """See `Kind.row`: "auto" is the default of a limit."""
        keys = cls.keys()
        return {key: value for key, value in row.items() if key not in keys or value != "auto"}

    def limits(self, case: ReferenceCase) -> SlewLimits:
        """Limits of the slews."""
        return SlewLimits(self.rate, self.acceleration, self.jerk, case.planned.envelope)


@dataclass(frozen=True, eq=False)
class ProfileKind(ReferenceKind):
    """Attitude over time, of a whole run or of a mode."""

    def profile(self, planned: PlannedReference, place: str) -> Profile:
        """Attitude over time.

        Args:
            planned: Part of the reference that is computed once.
            place: Place of the reference or mode in the scenario.
        """
        raise NotImplementedError

    @classmethod
    def read_file(cls, where: str, text: str) -> Any:
        """Content of `file`, for a kind that has one.

        Args:
            where: Place for error messages, such as the name of the file.
            text: Content of the file.

        Raises:
            InputError: It is not what the kind needs.
        """
        raise NotImplementedError

    @classmethod
    def check_cover(cls, content: Any, where: str, duration: float) -> None:
        """Check that the content of the file of a whole run covers it.

        Args:
            content: Result of `read_file`.
            where: Place for error messages.
            duration: Duration of the run, s.

        Raises:
            InputError: It does not.
        """

    @classmethod
    def tabulated(cls, content: Any, span: Callable[[], tuple[Epoch, float]]) -> Any:
        """Table of which `profile` is made; by default the content of the file.

        Args:
            content: Result of `read_file`.
            span: Epoch of the run, and the time after it that all runs need, s; raises InputError
                if each run has an orbit of its own.
        """
        return content

    def reference(self, case: ReferenceCase) -> Reference:
        """See `ReferenceKind.reference`."""
        return Reference.of(self.profile(case.planned, "reference"))


@dataclass(frozen=True, eq=False)
class Mode:
    """Kind of [[reference.mode]]: an attitude over time, and when it ends; used as a `Kind` is.

    Attributes:
        attitude: Kind of the attitude over time, of this package or of a user.
        values: Values of the keys.
    """

    attitude: Any
    values: Options | None = None

    @property
    def texts(self) -> tuple[str, ...]:
        """See `Kind`."""
        return self.attitude.texts

    @property
    def needs(self) -> frozenset[Need]:
        """See `Kind`."""
        return self.attitude.needs

    @property
    def provides(self) -> frozenset[Need]:
        """See `Kind`."""
        return self.attitude.provides

    def keys(self) -> dict[str, Key]:
        """See `Kind.keys`."""
        return {**self.attitude.keys(), **UNTIL}

    def meaning(self) -> str:
        """See `Kind.meaning`."""
        return self.attitude.meaning()

    def row(self, row: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
        """See `Kind.row`: the view that the mode waits for, as a number."""
        completed = self.attitude.row(row, values)
        if "until" in row:
            completed["until"] = _number_of_view(row["until"], values)
        return completed

    def check(self, place: str, scenario: Any) -> None:
        """See `Kind.check`."""
        self.attitude.check(place, scenario)
        if scenario.orbit == "none" and scenario.values[f"{place}.until"] != 0.0:
            raise InputError(f"key {place}.until: found it without [orbit], expected an orbit")
        if f"{place}.until" in scenario.dispersed:
            raise InputError(f"key dispersion: found {place}.until, a text, expected a number")

    def of(self, options: Options) -> Self:
        """See `Kind.of`."""
        return type(self)(self.attitude, options)

    def make(self, context: Context) -> tuple[Profile, Condition]:
        """Attitude over time and its end."""
        assert self.values is not None
        options = {name: value for name, value in self.values.items() if name not in UNTIL}
        profile = self.attitude.of(options).profile(context.reference, context.place)
        return profile, _condition(self.values)


def _condition(options: Options) -> Condition:
    """Conditions of a mode; without any, it never ends."""
    values = [options[name] for name in UNTIL]
    is_set = [value != UNTIL[name].default for name, value in zip(UNTIL, values, strict=True)]
    after = jnp.where(jnp.any(jnp.stack(is_set)), values[0], NEVER.after)
    return Condition(after, *values[1:])


_VIEW = re.compile(r"\s*(end of\s+)?pass of\s+(\w+)\s*|\s*(eclipse|sunlight)\s*")


def _number_of_view(text: Any, values: Mapping[str, float]) -> float:
    """Number of a view, from 1: Sun, then stations; negative for its end.

    Raises:
        InputError: There is no such view.
    """
    stations = [key.split(".")[1] for key in values if re.fullmatch(r"station\.\w+\.latitude", key)]
    match = _VIEW.fullmatch(text) if isinstance(text, str) else None
    if match is not None and match[3] is not None:
        return 1.0 if match[3] == "sunlight" else -1.0
    if match is None or match[2] not in stations:
        known = [f"pass of {name}" for name in stations]
        raise InputError(
            f"until: found {text!r}, expected one of eclipse, sunlight, "
            f"{', '.join(known) or 'or the pass of a [[station]]'}, or the end of a pass"
        )
    number = 2.0 + stations.index(match[2])
    return -number if match[1] else number
