"""The ready scenarios: each is whole, is traced with every number free, and is listed."""

from dataclasses import replace
from pathlib import Path

import equinox as eqx
import numpy as np
import pytest

from gyrostat.core.jax64 import jax, jnp
from gyrostat.runs.build import build
from gyrostat.runs.metrics.observer import Observer
from gyrostat.runs.plans import plans_of
from gyrostat.scenario import Scenario
from gyrostat.scenario.schema import GUARD
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario.unlikely import unlikely_numbers
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.simulation import control_loop

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted(
    p for p in (ROOT / "examples" / "scenarios").glob("*.toml") if "[run]" in p.read_text()
)


@pytest.fixture(scope="module", params=EXAMPLES, ids=lambda p: p.stem)
def scenario(request):
    """Each of them."""
    return read_scenario(request.param)


def test_every_example_is_read_and_traced(scenario):
    """One control period with all its numbers, dispersed or not, as unknowns."""
    assert scenario.dispersions
    assert unlikely_numbers(scenario) == []
    assert Scenario.from_text(scenario.text()).digest() == scenario.digest()
    plans = plans_of(scenario)

    def period(numbers, key):
        values = dict(zip(scenario.values, numbers, strict=True))
        setup = build(structure_of(scenario), values, plans)
        loop = control_loop(
            *(setup.plant, setup.controller, setup.sensor, setup.start, key),
            values["run.control_period"],
            substeps=scenario.substeps,
            command_delay=scenario.command_delay,
        )
        seeing = Observer.of(structure_of(scenario), setup, values)
        carry, row = loop.tick(loop.begin(), jnp.array(0))
        return carry, loop.begin(), seeing(seeing.start(), row, jnp.array(0))[1].error

    after, before, error = jax.eval_shape(
        period, jnp.zeros(len(scenario.values)), jax.random.key(0)
    )
    shapes = [[leaf.shape for leaf in jax.tree.leaves(carry)] for carry in (after, before)]
    assert shapes[0] == shapes[1]
    assert error.shape == ()


@eqx.filter_jit
def begun(structure, values, plans):
    controller = build(structure, values, plans).controller
    return controller, controller.start(values["run.control_period"])


def test_every_example_may_be_guarded(scenario):
    """The guard keeps no memory that is not finite: it must be finite from the start."""
    limits = {f"guard.{name}": key.default for name, key in GUARD.items()}
    guarded = replace(scenario, guard="hold", values={**scenario.values, **limits})
    values = {key: np.asarray(value) for key, value in guarded.values.items()}
    controller, memory = begun(structure_of(guarded), values, plans_of(scenario))
    controller.check_period(scenario.values["run.control_period"])
    for leaf in jax.tree.leaves(memory):
        assert np.all(np.isfinite(leaf))


@pytest.mark.parametrize("page", ["docs/scenario.md", "examples/README.md"])
def test_every_example_is_listed(page):
    text = (ROOT / page).read_text()
    assert len(EXAMPLES) >= 6
    for path in EXAMPLES:
        assert f"`{path.name}`" in text
