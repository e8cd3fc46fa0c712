"""Control loop of a run of a scenario, with its metrics."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from gyrostat.campaigns.build import build
from gyrostat.campaigns.metrics.observer import Observer
from gyrostat.campaigns.structure import Structure
from gyrostat.simulation import Loop, Runner, control_loop

OWN = (False, True, False, True)
"""Whether the runs have their own nominal values, drawn values, plans and random keys."""
ON_DEMAND = (False, True)
"""Records of a sample: the pointing error, and the signals, which only some runs return."""
LONGEST = 500
"""Largest number of control periods whose samples are in memory at a time."""


@lru_cache(maxsize=8)
def loop_of(structure: Structure) -> Callable[..., Loop]:
    """Function of the loop of a run: (nominal values, drawn values, plans, random key) -> loop.

    The carry of the loop ends with `Seen`; its record of a sample is (counted pointing errors,
    (histories, pointing error)).
    """

    def make(nominal: Any, drawn: Any, plans: Any, key: Any) -> Loop:
        values = {
            **dict(zip(structure.keys, nominal, strict=True)),
            **dict(zip(structure.dispersed, drawn, strict=True)),
        }
        setup = build(structure, values, plans)
        observer = Observer.of(structure, setup, values)
        loop = control_loop(
            *(setup.plant, setup.controller, setup.sensor, setup.start, key),
            values["run.control_period"],
            substeps=structure.substeps,
            command_delay=structure.command_delay,
        )

        def observed(seen, row, k):
            seen, pointing = observer(seen, row, k)
            return seen, (pointing.counted, (row, pointing.error))

        return loop.folded(observed, observer.start())

    return make


def runner_of(structure: Structure) -> Runner:
    """Runner of the loop by JAX."""
    return Runner(loop_of(structure), OWN, structure.count, longest=LONGEST, on_demand=ON_DEMAND)
