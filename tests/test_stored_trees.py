"""Functions of trees of parts, whose machine code outlives the process."""

from functools import wraps
from typing import Any

import equinox as eqx
import numpy as np
import pytest

from gyrostat.control import CurrentMode
from gyrostat.core import cache_entries, stored_function
from gyrostat.core.cache import private_cache
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.stored_trees import stored_tree_function, structure_text
from gyrostat.simulation import runner, simulate
from gyrostat.spacecraft import (
    Gyro,
    Gyrostat,
    GyrostatState,
    Spacecraft,
    TableSensors,
    WheelFailures,
)
from gyrostat.wheel import Tachometer, WheelArray
from gyrostat.wheel.friction import Stribeck, ViscousCoulomb


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """Names of the entries in an empty cache."""
    monkeypatch.setenv("GYROSTAT_CACHE", str(tmp_path / "cache"))
    cache = private_cache(pytest.fail)
    stored_function._machine.cache_clear()

    def names():
        found = (entry.path.name for entry in cache_entries.entries(cache.path))
        return [name for name in found if name.startswith("jax-function-")]

    yield names
    stored_function._machine.cache_clear()


class Own(eqx.Module):
    """Part that is not of the package."""

    size: Any


class OwnFriction(ViscousCoulomb):
    """Friction model that is not of the package."""


def wheels(**changes):
    given = {
        "axes": np.eye(3),
        "inertia": np.full(3, 1.5e-3),
        "torque_limit": np.full(3, 0.1),
        "momentum_limit": np.full(3, 3.0),
        "friction": Stribeck(np.full(3, 5e-6), np.full(3, 9e-4), np.full(3, 9e-4), np.full(3, 0.4)),
    }
    return WheelArray(**(given | changes))


def craft(**changes):
    return Spacecraft(np.diag([10.0, 12.0, 14.0]), wheels(**changes))


def test_the_text_has_everything_but_the_values_of_arrays():
    other = wheels(inertia=np.full(3, 2.0), axes=np.eye(3)[:, ::-1])
    assert structure_text(wheels()) == structure_text(other)
    assert structure_text((np.ones(3), {"a": jnp.ones(2)})) == structure_text(
        (np.zeros(5), {"a": jnp.ones(1)})
    )


TREES = [
    (1.0,),
    (1,),
    (True,),
    ("1.0",),
    (None,),
    (np.ones(1),),
    ([1.0],),
    (1.0, 1.0),
    (1.0 + 2.0**-52,),
    ({"a": 1.0},),
    ({"b": 1.0},),
    ("a': 1.0",),
    (jax.random.key(0),),
    (jax.random.key_data(jax.random.key(0)), 0),
    (GyrostatState(1.0, None, None),),
    (GyrostatState(None, 1.0, None),),
    (wheels(),),
    (wheels(torque_limit=0.1),),
    (wheels(torque_limit=0.2),),
    (wheels(friction=ViscousCoulomb(np.zeros(3), np.zeros(3))),),
    (Gyrostat(craft()),),
    (Gyrostat(craft(), WheelFailures.none(3)),),
    (Gyrostat(craft(), torque_history=runner.by_engine),),
    (Gyrostat(craft(), torque_history=runner.blocks),),
    (Stribeck,),
    (ViscousCoulomb,),
]


def test_trees_that_differ_have_different_texts():
    texts = [structure_text(tree) for tree in TREES]
    assert None not in texts
    assert len(set(texts)) == len(TREES)


@pytest.mark.parametrize(
    "own",
    [
        Own(np.ones(3)),
        Own,
        OwnFriction(np.zeros(3), np.zeros(3)),
        lambda attitude, time: attitude,
        object(),
        wheels,
        np.linalg.norm,
    ],
    ids=["part", "class", "subclass", "closure", "object", "function", "of another package"],
)
def test_own_parts_have_no_text_and_are_never_kept(own, kept):
    part = wheels(friction=own) if isinstance(own, OwnFriction) else own
    assert structure_text(({"a": [part]},)) is None
    assert stored_tree_function(lambda tree, x: x + 1.0)(part, np.ones(2)).tolist() == [2.0, 2.0]
    assert kept() == []


def test_an_array_that_is_not_data_has_no_text():
    with pytest.warns(UserWarning, match="set as static"):
        history = Gyrostat(craft(), torque_history=np.ones(3))
    assert structure_text(history) is None


def energy(plant, state, scale, key):
    return {"energy": scale * plant.kinetic_energy(state), "noise": jax.random.normal(key, (2,))}


def counted(function):
    """The function, by its own name, with a list of its calls: one for each trace."""
    calls = []

    @wraps(function)
    def counting(*arguments):
        calls.append(arguments)
        return function(*arguments)

    return stored_tree_function(counting), calls


def test_another_process_gets_the_same_bits_without_tracing(kept):
    plant = Gyrostat(craft())
    state = plant.start(rate=[0.1, -0.2, 0.3], wheel_speed=[10.0, 20.0, -30.0])
    first, traced = counted(energy)
    second, again = counted(energy)  # a new wrapper knows no more than a new process
    given = (plant, state, 2.0, jax.random.key(7))
    one, other = first(*given), second(*given)
    assert (len(traced), len(again), len(kept())) == (1, 0, 1)
    for name in ("energy", "noise"):
        assert np.asarray(one[name]).tobytes() == np.asarray(other[name]).tobytes()
    np.testing.assert_allclose(one["energy"], 2.0 * plant.kinetic_energy(state), rtol=1e-14)
    np.testing.assert_array_equal(one["noise"], jax.random.normal(jax.random.key(7), (2,)))


def test_another_structure_or_number_is_compiled_anew_and_other_arrays_are_not(kept):
    plant = Gyrostat(craft())
    state, key = plant.start(rate=[0.1, 0.0, 0.0]), jax.random.key(7)
    call, traced = counted(energy)
    call(plant, state, 2.0, key)
    heavier = Gyrostat(Spacecraft(2.0 * np.asarray(plant.spacecraft.inertia), wheels()))
    np.testing.assert_allclose(
        call(heavier, state, 2.0, key)["energy"], 2.0 * heavier.kinetic_energy(state), rtol=1e-14
    )
    assert len(traced) == 1
    np.testing.assert_allclose(
        call(plant, state, 3.0, key)["energy"], 3.0 * plant.kinetic_energy(state), rtol=1e-14
    )
    call(Gyrostat(plant.spacecraft, WheelFailures.none(3)), state, 2.0, key)
    assert (len(traced), len(kept())) == (3, 3)


def test_a_setting_of_jax_is_part_of_the_name(kept):
    x = np.ones(3)
    counted(jnp_sum)[0](x)
    with jax.debug_nans(True):
        call, traced = counted(jnp_sum)
        call(x)
    assert (len(traced), len(kept())) == (1, 2)


def jnp_sum(x):
    return jnp.sum(x)


def test_a_simulation_in_another_process_gives_the_same_bits_without_tracing(kept, monkeypatch, g2):
    control, sensor = CurrentMode(g2.law, 0.02), TableSensors(Gyro(1e-6), Tachometer(0.5))
    timing = {"duration": 20.0, "control_period": 0.1, "seed": 3}
    given = {"start": g2.table.start(attitude=0.01, speed=-3.0), **timing}
    flights = [simulate(g2.table, control, sensor, **given)]
    for traces in (1, 0):
        call, traced = counted(runner._chunk)
        monkeypatch.setattr(runner, "_stored_chunk", call)
        flights.append(simulate(g2.table, control, sensor, stored=True, **given))
        assert (len(traced), len(kept())) == (traces, 1)
    for flight in flights[1:]:
        assert flight.identical(flights[0])
    # other numbers of the same parts are data of the program
    other = CurrentMode(g2.law, 0.03)
    for stored in (False, True):
        flights.append(simulate(g2.table, other, sensor, stored=stored, **given))
    assert traced == []
    assert flights[-1].identical(flights[-2])
    assert not flights[-1].identical(flights[0])
