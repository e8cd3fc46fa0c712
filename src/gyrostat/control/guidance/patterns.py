"""Scan patterns about a target: lines at a constant rate, and tiles with a dwell time in each.

A pattern is a callable time, s -> offsets of the line of sight, rad, which `Scanned` adds to an
aim.
"""

from collections.abc import Callable
from typing import Annotated

import equinox as eqx

from gyrostat.control.guidance.pointing import Aim, as_tree, axes_of
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked, positive, signed
from gyrostat.core.jax64 import jnp
from gyrostat.core.limiting import within
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment


class Scanned(Checked):
    """Directions of another aim, offset by a pattern.

    Offsets are tangents of angles in the plane across the target: along the second direction, and
    along the cross product of both.

    Attributes:
        aim: Target.
        pattern: Offsets over time.
    """

    aim: Aim = eqx.field(converter=as_tree)
    pattern: Callable[[Scalar], tuple[Scalar, Scalar]]

    def __call__(self, orbit: OrbitEnvironment, time: Scalar) -> tuple[Vector3, Vector3]:
        """Directions at a time, s."""
        aim = self.aim(orbit, time)
        first, one, other = axes_of(*aim)
        along, beside = self.pattern(time)
        return first + jnp.tan(along) * one + jnp.tan(beside) * other, aim[1]


class Raster(Checked):
    """Lines at a constant rate, one after another, in turn to and fro.

    The first offset goes along the lines, the second from line to line; both are symmetric about
    the target. Offsets, rates and accelerations are continuous. In the time of a turn, the line of
    sight gathers speed before the first line, and comes to rest after the last one.

    Attributes:
        length: Length of a line, rad.
        spacing: Distance between lines, rad.
        lines: Number of lines, a whole number.
        line_time: Time of a line, s.
        turn_time: Time between two lines, s.
        begin: Begin of the first line, s.
    """

    length: Annotated[Scalar, positive("length of a line", "rad")]
    spacing: Annotated[Scalar, signed("distance between lines", "rad")]
    lines: Annotated[Scalar, positive("number of lines")]
    line_time: Annotated[Scalar, positive("time of a line", "s")]
    turn_time: Annotated[Scalar, positive("time of a turn", "s")]
    begin: Annotated[Scalar, signed("begin of the first line", "s")] = 0.0

    def __call__(self, time: Scalar) -> tuple[Scalar, Scalar]:
        """Offsets at a time, s; rad."""
        since, last = time - self.begin, self.lines - 1.0
        line = within(jnp.floor(since / (self.line_time + self.turn_time)), 0.0, last)
        inside = since - line * (self.line_time + self.turn_time)
        sign = 1.0 - 2.0 * (line - 2.0 * jnp.floor(0.5 * line))
        before, after = -inside / self.turn_time, (inside - self.line_time) / self.turn_time
        # a turn begins and ends at the edge, with opposite rates and without acceleration
        bow = after * (1.0 - after)
        turn = jnp.where(line == last, _halt(after), bow + bow**2)
        reach = self.turn_time / self.line_time
        along = jnp.where(inside < 0.0, -reach * _halt(before), inside / self.line_time)
        along = jnp.where(after > 0.0, 1.0 + reach * turn, along)
        step = jnp.where(line == last, 0.0, _smooth(after))
        return sign * self.length * (along - 0.5), self.spacing * (line + step - 0.5 * last)


class Mosaic(Checked):
    """Tiles, with a dwell time in each; the rows are taken in turn to and fro.

    The first offset goes along the rows, the second from row to row; both are symmetric about the
    target. The line of sight rests in each tile; between two tiles, its rate and its acceleration
    are continuous.

    Attributes:
        columns: Number of tiles in a row, a whole number.
        rows: Number of rows, a whole number.
        width: Distance between tiles along a row, rad.
        height: Distance between rows, rad.
        dwell: Time in each tile, s.
        step_time: Time from one tile to the next, s.
        begin: Begin of the first tile, s.
    """

    columns: Annotated[Scalar, positive("number of columns")]
    rows: Annotated[Scalar, positive("number of rows")]
    width: Annotated[Scalar, signed("width of a tile", "rad")]
    height: Annotated[Scalar, signed("height of a tile", "rad")]
    dwell: Annotated[Scalar, positive("dwell time", "s")]
    step_time: Annotated[Scalar, positive("time from tile to tile", "s")]
    begin: Annotated[Scalar, signed("begin of the first tile", "s")] = 0.0

    def __call__(self, time: Scalar) -> tuple[Scalar, Scalar]:
        """Offsets at a time, s; rad."""
        since, last = time - self.begin, self.columns * self.rows - 1.0
        tile = within(jnp.floor(since / (self.dwell + self.step_time)), 0.0, last)
        inside = since - tile * (self.dwell + self.step_time)
        share = _smooth((inside - self.dwell) / self.step_time)
        column, row = self._place(tile)
        later = self._place(jnp.where(tile < last, tile + 1.0, last))
        column, row = column + share * (later[0] - column), row + share * (later[1] - row)
        return (
            self.width * (column - 0.5 * (self.columns - 1.0)),
            self.height * (row - 0.5 * (self.rows - 1.0)),
        )

    def _place(self, tile: Scalar) -> tuple[Scalar, Scalar]:
        """Column and row of a tile, from 0."""
        row = jnp.floor((tile + 0.5) / self.columns)
        column = tile - row * self.columns
        backward = row - 2.0 * jnp.floor(0.5 * row)
        return column + backward * (self.columns - 1.0 - 2.0 * column), row


def _smooth(share: Scalar) -> Scalar:
    """From 0 to 1, at rest and without acceleration at both ends."""
    share = within(share, 0.0, 1.0)
    return share**3 * (10.0 + share * (6.0 * share - 15.0))


def _halt(share: Scalar) -> Scalar:
    """Way from rate 1 to rest at a share of 1, without acceleration at both ends."""
    share = within(share, 0.0, 1.0)
    return share - share**3 + 0.5 * share**4
