"""A scenario as plain data: parts, values, events, dispersions and metrics.

Every number is in one mapping of keys to SI values ("wheel.a.coulomb"); a dispersion replaces some
of them in each run. `gyrostat.campaigns.kinds.numbers_of` gives the dimension and the bounds of
each. The other fields are the structure: they decide which numbers there are and what is compiled.
A scenario is stored and sent to other processes as text.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self

INERTIA = ("xx", "yy", "zz", "xy", "xz", "yz")
"""Ends of the keys of the body's inertia."""
AXES = ("x", "y", "z")
"""Ends of the keys of a vector."""


@dataclass(frozen=True)
class Event:
    """Something that happens during a run; the keys of its numbers start with "event.NAME.".

    Attributes:
        name: Name, as in keys.
        kind: Key of `gyrostat.campaigns.schema.EVENTS`.
        wheel: Number of the wheel that is affected, or None.
        target: (4,) Attitude to turn to, scalar first, or None.
        sensor: Measured field that is affected, or None.
        element: Number of the affected element of that field; None for all of them.
    """

    name: str
    kind: str
    wheel: int | None = None
    target: tuple[float, ...] | None = None
    sensor: str | None = None
    element: int | None = None


@dataclass(frozen=True)
class Dispersion:
    """Random variation of some values from run to run.

    Attributes:
        keys: Keys of the values, which are drawn together.
        distribution: "normal", "uniform" or "log_normal".
        spread: Normal: (keys, keys) matrix from standard normal numbers to deviations, SI;
            uniform: smallest and largest value of each key, SI; log_normal: standard deviation of
            the natural logarithm of each key.
    """

    keys: tuple[str, ...]
    distribution: str
    spread: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, eq=False)
class Scenario:
    """A scenario.

    Attributes:
        name: Name of the scenario.
        wheels: Names of the wheels, in their order.
        axes: (wheels, 3) Spin axes in body axes, unit length.
        friction: Name of the wheels' friction model.
        controller: Key of `gyrostat.campaigns.components.CONTROLLERS`.
        compensator: Key of `gyrostat.campaigns.components.COMPENSATORS`.
        sensors: Key of `gyrostat.campaigns.components.SENSORS`.
        estimator: Key of `gyrostat.campaigns.components.ESTIMATORS`.
        environment: Key of `gyrostat.campaigns.components.ENVIRONMENTS`.
        attitude: (4,) Attitude at the start, scalar first.
        target: (4,) Attitude to hold until an event gives another one.
        boresight: (3,) Body direction whose error counts; None: the whole attitude.
        count: Number of control periods.
        substeps: Integration steps in each control period.
        command_delay: Control periods from a sample to the start of its command.
        percentiles: Percentiles of the pointing error that are reported.
        events: Events in their nominal order of time.
        dispersions: Dispersions, independent of each other.
        values: Key -> number, SI, the keys in alphabetical order.
        guard: Command in place of one from a rejected sample, "hold" or "zero"; None: measurements
            are not validated.
    """

    name: str
    wheels: tuple[str, ...]
    axes: tuple[tuple[float, ...], ...]
    friction: str
    controller: str
    compensator: str
    sensors: str
    estimator: str
    environment: str
    attitude: tuple[float, ...]
    target: tuple[float, ...]
    boresight: tuple[float, ...] | None
    count: int
    substeps: int
    command_delay: int
    percentiles: tuple[float, ...]
    events: tuple[Event, ...]
    dispersions: tuple[Dispersion, ...]
    values: Mapping[str, float]
    guard: str | None = None

    @property
    def dispersed(self) -> tuple[str, ...]:
        """Keys that differ from run to run."""
        return tuple(key for dispersion in self.dispersions for key in dispersion.keys)

    @property
    def duration(self) -> float:
        """Duration of a run, s."""
        return self.count * self.values["run.control_period"]

    def __eq__(self, other: object) -> bool:
        """Whether two scenarios are the same, whatever their files are like."""
        return isinstance(other, Scenario) and self.text() == other.text()

    def __hash__(self) -> int:
        """Of its text."""
        return hash(self.text())

    def text(self) -> str:
        """The scenario as JSON, from which `from_text` makes the same one, bit by bit."""
        return json.dumps(asdict(self), ensure_ascii=False, sort_keys=True)

    def digest(self) -> str:
        """SHA-256 digest of the text; it tells this scenario from every other."""
        return hashlib.sha256(self.text().encode()).hexdigest()

    @classmethod
    def from_text(cls, text: str) -> Self:
        """The scenario of a text that `text` has made."""
        found = json.loads(text)
        found["events"] = tuple(Event(**_tuples(event)) for event in found["events"])
        found["dispersions"] = tuple(Dispersion(**_tuples(d)) for d in found["dispersions"])
        return cls(**{name: _tuples(value) for name, value in found.items()})


def _tuples(value: Any) -> Any:
    """Lists as tuples, however deep."""
    if isinstance(value, dict):
        return {key: _tuples(entry) for key, entry in value.items()}
    return tuple(map(_tuples, value)) if isinstance(value, list | tuple) else value
