"""Kind of [[reference.transition]]: a change from some modes to another one."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import inf
from typing import Any, ClassVar

from gyrostat.control.guidance import Condition, ModeChange
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.component import Context, Need, Options
from gyrostat.scenario.mode_kind import UNSET, check_view, number_of_view
from gyrostat.scenario.relation import Relation, less
from gyrostat.scenario.schema import Key, positive, size

CONDITIONS: dict[str, Key] = {
    "time_in_mode": size("time", 0.0, "Least time since the start of the mode."),
    "at": Key(
        "time",
        UNSET,
        "Time of the run from which it holds, in a mode that began before.",
        least=0.0,
    ),
    "error_above": Key("angle", UNSET, "Pointing error above this value.", least=0.0),
    "error_below": positive(
        "angle", inf, "Pointing error below this value, after the slew to the mode."
    ),
    "rate_above": Key("speed", UNSET, "Body rate above this value.", least=0.0),
    "rate_below": positive("speed", inf, "Body rate below this value, after the slew to the mode."),
    "momentum_above": Key("momentum", UNSET, "Total momentum above this value.", least=0.0),
    "momentum_below": positive("momentum", inf, "Total momentum below this value."),
    "wheel_momentum_above": Key(
        "momentum", UNSET, "Momentum of all wheels together above this value.", least=0.0
    ),
    "wheel_momentum_below": positive(
        "momentum", inf, "Momentum of all wheels together below this value."
    ),
    "wheels_lost": size(
        "1", 0.0, "Least number of wheels that the controller takes to have failed (`works`)."
    ),
    "tracker_lost": size("time", 0.0, "Time without a measurement of the attitude, at least this."),
    "when": Key(
        "1",
        0.0,
        "A text: `pass of NAME` or `end of pass of NAME`, a [[station]], `eclipse` or `sunlight`.",
        is_text=True,
    ),
    "held": size("time", 0.0, "Time for which all conditions must have held together."),
}
"""Keys of the conditions of a change of mode."""
PAIRS = ("error", "rate", "momentum", "wheel_momentum")
"""Quantities that have conditions above and below a value."""
_TOGETHER = "expected conditions that can hold together"


@dataclass(frozen=True, eq=False)
class Transition:
    """Change to a mode when all of its conditions hold; used as a `Kind` is.

    It starts in the modes `from`, one or a list; without it, in every mode but `to`. At each
    sample, transitions are tested in the order of the file, the `until` of modes after them; the
    first that holds is taken. `python = "FILE.py:NAME"` names a further condition, which gets the
    measurement and the time, s, and returns a number above 0 while it holds. It is the default.

    Attributes:
        user: Component of the further condition, of this package or of a user; None: there is none.
        values: Values of the keys.
    """

    user: Any = None
    values: Options | None = None
    name: ClassVar[str] = "conditions"
    texts: ClassVar[tuple[str, ...]] = ()
    links: ClassVar[Mapping[str, str]] = {"to": "reference.mode", "from": "reference.mode"}
    provides: ClassVar[frozenset[Need]] = frozenset()

    @property
    def needs(self) -> frozenset[Need]:
        """See `Kind`."""
        return frozenset() if self.user is None else self.user.needs

    def keys(self) -> dict[str, Key]:
        """See `Kind.keys`."""
        return {**({} if self.user is None else self.user.keys()), **CONDITIONS}

    def meaning(self) -> str:
        """See `Kind.meaning`."""
        if self.user is not None:
            return self.user.meaning()
        text = type(self).__doc__ or ""
        return " ".join(text.partition("Attributes:")[0].split())

    def defaults(self, values: Mapping[str, float], delay: int) -> Mapping[str, float]:
        """See `Kind.defaults`."""
        return {}

    def row(self, row: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
        """See `Kind.row`: the view that it waits for, as a number."""
        completed = dict(row)
        if "when" in row:
            completed["when"] = number_of_view(row["when"], values, "when")
        return completed

    def check(self, place: str, scenario: Any) -> None:
        """See `Kind.check`.

        Raises:
            InputError: It has no condition at all, or one on a view without an orbit.
        """
        check_view(f"{place}.when", scenario)
        without = [key for key in CONDITIONS if key != "held"]
        values = scenario.values
        set_keys = [k for k in without if values[f"{place}.{k}"] != CONDITIONS[k].default]
        if self.user is None and not set_keys:
            raise InputError(
                f"key {place}: found no condition, expected one or more of {', '.join(without)}"
            )

    def relations(self, place: str, scenario: Any) -> Iterator[Relation]:
        """See `Kind.relations`: the conditions can hold together, each quantity by itself."""
        for name in PAIRS:
            above, below = (f"{place}.{name}_{end}" for end in ("above", "below"))
            found = f"{name}_above {{{above}}} and {name}_below {{{below}}}"
            yield less(above, below, f"{place}: found {found}, {_TOGETHER}")
        lost, wheels = f"{place}.wheels_lost", len(scenario.wheels)
        text = f"{place}: found wheels_lost {{{lost}}} of {wheels} wheels, {_TOGETHER}"
        yield Relation((lost,), text, lambda values: values[lost] <= wheels)
        at = f"{place}.at"
        text = f"{place}: found at 0 s, before which no mode can begin, {_TOGETHER}"
        yield Relation((at,), text, lambda values: values[at] != 0.0)

    def of(self, options: Options) -> "Transition":
        """See `Kind.of`."""
        return type(self)(self.user, options)

    def make(self, context: Context) -> ModeChange:
        """Change of mode; its modes are set by the reference."""
        assert self.values is not None
        options = dict(self.values)
        conditions = {name: options.pop(name) for name in CONDITIONS}
        after, view = conditions.pop("time_in_mode"), conditions.pop("when")
        below = conditions["error_below"], conditions["rate_below"]
        reached = jnp.asarray(jnp.isfinite(below[0]) | jnp.isfinite(below[1]), dtype=float)
        condition = Condition(after=after, view=view, reached=reached, **conditions)
        user = None if self.user is None else self.user.of(options).make(context)
        return ModeChange(0, condition, None, user)
