"""Bases of the references that point a body axis to a target along an orbit."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from gyrostat.control.guidance import Mosaic, Pointing, Raster, Scanned, SecondAxis
from gyrostat.control.guidance.targets import NORMAL, SUN, VELOCITY
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.component import ORBIT
from gyrostat.scenario.reference_kind import PlannedReference, ProfileKind, axes_apart
from gyrostat.scenario.relation import Relation
from gyrostat.scenario.schema import Key, direction, positive, size, vector

if TYPE_CHECKING:
    from gyrostat.control.guidance import Aim
    from gyrostat.scenario.scenario import Scenario

SECOND = ("along", "to_sun", "normal")
"""Body axes of which one is given: its part across `to_target` has a direction of its own."""


@dataclass(frozen=True, eq=False)
class AimedKind(ProfileKind):
    """Pointing at a target along [orbit] (`gyrostat.control.guidance.Pointing`)."""

    needs = frozenset({ORBIT})
    to_target: Annotated[Vector3, direction("Body axis that points to the target.")]
    along: Annotated[
        Vector3,
        vector(
            "1",
            "Body axis whose part across `to_target` points along the velocity.",
            (1.0, 0.0, 0.0),
        ),
    ]
    to_sun: Annotated[
        Vector3, vector("1", "In place of `along`: body axis whose part points to the Sun.")
    ]
    normal: Annotated[
        Vector3,
        vector("1", "In place of `along`: body axis whose part points along the orbit normal."),
    ]

    @classmethod
    def row(cls, row: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
        """See `Kind.row`: another second axis replaces `along`."""
        others = [name for name in SECOND[1:] if name in row]
        return {**({"along": [0.0, 0.0, 0.0]} if others else {}), **row}

    @classmethod
    def relations(cls, place: str, scenario: "Scenario") -> Iterator[Relation]:
        """See `Kind.relations`: there is one second axis, not parallel to the first."""
        ends = {name: [f"{place}.{name}.{axis}" for axis in "xyz"] for name in SECOND}

        def count(values: Mapping[str, Any]) -> Any:
            sizes = [sum(np.abs(values[key]) for key in keys) for keys in ends.values()]
            return sum(1.0 * (size > 0.0) for size in sizes)

        keys = tuple(key for name in SECOND for key in ends[name])
        expected = f"expected one of {', '.join(SECOND)}"
        text = f"{place}: found no second axis, {expected}"
        yield Relation(keys, text, lambda values: count(values) > 0.5)
        text = f"{place}: found several second axes, {expected}"
        yield Relation(keys, text, lambda values: count(values) < 1.5)
        yield axes_apart(place, ("to_target", *SECOND))

    def target(self, planned: PlannedReference, place: str) -> "Aim":
        """Target whose second direction is the velocity.

        Args:
            planned: Part of the reference that is computed once.
            place: Place of the reference or mode in the scenario.
        """
        raise NotImplementedError

    def profile(self, planned: PlannedReference, place: str) -> Pointing:
        """See `ProfileKind.profile`."""
        axes = [jnp.asarray(getattr(self, name), dtype=float) for name in SECOND]
        _, is_sun, is_normal = (jnp.any(axis != 0.0) for axis in axes)
        choice = jnp.where(is_sun, SUN, jnp.where(is_normal, NORMAL, VELOCITY))
        aim = SecondAxis(self.target(planned, place), choice)
        return planned.pointing(self.scanned(aim), self.to_target, axes[0] + axes[1] + axes[2])

    def scanned(self, aim: "Aim") -> "Aim":
        """Target with the offsets of a pattern; without one, the target itself.

        Args:
            aim: Target.
        """
        return aim


def whole(meaning: str) -> Key:
    """Key of a number of one or more, which is rounded to a whole number."""
    return Key("1", 1.0, meaning, 1.0, 1e6)


LARGEST_OFFSET = np.radians(80.0)
"""Largest offset of a pattern, rad; offsets are tangents of angles."""


def _reach(place: str, key: str, others: Sequence[str], most: Callable[..., Any]) -> Relation:
    """Relation of a pattern that is on one side of the spacecraft.

    Args:
        place: Place of the component.
        key: Name of the key of the message.
        others: Names of the other keys.
        most: Largest offset, rad, from their values.
    """
    keys = [f"{place}.{name}" for name in (key, *others)]
    largest = f"{np.degrees(LARGEST_OFFSET):g} deg"
    return Relation(
        tuple(keys),
        f"{place}.{key}: found a pattern that reaches more than {largest} from its target, "
        f"expected {largest} or less",
        lambda values: most(*(values[key] for key in keys)) <= LARGEST_OFFSET,
    )


@dataclass(frozen=True, eq=False)
class MosaicKind(AimedKind):
    """Mosaic of tiles about a target (`gyrostat.control.guidance.Mosaic`)."""

    columns: Annotated[Scalar, whole("Tiles in a row, rounded.")]
    rows: Annotated[Scalar, whole("Number of rows, rounded.")]
    tile_width: Annotated[Scalar, size("angle", 0.0, "Distance between tiles along a row.")]
    tile_height: Annotated[Scalar, size("angle", 0.0, "Distance between rows.")]
    dwell: Annotated[Scalar, positive("time", None, "Time in each tile.")]
    step_time: Annotated[Scalar, positive("time", None, "Time from one tile to the next.")]
    begin: Annotated[Scalar, size("time", None, "Time of the run at which the first tile begins.")]

    @classmethod
    def relations(cls, place: str, scenario: "Scenario") -> Iterator[Relation]:
        """See `Kind.relations`: the tiles are on one side of the spacecraft."""
        yield from super().relations(place, scenario)
        for key, count in (("tile_width", "columns"), ("tile_height", "rows")):
            yield _reach(place, key, [count], lambda size, n: 0.5 * (np.round(n) - 1.0) * size)

    def scanned(self, aim: "Aim") -> "Aim":
        """See `AimedKind.scanned`."""
        counts = jnp.round(jnp.asarray(self.columns)), jnp.round(jnp.asarray(self.rows))
        times = self.dwell, self.step_time, self.begin
        return Scanned(aim, Mosaic(*counts, self.tile_width, self.tile_height, *times))


@dataclass(frozen=True, eq=False)
class RasterKind(AimedKind):
    """Lines at a constant rate about a target (`gyrostat.control.guidance.Raster`)."""

    length: Annotated[Scalar, positive("angle", None, "Length of a line.")]
    spacing: Annotated[Scalar, size("angle", 0.0, "Distance between lines.")]
    lines: Annotated[Scalar, whole("Number of lines, rounded.")]
    line_time: Annotated[Scalar, positive("time", None, "Time of a line.")]
    turn_time: Annotated[Scalar, positive("time", None, "Time between two lines.")]
    begin: Annotated[Scalar, size("time", None, "Time of the run at which the first line begins.")]

    @classmethod
    def relations(cls, place: str, scenario: "Scenario") -> Iterator[Relation]:
        """See `Kind.relations`: lines and ways to rest are on one side of the spacecraft."""
        yield from super().relations(place, scenario)
        yield _reach(
            place,
            "length",
            ["turn_time", "line_time"],
            lambda length, turn, line: 0.5 * (1.0 + turn / line) * length,
        )
        yield _reach(place, "spacing", ["lines"], lambda size, n: 0.5 * (np.round(n) - 1.0) * size)

    def scanned(self, aim: "Aim") -> "Aim":
        """See `AimedKind.scanned`."""
        count = jnp.round(jnp.asarray(self.lines))
        times = self.line_time, self.turn_time, self.begin
        return Scanned(aim, Raster(self.length, self.spacing, count, *times))
