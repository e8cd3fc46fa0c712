"""The ready scenarios: each is whole, is traced with every number free, and is listed."""

from dataclasses import replace
from pathlib import Path

import pytest

from gyrostat.campaigns import Scenario
from gyrostat.campaigns.build import build, plan
from gyrostat.campaigns.metrics.observer import Observer
from gyrostat.campaigns.reading.scenario_file import read_scenario
from gyrostat.campaigns.schema import GUARD
from gyrostat.campaigns.structure import structure_of
from gyrostat.core.jax64 import jax, jnp
from gyrostat.simulation import control_loop

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted(
    p for p in (ROOT / "examples" / "scenarios").glob("*.toml") if "[run]" in p.read_text()
)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_every_example_is_read_and_traced(path):
    """One control period with all its numbers, dispersed or not, as unknowns."""
    scenario = read_scenario(path)
    assert scenario.dispersions
    assert Scenario.from_text(scenario.text()).digest() == scenario.digest()
    plans = plan(scenario)

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


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_every_example_may_be_guarded(path):
    """The guard keeps no memory that is not finite: it must be finite from the start."""
    scenario = replace(read_scenario(path), guard="hold")
    limits = {f"guard.{name}": key.default for name, key in GUARD.items()}
    values = {**scenario.values, **limits}
    guarded = replace(scenario, values=values)
    setup = build(structure_of(guarded), values, plan(scenario))
    period = values["run.control_period"]
    setup.controller.check_period(period)
    for leaf in jax.tree.leaves(setup.controller.start(period)):
        assert jnp.all(jnp.isfinite(leaf))


@pytest.mark.parametrize("page", ["docs/scenario.md", "examples/README.md"])
def test_every_example_is_listed(page):
    text = (ROOT / page).read_text()
    assert len(EXAMPLES) >= 6
    for path in EXAMPLES:
        assert f"`{path.name}`" in text
