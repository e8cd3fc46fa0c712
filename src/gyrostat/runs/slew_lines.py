"""Lines on the slews of a scenario around keep-out cones."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from gyrostat.core.jax64 import jax
from gyrostat.core.types import Vector
from gyrostat.runs.plans import plans_of
from gyrostat.scenario.mode_graph import pairs_around
from gyrostat.scenario.reference_kind import AROUND
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.timeline import modes


def slew_lines(scenario: Scenario) -> list[str]:
    """Line on each slew of a scenario around cones; without such slews, there are none."""
    reference = plans_of(scenario).reference
    turns = None if reference is None else reference.turns
    lines: list[str] = []
    if turns is None:
        return lines
    for row, place, origin, names in _slews(scenario):
        cones = " and ".join(names)
        if turns.is_planned[row] > 0.0:
            turn = jax.tree.map(lambda each, row=row: each[row], turns.turns)
            is_bowed = np.any(turn.bows) or np.linalg.norm(turn.turn) > np.pi
            way = "leads around" if is_bowed else "is an eigenaxis slew outside of"
            time = f"{float(turn.profile.duration):.1f} s"
        else:
            way, time = "finds its way around", "when it starts"
        lines.append(f"{place}: the slew from {origin} {way} the cones of {cones}, {time}")
    return lines


_BLOCKED = {
    1: "no way that keeps the angles at all times",
    2: "a body too near at its start, which it leaves by the shortest way",
    3: "a body too near at its start, and no way that keeps the angles from there on",
}
"""Value of `turn_blocked` -> what was found."""


def blocked_turns(scenario: Scenario, history: Mapping[str, Any]) -> list[str]:
    """Line on each turn of a simulated run in which a body may come too near.

    Args:
        scenario: Scenario.
        history: Signals of the run by name, NumPy arrays.
    """
    if "turn_blocked" not in history:
        return []
    blocked, start, number = (
        np.asarray(history[name]) for name in ("turn_blocked", "mode_start", "mode")
    )
    names = modes(scenario.parts)
    begins = np.flatnonzero((np.diff(start, prepend=np.nan) != 0.0) & (blocked > 0.0))
    return [
        f"warning: reference.mode.{names[int(number[k])]}.{AROUND}: found "
        f"{_BLOCKED[int(blocked[k])]}, for the turn at {start[k]:g} s; expected a clear one"
        for k in begins
    ]


def blocked_runs(scenario: Scenario, times: Vector) -> list[str]:
    """Line on the runs in which a body is too near; none without slews around cones.

    Args:
        scenario: Scenario.
        times: `keep_out_time` of each run, (runs,), s.
    """
    blocked = times[times > 0.0]
    if not len(blocked) or not any(part.linked(AROUND) for part in scenario.parts):
        return []
    return [
        f"keep_out_time: a body is too near in {len(blocked)} of {len(times)} runs, for "
        f"{np.max(blocked):g} s at most"
    ]


def _slews(scenario: Scenario) -> Iterator[tuple[int, str, str, tuple[str, ...]]]:
    """Number, place, origin and instruments of each slew around cones."""
    names = modes(scenario.parts)
    for (origin, to), part in pairs_around(scenario).items():
        place = f"reference.mode.{part.name}"
        yield origin * len(names) + to, place, names[origin], part.linked(AROUND)
    slews = [part for part in scenario.parts if part.section == "reference.slew"]
    for row, part in enumerate(slews):
        if part.linked(AROUND):
            before = slews[row - 1].name if row else "the initial attitude"
            yield row, f"reference.slew.{part.name}", before, part.linked(AROUND)
