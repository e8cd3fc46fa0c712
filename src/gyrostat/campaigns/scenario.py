"""A scenario as plain data: parts, values, events, dispersions and metrics.

Every number stands in one mapping of keys to SI values ("wheel.a.coulomb"); a dispersion replaces
some of them in each run. So a scenario is compared, kept and sent to other processes as text.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, Self

INERTIA = ("xx", "yy", "zz", "xy", "xz", "yz")
"""Ends of the keys of the body's inertia."""
AXES = ("x", "y", "z")
"""Ends of the keys of a vector."""


@dataclass(frozen=True)
class Event:
    """Something that happens during a run; its numbers stand under "event.NAME.".

    Attributes:
        name: in keys.
        kind: key of `gyrostat.campaigns.schema.EVENTS`.
        wheel: number of the wheel that it befalls, or None.
        target: (4,) attitude to turn to, scalar first, or None.
        sensor: measured field that it befalls, or None.
        element: number of the element of that field, or None for all of them.
    """

    name: str
    kind: str
    wheel: int | None = None
    target: tuple[float, ...] | None = None
    sensor: str | None = None
    element: int | None = None


@dataclass(frozen=True)
class Dispersion:
    """How some values scatter from run to run.

    Attributes:
        keys: of the values, drawn together.
        distribution: "normal", "uniform" or "log_normal".
        spread: normal: (keys, keys) matrix from standard normal numbers to deviations, SI;
            uniform: for each key the smallest and largest value, SI; log_normal: for each key the
            standard deviation of the natural logarithm.
    """

    keys: tuple[str, ...]
    distribution: str
    spread: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, eq=False)
class Scenario:
    """A scenario.

    Attributes:
        name: of the scenario.
        wheels: names of the wheels, in their order.
        axes: (wheels, 3) spin axes in body axes, unit length.
        friction: name of the wheels' friction model.
        controller: key of `gyrostat.campaigns.components.CONTROLLERS`.
        compensator: key of `gyrostat.campaigns.components.COMPENSATORS`.
        sensors: key of `gyrostat.campaigns.components.SENSORS`.
        estimator: key of `gyrostat.campaigns.components.ESTIMATORS`.
        environment: key of `gyrostat.campaigns.components.ENVIRONMENTS`.
        attitude: (4,) at the start, scalar first.
        target: (4,) attitude to hold until an event gives another.
        boresight: (3,) body direction whose error counts; None: the whole attitude.
        count: control periods.
        substeps: integration steps in each.
        command_delay: control periods from a sample to its command.
        percentiles: of the pointing error that are reported.
        events: in their order of time.
        dispersions: independent of each other.
        values: key -> number, SI.
        guard: command in place of one from a rejected sample, "hold" or "zero"; None: measurements
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
        """Of a run, s."""
        return self.count * self.values["run.control_period"]

    def __eq__(self, other: object) -> bool:
        """Whether two scenarios are the same, whatever their files are like."""
        return isinstance(other, Scenario) and self.text() == other.text()

    def __hash__(self) -> int:
        """Of its text."""
        return hash(self.text())

    def text(self) -> str:
        """Everything, as JSON that gives the same scenario bit by bit."""
        return self._text

    @cached_property
    def _text(self) -> str:
        return json.dumps(asdict(self), ensure_ascii=False, sort_keys=True)

    def digest(self) -> str:
        """SHA-256 digest of the text; it tells this scenario from every other."""
        return hashlib.sha256(self.text().encode()).hexdigest()

    @classmethod
    def from_text(cls, text: str) -> Self:
        """The scenario of a text that `text` gave."""
        found = json.loads(text)
        found["events"] = tuple(Event(**_tuples(event)) for event in found["events"])
        found["dispersions"] = tuple(Dispersion(**_tuples(d)) for d in found["dispersions"])
        return cls(**{name: _tuples(value) for name, value in found.items()})


def _tuples(value: Any) -> Any:
    """Lists as tuples, however deep."""
    if isinstance(value, dict):
        return {key: _tuples(entry) for key, entry in value.items()}
    return tuple(map(_tuples, value)) if isinstance(value, list | tuple) else value
