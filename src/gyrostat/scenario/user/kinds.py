"""Components that a scenario makes of a user's classes and functions."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, ClassVar, Self

from gyrostat.control.guidance import Reference
from gyrostat.scenario.component import ORBIT, Context, Need, Options
from gyrostat.scenario.controller_kind import IGNORED, Beginning, DesignCase
from gyrostat.scenario.mode_kind import Mode
from gyrostat.scenario.reference_kind import PlannedReference, ReferenceCase
from gyrostat.scenario.relation import Relation
from gyrostat.scenario.scenario import Scenario, Source
from gyrostat.scenario.schema import Key
from gyrostat.scenario.transition_kind import Transition
from gyrostat.scenario.user.control import UserControl
from gyrostat.scenario.user.metric import UserMetric
from gyrostat.scenario.user.parts import UserPart, user_part
from gyrostat.scenario.user.world import (
    UserActuator,
    UserChange,
    UserCondition,
    UserProfile,
    UserSensor,
    UserTorque,
)
from gyrostat.spacecraft import Spacecraft


@dataclass(frozen=True)
class UserKind:
    """Component of a user's class or function, used as a `gyrostat.scenario.component.Kind` is.

    Attributes:
        part: The class or function.
        values: Values of its keys, SI.
    """

    part: UserPart
    values: Options = field(default_factory=dict)
    texts: ClassVar[tuple[str, ...]] = ()
    links: ClassVar[Mapping[str, str]] = {}
    provides: ClassVar[frozenset[Need]] = frozenset()

    @property
    def name(self) -> str:
        """See `Kind`: "FILE.py:NAME"."""
        return self.part.name.rpartition(" ")[2]

    @property
    def needs(self) -> frozenset[Need]:
        """See `Kind`."""
        return frozenset({ORBIT}) if "orbit" in self.part.fields else frozenset()

    @property
    def unit(self) -> str:
        """See `Kind`."""
        unit = getattr(self.part.made, "unit", "1")
        return unit if isinstance(unit, str) else "1"

    def keys(self) -> Mapping[str, Key]:
        """See `Kind.keys`."""
        return self.part.keys

    def meaning(self) -> str:
        """First line of its docstring."""
        return (inspect.getdoc(self.part.made) or self.part.name).partition("\n")[0]

    def defaults(self, values: Mapping[str, float], delay: int) -> Mapping[str, float]:
        """See `Kind.defaults`."""
        return {}

    def row(self, row: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
        """See `Kind.row`."""
        return dict(row)

    def check(self, place: str, scenario: Scenario) -> None:
        """See `Kind.check`."""

    def relations(self, place: str, scenario: Scenario) -> tuple[Relation, ...]:
        """See `Kind.relations`."""
        return ()

    def of(self, options: Options) -> Self:
        """See `Kind.of`."""
        return replace(self, values=options)


class UserControllerKind(UserKind):
    """Controller of a user; see `gyrostat.scenario.controller_kind.ControllerKind`."""

    losses = IGNORED
    follows = True

    def plan(self, case: DesignCase) -> Spacecraft:
        """See `ControllerKind.plan`."""
        return case.spacecraft

    def controller(self, design: Spacecraft, beginning: Beginning) -> UserControl:
        """See `ControllerKind.controller`."""
        inner = self.part.build(self.values, spacecraft=design, reference=None, orbit=None)
        return UserControl(inner, self.part.name, design.wheels.count)

    def body(self, plant: Any) -> Any:
        """See `ControllerKind.body`."""
        return plant


class UserWrappingKind(UserKind):
    """Compensator or estimator of a user."""

    def make(self, context: Context) -> UserControl:
        """Part around the controller."""
        spacecraft = context.spacecraft
        assert spacecraft is not None
        fields = {"controller": context.controller, "spacecraft": spacecraft, "orbit": None}
        inner = self.part.build(self.values, **fields)
        return UserControl(inner, self.part.name, spacecraft.wheels.count)


@dataclass(frozen=True)
class UserWorldKind(UserKind):
    """Torque, sensor, actuator, event or metric of a user.

    Attributes:
        wrapper: Class of `gyrostat.scenario.user.world` or `gyrostat.scenario.user.metric`.
    """

    wrapper: Callable[[Any, str], Any] = field(kw_only=True)

    def make(self, context: Context) -> Any:
        """Part of the run."""
        world = {
            name: value
            for name in ("spacecraft", "orbit", "plant")
            if (value := getattr(context, name)) is not None
        }
        return self.wrapper(self.part.build(self.values, **world), f"{context.place} {self.name}")


class UserAttitudeKind(UserKind):
    """Attitude over time of a user; see `gyrostat.scenario.reference_kind.ProfileKind`."""

    tables = ""
    moves = True

    def profile(self, planned: PlannedReference, place: str) -> UserProfile:
        """See `ProfileKind.profile`."""
        return UserProfile(self.part.build(self.values, orbit=planned.orbit), self.part.name)

    def reference(self, case: ReferenceCase) -> Reference:
        """See `ReferenceKind.reference`."""
        return Reference.of(self.profile(case.planned, "reference"))


TORQUE = "which returns a torque in body axes (3,), N·m"


def _wrapping(part: UserPart) -> UserWrappingKind:
    """Compensator or estimator."""
    part = part.with_methods(**CONTROL)
    if "controller" not in part.fields:
        raise part.refuse("no field controller", "it, for the controller that the part wraps")
    return UserWrappingKind(part)


CONTROL = {
    "start": "(period), which returns the memory",
    "__call__": "(memory, measurement), which returns (memory, command)",
}
"""Methods of a controller, compensator or estimator."""


def _in_world(wrapper: Callable[[Any, str], Any], call: str, **methods: str) -> Any:
    """Function that makes the component of a torque, sensor, actuator, event or metric.

    Args:
        wrapper: See `UserWorldKind`.
        call: Arguments and result of the part.
        methods: Other methods of the part; without any, it can be a function.
    """

    def component(part: UserPart) -> UserWorldKind:
        if methods or inspect.isclass(part.made):
            part = part.with_methods(**methods, __call__=call)
        return UserWorldKind(part, wrapper=wrapper)

    return component


def _actuator(part: UserPart) -> UserWorldKind:
    """Actuator, with a state if its class has a method `start`."""
    if not hasattr(part.made, "start"):
        return _in_world(UserTorque, f"(value, attitude, time), {TORQUE}")(part)
    make = _in_world(
        UserActuator,
        f"(state, value, attitude, time), {TORQUE}",
        start="(), which returns the state",
        advanced="(state, value, elapsed), which returns the state",
    )
    return make(part)


def _attitude(part: UserPart) -> UserAttitudeKind:
    if inspect.isclass(part.made):
        part = part.with_methods(__call__="(time), which returns a quaternion (4,)")
    return UserAttitudeKind(part)


USER_KINDS: dict[str, Callable[[UserPart], Any]] = {
    "controller": lambda part: UserControllerKind(part.with_methods(**CONTROL)),
    "compensator": _wrapping,
    "estimator": _wrapping,
    "reference": _attitude,
    "reference.mode": lambda part: Mode(_attitude(part)),
    "reference.transition": lambda part: Transition(
        _in_world(UserCondition, "(measurement, time), which returns a number")(part)
    ),
    "controller.law": lambda part: UserControllerKind(part.with_methods(**CONTROL)),
    "environment.torque": _in_world(UserTorque, f"(spacecraft, attitude, time), {TORQUE}"),
    "actuator": _actuator,
    "event": _in_world(UserChange, "(plant), which returns the plant with other numbers"),
    "sensor": _in_world(
        UserSensor,
        "(memory, state, key), which returns (memory, value)",
        start="(state, period), which returns the memory",
    ),
    "metric": _in_world(
        UserMetric,
        "(memory, sample), which returns the memory",
        result="(memory), which returns a number",
    ),
}
"""Section of a scenario -> function that makes the component of a user-defined part."""


@lru_cache(maxsize=64)
def user_component(section: str, kind: str, sources: tuple[Source, ...]) -> Any:
    """Component of a section from a user's Python file.

    Raises:
        InputError: See `user_part`.
    """
    return USER_KINDS[section](user_part(section, kind, sources))
