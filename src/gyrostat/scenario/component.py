"""Base of the components that a scenario can name, whose classes are in the folders of `kinds`."""

import inspect
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

from gyrostat.core.annotations import notes_of
from gyrostat.scenario.relation import Relation
from gyrostat.scenario.schema import Key

if TYPE_CHECKING:
    from gyrostat.core.arrays import Scalar
    from gyrostat.scenario.scenario import Scenario
    from gyrostat.spacecraft import Spacecraft
    from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment

Options = dict[str, Any]
"""Values of the keys of a component, SI: numbers, or arrays of the shape of the key."""


class Need(NamedTuple):
    """What a component can need, and others provide.

    Attributes:
        name: Name, for messages.
        expected: Where a scenario has it.
        places: Places of parts, such as "sensor.magnetometer", each of which provides it.
    """

    name: str
    expected: str
    places: frozenset[str] = frozenset()


def part_named(section: str, *names: str) -> Need:
    """Need of a part with one of these names in a list of tables, whatever its kind."""
    article = "an" if section.startswith("a") else "a"
    places = frozenset(f"{section}.{name}" for name in names)
    return Need(names[0], f"{article} [[{section}]] named {' or '.join(names)}", places)


ORBIT = Need("orbit", "a section [orbit]")
GYRO = Need("gyro", "sensors with a gyro")
STAR_TRACKER = Need("star tracker", "sensors with a star tracker")
SURFACES = Need("surfaces", "[box], [[panel]] or [[facet]] in the spacecraft file")
PADDLE = Need("paddle", "the controller two_wheels_paddle")
NULL_SPACE = Need("null-space control", "a wheel_array, which has a null-space control")


class Context(NamedTuple):
    """What a component is made with beside its options; None for what does not exist yet.

    Attributes:
        place: Place of the component in the scenario, for messages.
        spacecraft: Nominal spacecraft, as the controller knows it.
        orbit: Orbit of the run; None without one.
        plant: Plant of the run.
        controller: Controller that a compensator, an unloading or an estimator wraps.
        period: Control period, s.
        delay: Control periods from a sample to the start of its command.
        sensors: Nominal options of [sensors].
        reference: Part of the reference that is computed once, a
            `gyrostat.scenario.reference_kind.PlannedReference`.
        links: Names that the component gives, see `Part.links`.
        tables: Place of a part with a file -> what was computed of it once.
    """

    place: str = ""
    spacecraft: "Spacecraft | None" = None
    orbit: "OrbitEnvironment | None" = None
    plant: Any = None
    controller: Any = None
    period: "Scalar | None" = None
    delay: int = 0
    sensors: Mapping[str, Any] = {}
    reference: Any = None
    links: Mapping[str, tuple[str, ...]] = {}
    tables: Mapping[str, Any] = {}


@dataclass(frozen=True, eq=False)
class Kind:
    """Component of a scenario; the docstring of a subclass is its documentation.

    The fields of a subclass are its keys, `sigma: Annotated[Scalar, size("angle", 0.0, "...")]`. An
    instance has their values, which JAX traces, so that it cannot validate them.

    Attributes:
        name: Name in scenario files.
        unit: Unit of the value of a sensor or metric.
        texts: Names of keys that are texts; their reader stores them.
        links: Key that names one or several parts -> their section; see `Part.links`.
        needs: What the scenario must have for it.
        provides: What other components can need.
    """

    name: ClassVar[str]
    unit: ClassVar[str] = "1"
    texts: ClassVar[tuple[str, ...]] = ()
    links: ClassVar[Mapping[str, str]] = {}
    needs: ClassVar[frozenset[Need]] = frozenset()
    provides: ClassVar[frozenset[Need]] = frozenset()

    @classmethod
    def keys(cls) -> dict[str, Key]:
        """Name of each number -> its key."""
        return notes_of(cls, Key)

    @classmethod
    def meaning(cls) -> str:
        """Documentation."""
        return " ".join((inspect.getdoc(cls) or "").split())

    @classmethod
    def defaults(cls, values: Mapping[str, float], delay: int) -> Mapping[str, float]:
        """Defaults of some keys, SI, that replace those of `keys`.

        Args:
            values: Full key -> value of the other sections.
            delay: Command delay, periods.
        """
        return {}

    @classmethod
    def row(cls, row: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
        """Table of a scenario file, with what follows from other sections.

        Args:
            row: The table.
            values: Full key -> value of the other sections.
        """
        return dict(row)

    @classmethod
    def check(cls, place: str, scenario: "Scenario") -> None:
        """Check a component and what stands beside it; its values are checked by `relations`.

        Args:
            place: Place of the component in the scenario.
            scenario: Scenario.

        Raises:
            InputError: They are not possible.
        """

    @classmethod
    def relations(cls, place: str, scenario: "Scenario") -> Iterable[Relation]:
        """Relations between the values of a component, which its runs must fulfil too.

        Args:
            place: Place of the component in the scenario.
            scenario: Scenario.
        """
        return ()

    @classmethod
    def of(cls, options: Options) -> Self:
        """Component with the values of its keys."""
        return cls(**options)

    def options(self) -> Options:
        """Values of the keys."""
        return {name: getattr(self, name) for name in self.keys()}

    def make(self, context: Context) -> Any:
        """Part of the run; by default, the values themselves."""
        return self


class NoPart(Kind):
    """Absence of a part around the controller."""

    def make(self, context: Context) -> Any:
        """The controller itself."""
        return context.controller
