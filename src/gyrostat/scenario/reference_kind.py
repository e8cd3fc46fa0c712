"""Bases of the references and modes that a scenario can name."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Annotated, Any, ClassVar, NamedTuple

from jaxtyping import Array

from gyrostat.control.guidance import (
    Aim,
    Condition,
    ModeChange,
    PlannedTurns,
    Pointing,
    Profile,
    Reference,
    SlewLimits,
    WheelEnvelope,
)
from gyrostat.control.guidance.pointing import PARALLEL
from gyrostat.core.arrays import Quaternion, Scalar
from gyrostat.scenario.component import Kind
from gyrostat.scenario.relation import Relation
from gyrostat.scenario.schema import Key, positive, size
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.orbit.time_scales import Epoch
from gyrostat.spacecraft.sensors.keep_out import KeepOut

AROUND = "keep_out"
"""Key of a mode or slew with the names of the [[keep_out]] that the slew to it leads around."""
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
_AUTO = '; none or `"auto"`: the fastest slew within the wheels.'


class PlannedReference(NamedTuple):
    """Part of a reference that is computed once for a scenario.

    Attributes:
        envelope: Torque and momentum of the working wheels; None if no slew needs it.
        tables: Place of a reference or mode with a file -> result of `ProfileKind.tabulated`.
        orbit: Orbit of the run; None without one.
        views: Views along the orbit that modes wait for; empty if none does.
        turns: Slews that lead around cones, see `Reference.planned` and `Slews.to`; None: none is
            to.
        keep_outs: Instruments of these cones in a run.
        kept: Which of them the slew to each mode keeps, 1 or 0, (modes, instruments).
        measured: Whether a slew from each mode starts at the measured attitude.
    """

    envelope: WheelEnvelope | None
    tables: Mapping[str, Any]
    orbit: OrbitEnvironment | None = None
    views: tuple[Callable[[Scalar], Scalar], ...] = ()
    turns: PlannedTurns | None = None
    keep_outs: tuple[KeepOut, ...] = ()
    kept: Any = None
    measured: tuple[bool, ...] = ()

    def pointing(self, aim: Aim, axis: Array, second: Array) -> Pointing:
        """Pointing of a body axis along the orbit."""
        assert self.orbit is not None  # the kind needs it
        return Pointing.of(self.orbit, aim, axis, second)


def axes_apart(place: str, names: Sequence[str]) -> Relation:
    """Relation of the body axes of a pointing, which are not parallel, see `axes_of`.

    Args:
        place: Place of the reference or mode in the scenario.
        names: Names of the first axis and of those whose sum is the second one.
    """
    axes = [[f"{place}.{name}.{axis}" for axis in "xyz"] for name in names]

    def holds(values: Mapping[str, Any]) -> Any:
        first, *others = ([values[key] for key in axis] for axis in axes)
        a, b = first, [sum(each) for each in zip(*others, strict=True)]
        across = [a[i] * b[j] - a[j] * b[i] for i, j in ((1, 2), (2, 0), (0, 1))]
        cross, *sizes = (sum(each * each for each in vector) for vector in (across, a, b))
        return cross > PARALLEL**2 * sizes[0] * sizes[1]

    return Relation(
        tuple(key for axis in axes for key in axis),
        f"{place}: found parallel body axes, expected axes with different directions",
        holds,
    )


class ModePart(NamedTuple):
    """Mode of a run.

    Attributes:
        profile: Attitude over time.
        until: Conditions under which the next mode follows.
        dwell: Least time in the mode, s.
        unloading: Whether the wheels are unloaded in it, 0 or 1.
    """

    profile: Profile
    until: Condition
    dwell: Scalar
    unloading: Scalar


class ReferenceCase(NamedTuple):
    """What references are made of.

    Attributes:
        planned: Part that is computed once, with the momentum and the orbit of the run.
        attitude: Initial attitude of the scenario, (4,).
        modes: Each mode of a sequence.
        changes: Changes from mode to mode, in the order in which they are tested.
        slews: Each [[reference.slew]], in their order in the file.
    """

    planned: PlannedReference
    attitude: Quaternion
    modes: Sequence["ModePart"]
    slews: Sequence[Any]
    changes: Sequence[ModeChange] = ()


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
    keep_out_margin: Annotated[
        Scalar,
        size("angle", 0.01, "Angle that slews with `keep_out` keep beside that of [[keep_out]]."),
    ]
    crossing_time: Annotated[
        Scalar,
        size("time", 0.0, "Time that such a slew may lose to keep a wheel from passing zero."),
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
