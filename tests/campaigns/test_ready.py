"""Scenario that is ready to be simulated by JAX."""

from pathlib import Path

import equinox as eqx
import numpy as np

from gyrostat.campaigns.draws import draw
from gyrostat.campaigns.ready import _begin, make_ready
from gyrostat.core.jax64 import jax
from gyrostat.core.random_keys import random_keys
from gyrostat.runs.run_loop import OWN, Drawn, loop_of
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.simulation.runner import _chunk

SCENARIO = Path(__file__).parents[2] / "examples" / "scenarios" / "zero_crossing_model.toml"


def test_all_chunks_of_a_run_are_one_program():
    """JAX compiles a chunk anew if its carry has other types, weak ones of Python among them."""
    scenario = read_scenario(SCENARIO)
    ready = make_ready(scenario, "jax")
    assert len(ready.runner.starts) > 1
    values, keys = draw(scenario, 0, range(2))
    arguments = ready.nominal, Drawn(values, None), ready.plans, random_keys(keys)
    structure = structure_of(scenario)
    carry = jax.eval_shape(_begin(structure), *arguments)
    described = loop_of(structure), OWN, ready.runner.length, carry, np.asarray(0), arguments
    after, _ = eqx.filter_eval_shape(_chunk, *described)
    assert jax.tree.map(_type, after) == jax.tree.map(_type, carry)


def _type(leaf):
    return leaf.shape, leaf.dtype, leaf.weak_type
