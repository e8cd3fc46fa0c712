"""Control loop of a run of a scenario, with its metrics."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

from gyrostat.core.jax64 import jax, jnp
from gyrostat.runs.build import build
from gyrostat.runs.metrics.observer import Observer
from gyrostat.scenario.structure import Structure
from gyrostat.simulation import Loop, Runner, control_loop
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment

OWN = (False, True, False, True)
"""Whether the runs have their own nominal values, `Drawn`, plans and random keys."""
ON_DEMAND = (False, True)
"""Records of a sample: errors, and the signals, which only some runs return."""
LONGEST = 500
"""Largest number of control periods whose samples are in memory at a time."""


class Drawn(NamedTuple):
    """What a run, or each of several runs, has of its own.

    Attributes:
        values: Dispersed values, (keys,).
        orbit: Tables along its orbit; None where all runs share them.
    """

    values: Any
    orbit: OrbitEnvironment | None = None


@lru_cache(maxsize=8)
def loop_of(structure: Structure) -> Callable[..., Loop]:
    """Function of the loop of a run: (nominal values, `Drawn`, plans, random key) -> loop.

    The random key is one key, or several, (parts,): each is the key of the noise in one part of the
    run. The parts have equal numbers of samples.

    The carry of the loop ends with `Seen`; its record of a sample is ((counted pointing errors,
    error vectors of requirements), (histories, pointing error)).
    """

    def make(nominal: Any, drawn: Drawn, plans: Any, key: Any) -> Loop:
        values = {
            **dict(zip(structure.keys, nominal, strict=True)),
            **dict(zip(structure.dispersed, drawn.values, strict=True)),
        }
        if drawn.orbit is not None:
            plans = plans._replace(orbit=drawn.orbit)
        setup = build(structure, values, plans)
        observer = Observer.of(structure, setup, values)
        loop = control_loop(
            *(setup.plant, setup.controller, setup.sensor, setup.start),
            _keys_of(key, structure.count),
            values["run.control_period"],
            substeps=structure.substeps,
            command_delay=structure.command_delay,
        )

        def observe(seen, row, k):
            seen, pointing = observer(seen, row, k)
            return seen, ((pointing.counted, pointing.vectors), (row, pointing.error))

        return loop.folded(observe, observer.start())

    return make


def _keys_of(key: Any, count: int) -> Any:
    """Random key of a run, or function of a sample that gives the key of its part of the run."""
    if key.ndim == 0:
        return key
    parts = key.shape[0]
    size = -(-(count + 1) // parts)
    # the last chunk may extend beyond the last sample
    return lambda k: jax.random.fold_in(key[jnp.minimum(k // size, parts - 1)], k)


def runner_of(structure: Structure) -> Runner:
    """Runner of the loop by JAX."""
    return Runner(loop_of(structure), OWN, structure.count, longest=LONGEST, on_demand=ON_DEMAND)
