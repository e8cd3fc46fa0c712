"""Kind of [[reference.mode]]: an attitude over time, when it ends, and what a mode chooses."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import inf
from typing import Any, ClassVar, Self

from gyrostat.control.guidance import NEVER, Condition
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.component import Context, Need, Options
from gyrostat.scenario.reference_kind import AROUND, ModePart
from gyrostat.scenario.relation import Relation
from gyrostat.scenario.scenario import KEEP_OUT
from gyrostat.scenario.schema import Key, positive, size

UNSET = -1.0
"""Value of a lower limit that is not given; a given one is 0 or more."""
UNTIL: dict[str, Key] = {
    "until_time": size("time", 0.0, "End condition: least time since the start of the mode."),
    "until_rate_below": positive("speed", inf, "End condition: body rate below this value."),
    "until_momentum_above": Key(
        "momentum", UNSET, "End condition: total momentum above this value.", least=0.0
    ),
    "until_error_below": positive("angle", inf, "End condition: pointing error below this value."),
    "until": Key(
        "1",
        0.0,
        "End condition, a text: `pass of NAME` or `end of pass of NAME`, a [[station]], `eclipse` "
        "or `sunlight`; `end of pass` also holds before a pass.",
        is_text=True,
    ),
}
"""Keys of the conditions under which a mode ends."""
IN_MODE: dict[str, Key] = {
    "minimum_dwell": size("time", 0.0, "Least time in the mode."),
    "unloading": size(
        "1", 1.0, "Whether `[unloading]` acts in the mode, 1 or 0; or true or false.", most=1.0
    ),
}
"""Keys of what a mode chooses beside its attitude."""


@dataclass(frozen=True, eq=False)
class Mode:
    """Kind of [[reference.mode]]: an attitude over time, and when it ends; used as a `Kind` is.

    Attributes:
        attitude: Kind of the attitude over time, of this package or of a user.
        values: Values of the keys.
    """

    attitude: Any
    values: Options | None = None
    links: ClassVar[Mapping[str, str]] = {"law": "controller.law", AROUND: KEEP_OUT}

    def defaults(self, values: Mapping[str, float], delay: int) -> Mapping[str, float]:
        """See `Kind.defaults`."""
        return {}

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
        return {**self.attitude.keys(), **UNTIL, **IN_MODE}

    def meaning(self) -> str:
        """See `Kind.meaning`."""
        return self.attitude.meaning()

    def row(self, row: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
        """See `Kind.row`: the view that the mode waits for, as a number."""
        completed = self.attitude.row(row, values)
        if "until" in row:
            completed["until"] = number_of_view(row["until"], values)
        if isinstance(row.get("unloading"), bool):
            completed["unloading"] = float(row["unloading"])
        return completed

    def check(self, place: str, scenario: Any) -> None:
        """See `Kind.check`."""
        self.attitude.check(place, scenario)
        check_view(f"{place}.until", scenario)

    def relations(self, place: str, scenario: Any) -> Iterable[Relation]:
        """See `Kind.relations`."""
        return self.attitude.relations(place, scenario)

    def of(self, options: Options) -> Self:
        """See `Kind.of`."""
        return type(self)(self.attitude, options)

    def make(self, context: Context) -> ModePart:
        """Mode of a run."""
        assert self.values is not None
        others = (*UNTIL, *IN_MODE)
        options = {name: value for name, value in self.values.items() if name not in others}
        profile = self.attitude.of(options).profile(context.reference, context.place)
        in_mode = (self.values[name] for name in IN_MODE)
        return ModePart(profile, _condition(self.values), *in_mode)


def check_view(key: str, scenario: Any) -> None:
    """Check a condition on a view; raises `InputError` without an orbit, or if it is dispersed."""
    if scenario.orbit == "none" and scenario.values[key] != 0.0:
        raise InputError(f"key {key}: found it without [orbit], expected an orbit")
    if key in scenario.dispersed:
        raise InputError(f"key dispersion: found {key}, a text, expected a number")


def _condition(options: Options) -> Condition:
    """Conditions of a mode; without any, it never ends."""
    values = [options[name] for name in UNTIL]
    is_set = [value != UNTIL[name].default for name, value in zip(UNTIL, values, strict=True)]
    after = jnp.where(jnp.any(jnp.stack(is_set)), values[0], NEVER.after)
    return Condition(after, *values[1:])


_VIEW = re.compile(r"\s*(end of\s+)?pass of\s+(\w+)\s*|\s*(eclipse|sunlight)\s*")


def number_of_view(text: Any, values: Mapping[str, float], key: str = "until") -> float:
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
            f"{key}: found {text!r}, expected one of eclipse, sunlight, "
            f"{', '.join(known) or 'or the pass of a [[station]]'}, or the end of a pass"
        )
    number = 2.0 + stations.index(match[2])
    return -number if match[1] else number
