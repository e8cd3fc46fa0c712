"""Scenario as plain data: components, values, events, dispersions and metrics.

A component is named by its kind: a name such as "three_axis" for a component of this package, or
"mission.py:EarthPointer" for a class or function of a user's Python file, whose text is part of the
scenario (`Scenario.sources`). `gyrostat.scenario.kinds.registry.component` finds both.

All numbers are in one mapping of keys, such as "wheel.a.coulomb", to SI values; a dispersion
replaces some of them in each run. `gyrostat.scenario.kinds.registry.numbers_of` gives the dimension
and the bounds of each. The other fields are the structure of the scenario: they determine which
numbers exist and what is compiled. A scenario is stored and sent to other processes as text.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self

from gyrostat.core.errors import InputError
from gyrostat.core.handed_down import handed_down
from gyrostat.core.pictured import Described
from gyrostat.core.user_modules import Source
from gyrostat.scenario.requirement import Requirement

INERTIA = ("xx", "yy", "zz", "xy", "xz", "yz")
"""Last parts of the keys of the body inertia."""
AXES = ("x", "y", "z")
"""Last parts of the keys of a vector."""
KEEP_OUT = "keep_out"
"""Section of the instruments that keep angles to bright bodies."""
LAW = "controller.law"
"""Section of the controllers that modes choose in place of [controller]."""
WINDOWS = "metrics.window"
"""Section of the windows of the metrics, which are no parts."""


@dataclass(frozen=True)
class Event(Described):
    """Event during a run: slew, failure or sensor fault; its keys start with "event.NAME.".

    Attributes:
        name: Name of the event, used in keys.
        kind: Kind, a key of `gyrostat.scenario.kinds.events.EVENTS`, or "FILE.py:NAME".
        wheel: Index of the affected wheel, or None.
        target: New target attitude, (4,), scalar first, or None.
        sensor: Affected measured field, or None.
        element: Index of the affected element of that field; None for all elements.
    """

    name: str
    kind: str
    wheel: int | None = None
    target: tuple[float, ...] | None = None
    sensor: str | None = None
    element: int | None = None


@dataclass(frozen=True)
class Dispersion(Described):
    """Random variation of some values from run to run.

    Attributes:
        keys: Keys of the values, which are drawn jointly.
        distribution: Name of a class in gyrostat.scenario.kinds.dispersion, such as "normal".
        parameters: Parameters of each key, in the order of that class, SI.
    """

    keys: tuple[str, ...]
    distribution: str
    parameters: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Window(Described):
    """Part of a run with metrics of its own; its keys start with "window.NAME.".

    Attributes:
        name: Name of the window, used in keys and in the names of its metrics.
        event: Event or slew of the reference from which its times are counted, or None.
        mode: Mode of the reference, from whose start its times are counted, or None.
        boresight: Body direction whose pointing error is evaluated, (3,); None: that of the
            scenario.
        propellant: Signal of the command or of the record whose integral is the propellant, kg/s,
            or None.
    """

    name: str
    event: str | None = None
    mode: str | None = None
    boresight: tuple[float, ...] | None = None
    propellant: str | None = None


@dataclass(frozen=True)
class Part:
    """Component of which a scenario can have any number; its keys start with "SECTION.NAME.".

    Attributes:
        section: Section of the scenario file, such as "environment.torque", "sensor", "actuator"
            or "metric"; or of the spacecraft file: "flexible", "hinged_panel" or "slosh".
        name: Name of the part, unique in its section.
        kind: Kind, see `gyrostat.scenario.kinds.registry.component`.
        links: Key that names other parts -> their names.
    """

    section: str
    name: str
    kind: str
    links: tuple[tuple[str, tuple[str, ...]], ...] = ()

    def linked(self, key: str) -> tuple[str, ...]:
        """Names of the parts that a key names; empty if it is not given."""
        return dict(self.links).get(key, ())


@dataclass(frozen=True, eq=False, kw_only=True)
class Components(Described):
    """Fields that a scenario and its structure have in common: what is compiled, without numbers.

    Attributes:
        wheels: Names of the wheels, in their order.
        axes: Spin axes in body axes, unit length, (wheels, 3).
        friction: Name of the friction model of the wheels.
        controller: Kind of the controller.
        compensator: Kind of the compensator.
        sensors: Kind of the sensors.
        estimator: Kind of the estimator.
        environment: Kind of the environment.
        boresight: Body direction whose pointing error is evaluated, (3,); None: full attitude.
        count: Number of control periods.
        substeps: Integration steps in each control period.
        command_delay: Control periods from a sample to the start of its command.
        events: Events in their nominal order of time.
        guard: Command after a rejected sample, "hold" or "zero"; None: measurements are not
            validated.
        reference: Kind of the reference attitude.
        parts: Further components, in the order of the file.
        sources: Python files of user-defined parts, the local modules that they import, and their
            data files, sorted by path.
        windows: Windows with metrics of their own.
        orbit: Kind of the orbit.
        unloading: Kind of the unloading of the wheels.
        surfaces: Outer facets of the spacecraft: area, m², outward normal, (3,), centre, (3,), m,
            fractions of specular and of diffuse reflection, (facets, 9).
        budget: Whether the momentum that each external torque adds is a metric.
    """

    wheels: tuple[str, ...]
    axes: tuple[tuple[float, ...], ...]
    friction: str
    controller: str
    compensator: str
    sensors: str
    estimator: str
    environment: str
    boresight: tuple[float, ...] | None
    count: int
    substeps: int
    command_delay: int
    events: tuple[Event, ...]
    guard: str | None = None
    reference: str = "fixed"
    parts: tuple[Part, ...] = ()
    sources: tuple[Source, ...] = ()
    windows: tuple[Window, ...] = ()
    orbit: str = "none"
    unloading: str = "none"
    surfaces: tuple[tuple[float, ...], ...] = ()
    budget: bool = False


@dataclass(frozen=True, eq=False, kw_only=True)
class Scenario(Components):
    """Definition of a simulation or campaign, independent of its file format.

    Its other attributes are those of `gyrostat.scenario.scenario.Components`.

    Attributes:
        name: Name of the scenario.
        attitude: Initial attitude, before `start.attitude_error` is applied, (4,), scalar first.
        target: Initial target attitude, (4,), scalar first; events can change it.
        percentiles: Percentiles of the pointing error to report.
        dispersions: Dispersions, independent of each other.
        values: Key -> number, SI, with the keys in alphabetical order.
        texts: Texts that are no numbers, by their place: the tables of the reference attitude, by
            content, such as "reference.mode.NAME"; of the orbit, "orbit.epoch" and its elements;
            the versions of the packages that user-defined parts import, "package.NAME".
        requirements: Pointing requirements.
        field_of_view: Full angle of the field of view about the boresight, which the replay
            shows, rad; None: not shown.
    """

    name: str
    attitude: tuple[float, ...]
    target: tuple[float, ...]
    percentiles: tuple[float, ...]
    dispersions: tuple[Dispersion, ...]
    values: Mapping[str, float]
    texts: tuple[Source, ...] = ()
    requirements: tuple[Requirement, ...] = ()
    field_of_view: float | None = None

    @property
    def dispersed(self) -> tuple[str, ...]:
        """Keys whose values differ from run to run."""
        return tuple(key for dispersion in self.dispersions for key in dispersion.keys)

    @property
    def duration(self) -> float:
        """Duration of a run, s."""
        return self.count * self.values["run.control_period"]

    def __eq__(self, other: object) -> bool:
        """Whether two scenarios have the same content."""
        return isinstance(other, Scenario) and self.text() == other.text()

    def __hash__(self) -> int:
        """Hash of name and values; the text would take most of a millisecond in every block."""
        return hash((self.name, *self.values.values()))

    def replace(self, **changes: Any) -> "Scenario":
        """Scenario with changes, validated like a scenario that is read.

        Args:
            changes: Component of a section, as the name of its kind or as an object of an own
                class: `controller=EarthPointer(kp=0.02)`. Value of a key, SI or text with a unit:
                `**{"controller.kp": 0.03}`. Windows of the metrics, with their keys as in a
                scenario file: `windows={"imaging": {"from": 90.0}}`. Pointing requirements, with
                their keys: `requirements=[{"index": "APE", ...}]`. Attribute of `Scenario`:
                `name="other"`.

        Raises:
            InputError: There is no such section, key or attribute, or a value is not allowed.
        """
        return handed_down("replaced")(self, changes)

    def text(self) -> str:
        """Scenario as JSON text; `from_text` restores it exactly."""
        return json.dumps(asdict(self), ensure_ascii=False, sort_keys=True)

    def digest(self) -> str:
        """SHA-256 digest of the text; it identifies the scenario."""
        return hashlib.sha256(self.text().encode()).hexdigest()

    @classmethod
    def from_text(cls, text: str) -> Self:
        """Create a scenario from the result of `text`.

        Raises:
            InputError: Another version of gyrostat wrote the text.
        """
        fields = json.loads(text)
        try:
            for name, kind in _ROWS.items():
                fields[name] = tuple(kind(**_tuples(row)) for row in fields.get(name, ()))
            return cls(**{name: _tuples(value) for name, value in fields.items()})
        except TypeError as error:
            raise InputError(
                f"stored scenario {fields.get('name')!r}: found other attributes ({error}), "
                "expected those of this version of gyrostat: use the version that stored it"
            ) from None


_ROWS = {
    "events": Event,
    "dispersions": Dispersion,
    "parts": Part,
    "sources": Source,
    "texts": Source,
    "windows": Window,
    "requirements": Requirement,
}
"""Field of a scenario -> class of its entries."""


def _tuples(value: Any) -> Any:
    """Convert lists to tuples at any depth."""
    if isinstance(value, dict):
        return {key: _tuples(entry) for key, entry in value.items()}
    return tuple(map(_tuples, value)) if isinstance(value, list | tuple) else value
