"""The control loop in compiled C with SIMD lanes."""

from collections.abc import Mapping
from typing import Any

import equinox as eqx
import numpy as np

from gyrostat.codegen.simd.batch import Lanes, lanes
from gyrostat.core.jax64 import jax
from gyrostat.simulation.loop import Histories, counting, loop_parts, stretch

SEGMENT = 2000
"""Longest stretch of control periods whose samples are in memory in lanes."""
MOST = 32
"""Loops that are kept compiled."""
_COMPILED: dict[Any, tuple[Lanes, Lanes, int]] = {}


def fly_in_lanes(
    items: tuple[Any, ...],
    own: tuple[bool, ...],
    keys: Any,
    period: float,
    counts: Mapping[str, int],
) -> Histories:
    """Run the loop for several runs.

    Args:
        items: plant, controller, sensor and start.
        own: for each of them whether each run has one of its own, with a leading axis.
        keys: of the noise, one for each run.
        period: control period, s.
        counts: as those of `gyrostat.simulation.run`.

    Returns:
        Histories with axes (run, time).

    Raises:
        InputError: there is no compiler, or something that lanes do not know.
    """
    arrays, static = eqx.partition(items, eqx.is_array)
    leaves, tree = jax.tree.flatten(static)
    shapes = [(leaf.shape, str(leaf.dtype)) for leaf in jax.tree.leaves(arrays)]
    # what is None may be an array elsewhere, and 1 equals True
    kind = (
        *(tree, jax.tree.structure(arrays), tuple(leaves), tuple(map(type, leaves)), *shapes),
        *(own, str(keys.dtype), tuple(sorted(counts.items()))),
    )
    if kind not in _COMPILED:
        if len(_COMPILED) >= MOST:
            del _COMPILED[next(iter(_COMPILED))]
        _COMPILED[kind] = _compiled(arrays, static, own, keys, period, counts)
    begin, segment, length = _COMPILED[kind]
    carry = begin(*arrays, keys, period)
    rows, count = [], counts["count"] + 1
    for first in range(0, count, length):
        carry, row = segment(carry, *arrays, keys, period, first, asked=range(len(keys)))
        rows.append(row)
    return jax.tree.map(lambda *parts: np.concatenate(parts, axis=1)[:, :count], *rows)


def _compiled(arrays, static, own, keys, period, counts) -> tuple[Lanes, Lanes, int]:
    """The loop's beginning, a stretch of it, and how long that is."""
    length = stretch(counts["count"], SEGMENT)
    given = {name: counts[name] for name in ("substeps", "command_delay")}

    def loop(plant, controller, sensor, start, key, period):
        items = eqx.combine((plant, controller, sensor, start), static)
        return items[3], *loop_parts(*items[:3], key, period, **given)

    def begin(*parts):
        state, first, _ = loop(*parts)
        return first(state)

    def segment(carry, *parts):
        *parts, first = parts
        *_, tick = loop(*parts)
        (_, carry), rows = jax.lax.scan(counting(tick), (first, carry), length=length)
        return carry, rows

    own = (*own, True, False)
    beginning = lanes(begin, own, (*arrays, keys, period))
    example = (beginning(*arrays, keys, period), *arrays, keys, period, 0)
    return beginning, lanes(segment, (True, *own, False), example, on_demand=(False, True)), length
