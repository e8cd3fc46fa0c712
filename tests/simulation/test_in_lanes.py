"""The loop in lanes: the histories that JAX gives."""

from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
import pytest

from gyrostat.codegen.simd import compiler
from gyrostat.control import AttitudePID, CurrentMode
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.simulation import Status, simulate, simulation, stack
from gyrostat.spacecraft import Gyro, TableSensors
from gyrostat.wheel import Tachometer

pytestmark = [
    pytest.mark.skipif(compiler() is None, reason="needs a C compiler"),
    pytest.mark.optimised_c,  # numbers of both engines
]
PERIOD, COUNT = 0.1, 100
NOISY = TableSensors(Gyro(1e-4), Tachometer(0.3))


def control(gain=0.06):
    return CurrentMode(AttitudePID(gain, 0.01, 0.2), 0.02)


@pytest.fixture(scope="module")
def both(g2):
    """Histories by JAX and in lanes."""

    def call(plant, controller, sensor, **options):
        options = {"duration": PERIOD * COUNT, "control_period": PERIOD, "step": 0.05, **options}
        return [
            simulate(plant, controller, sensor, engine=engine, **options)
            for engine in ("jax", "native")
        ]

    return call


def agree(found):
    theirs, ours = found
    assert set(ours.variables) == set(theirs.variables)
    assert ours.attrs == theirs.attrs
    for name in theirs.variables:
        assert ours[name].dtype == theirs[name].dtype, name
        assert ours[name].attrs == theirs[name].attrs
        scale = 1.0 + float(np.nanmax(np.abs(theirs[name])))
        np.testing.assert_allclose(ours[name], theirs[name], rtol=0, atol=1e-11 * scale)


def test_a_noisy_batch_of_which_one_diverges(g2, both, monkeypatch):
    monkeypatch.setattr(simulation, "LONGEST", 40)  # what is kept is put together
    start = stack([g2.table.start(attitude=0.01, speed=0.5 * k - 0.6) for k in range(3)])
    gains = stack([control(gain) for gain in (0.06, -5.0, 0.08)])
    options = {"start": start, "runs": 3, "command_delay": 1, "seed": 4}
    found = both(g2.table, gains, NOISY, **options)
    agree(found)
    assert found[1].status.values.tolist() == [Status.COMPLETE, Status.DIVERGED, Status.COMPLETE]
    assert np.any(np.diff(np.sign(found[1].speed.isel(run=0))) != 0)  # the wheel crosses zero


class Command(NamedTuple):
    """What the table takes."""

    current: object


class Clocked:
    """A controller that JAX cannot look into."""

    bad_after = np.inf

    def start(self, period):
        return jnp.array(0.0)

    def __call__(self, memory, measurement):
        current = jnp.where(memory > self.bad_after, jnp.nan, -0.05 * measurement.attitude)
        return memory + 1.0, Command(current)


def test_a_users_own_controller_alone(g2, both):
    options = {"start": g2.table.start(attitude=0.01, speed=-3.0)}
    agree(both(g2.table, Clocked(), NOISY, **options))
    changed = Clocked()
    changed.bad_after = 12.0
    with pytest.raises(InputError, match=r"Clocked: found a command that is not finite at 1\.3 s"):
        simulate(
            *(g2.table, changed, NOISY),
            **options,
            duration=PERIOD * COUNT,
            control_period=PERIOD,
            engine="native",
        )


class WithGamma(Clocked):
    """A controller that needs what lanes have not."""

    def __call__(self, memory, measurement):
        return memory, Command(0.0 * jax.scipy.special.gammaln(2.5 + measurement.attitude))


def test_what_lanes_do_not_know_is_refused_or_left_to_jax(g2):
    options = {"duration": 1.0, "control_period": PERIOD, "start": g2.table.start(attitude=0.01)}
    with pytest.raises(InputError, match=r"test_in_lanes\.py.*lgamma"):
        simulate(g2.table, WithGamma(), NOISY, engine="native", **options)
    assert simulate(g2.table, WithGamma(), NOISY, engine="auto", **options).status == 0
    with pytest.raises(InputError, match="engine: found 'c', expected one of auto, native, jax"):
        simulate(g2.table, Clocked(), NOISY, engine="c", **options)


class Leaning(eqx.Module):
    """A controller with one of two gains."""

    towards: Any = None
    away: Any = None

    def start(self, period):
        return jnp.array(0.0)

    def __call__(self, memory, measurement):
        gain = self.towards if self.away is None else -self.away
        return memory, Command(-gain * measurement.attitude)


@pytest.fixture(scope="module")
def lean(g2):
    """Histories with a controller of `Leaning`, by an engine."""
    options = {"start": g2.table.start(attitude=0.01, speed=-3.0), "duration": 1.0}
    options = {"control_period": PERIOD, "step": 0.05, **options}
    return lambda engine, **gain: simulate(
        g2.table, Leaning(**gain), NOISY, engine=engine, **options
    )


def test_the_former_name_of_the_engine_says_the_new_one(lean):
    with pytest.warns(DeprecationWarning, match="engine: lanes is now called native"):
        lean("lanes", towards=0.05)


def test_controllers_that_differ_in_what_they_lack_are_two(lean):
    """In lanes; for JAX the other controller is the first one with a gain of the other sign."""
    agree((lean("jax", towards=0.05), lean("native", towards=0.05)))
    agree((lean("jax", towards=-0.05), lean("native", away=0.05)))
