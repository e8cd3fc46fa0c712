"""A wheel with dry friction on a table: conservation laws, rest and breakaway, an oracle."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import AirBearingTable, TableCommand, TableState
from gyrostat.wheel import Driver, Wheel
from gyrostat.wheel.friction import Stribeck, ViscousCoulomb

PERIODS = 200
INERTIA, WHEEL_INERTIA, MOTOR = 0.03, 1.5e-3, 0.0228
FRICTION = (4.83e-6, 0.8795e-3, 1.0555e-3, 0.418879)


def make_table(
    inertia=INERTIA,
    wheel_inertia=WHEEL_INERTIA,
    motor=MOTOR,
    friction=FRICTION,
    external=0.0,
    lag=0.0,
    history=None,
):
    wheel = Wheel(wheel_inertia, motor, Stribeck(*friction))
    table = AirBearingTable(inertia, wheel, Driver(time_constant=lag), external, history)
    # arrays, so that every table here is one compilation
    return jax.tree.map(lambda x: jnp.asarray(x, float), table)


@jax.jit
def carried(table, start, currents, period, begin):
    """Start and end of every period of a held current, and whether all were resolved."""

    def tick(carry, current):
        state, time, fine = carry
        state, resolved = table(state, TableCommand(current), time, period)
        return (state, time + period, fine & resolved), state

    (_, _, fine), states = jax.lax.scan(tick, (start, begin, True), currents)
    return jax.tree.map(lambda a, b: jnp.concatenate([a[None], b]), start, states), fine


def go(table, currents=0.0, period=0.1, **start):
    currents = np.broadcast_to(np.asarray(currents, float), PERIODS)
    states, fine = carried(table, table.start(**start), currents, period, 0.0)
    assert bool(fine)
    return TableState(*(np.asarray(x) for x in states))


def random_currents(seed):
    """Levels held for five periods, some of them too low to turn the wheel."""
    levels = np.random.default_rng(seed).uniform(-0.12, 0.12, PERIODS // 5)
    levels[::4] *= 0.2
    return np.repeat(levels, 5)


@pytest.mark.parametrize("lag", [0.0, 0.03])
@pytest.mark.parametrize("external", [0.0, 4e-4])
def test_momentum_changes_by_the_external_torque_alone(external, lag):
    table = make_table(external=external, lag=lag)
    for seed in range(5):
        states = go(table, random_currents(seed), rate=0.02, speed=0.3)
        crossings = np.sum(states.speed[1:] * states.speed[:-1] < 0.0)
        assert crossings >= 4
        assert np.sum(states.speed == 0.0) >= 10
        momentum = WHEEL_INERTIA * states.speed + (INERTIA + WHEEL_INERTIA) * states.rate
        np.testing.assert_allclose(
            table.momentum(states), momentum, rtol=1e-14, atol=1e-16 * np.max(np.abs(momentum))
        )
        expected = momentum[0] + external * 0.1 * np.arange(PERIODS + 1)
        scale = WHEEL_INERTIA * np.max(np.abs(states.speed))
        assert np.max(np.abs(momentum - expected)) < 1e-12 * scale


def test_momentum_takes_up_the_integral_of_a_torque_history():
    """Of a cubic in time a fourth-order scheme makes no error, wherever the events cut it."""

    def cubic(time):
        return 2e-4 - 6e-5 * time + 1e-5 * time**2 - 4e-7 * time**3

    table = make_table(history=cubic, external=1e-4)
    states = go(table, random_currents(1))
    assert np.sum(states.speed[1:] * states.speed[:-1] < 0.0) >= 5
    time = 0.1 * np.arange(PERIODS + 1)
    impulse = 3e-4 * time - 3e-5 * time**2 + 1e-5 / 3.0 * time**3 - 1e-7 * time**4
    momentum = np.asarray(table.momentum(states))
    np.testing.assert_allclose(momentum, impulse, rtol=0.0, atol=1e-12 * np.max(np.abs(impulse)))


positive = st.floats(1e-2, 1e2)


@given(
    inertia=positive,
    wheel_inertia=st.floats(1e-4, 1.0),
    viscous=st.floats(0.0, 1e-2),
    coulomb=st.floats(1e-5, 1e-1),
    static=st.floats(0.3, 3.0),
    scale=st.floats(0.05, 20.0),
    speed=st.floats(-100.0, 100.0),
    # the square of a smaller rate is no normal number
    rate=st.floats(-1.0, 1.0).filter(lambda rate: rate == 0.0 or abs(rate) > 1e-100),
    period=st.floats(1e-3, 1.0),
)
def test_energy_never_grows_without_motor_and_external_torque(
    inertia, wheel_inertia, viscous, coulomb, static, scale, speed, rate, period
):
    friction = (viscous, coulomb, static * coulomb, scale)
    table = make_table(inertia, wheel_inertia, friction=friction)
    states = go(table, 0.0, period, speed=speed, rate=rate)
    energy = 0.5 * inertia * states.rate**2
    energy += 0.5 * wheel_inertia * (states.speed + states.rate) ** 2
    np.testing.assert_allclose(table.kinetic_energy(states), energy, rtol=1e-14)
    momentum = wheel_inertia * speed + (inertia + wheel_inertia) * rate
    whole = inertia + wheel_inertia
    # what friction can take is the energy of the relative motion alone
    own = 0.5 * inertia * wheel_inertia / whole * states.speed**2
    rounding = 1e-13 * np.max(energy)
    assert np.all(np.diff(energy) <= rounding)
    np.testing.assert_allclose(energy, 0.5 * momentum**2 / whole + own, rtol=0.0, atol=rounding)
    # and it ends at rest, never turned back
    assert np.all(states.speed * np.sign(speed) >= 0.0)
    assert np.all(np.diff(np.abs(states.speed)) <= 0.0)


# Powers of two: the wheel's share of the external torque is a quarter without rounding.
LEVEL = 2.0**-10


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_wheel_rests_while_its_share_of_the_load_is_within_the_static_torque(sense):
    def speeds(external, current=0.0):
        table = make_table(3.0, 1.0, 2.0**-4, (0.0, LEVEL, LEVEL, 1.0), external)
        return go(table, current).speed

    edge = sense * 4.0 * LEVEL
    assert np.all(speeds(edge) == 0.0)
    # the external torque turns the table away from under the wheel
    assert np.all(sense * np.diff(speeds(np.nextafter(edge, 2.0 * edge))) < 0.0)
    assert np.all(speeds(0.0, sense * 16.0 * LEVEL) == 0.0)
    # the motor and the share of the external torque: opposed they add up, together they cancel
    assert np.all(speeds(0.5 * edge, -sense * 8.0 * LEVEL) == 0.0)
    assert np.all(sense * np.diff(speeds(0.5 * edge, -sense * 8.1 * LEVEL)) < 0.0)
    assert np.all(speeds(edge, sense * 31.9 * LEVEL) == 0.0)
    assert np.all(sense * np.diff(speeds(edge, sense * 32.1 * LEVEL)) > 0.0)


def test_wheel_and_table_at_rest_turn_as_one_body():
    states = go(make_table(external=8e-4), 0.01)
    time = 0.1 * np.arange(PERIODS + 1)
    whole = INERTIA + WHEEL_INERTIA
    assert np.all(states.speed == 0.0)
    np.testing.assert_allclose(states.rate, 8e-4 / whole * time, rtol=1e-12)
    np.testing.assert_allclose(states.attitude, 4e-4 / whole * time**2, rtol=1e-12)
    assert np.all(states.wheel_angle == 0.0)


@pytest.mark.parametrize("period", [0.1, 0.37])
def test_a_growing_torque_breaks_the_wheel_away_at_its_analytic_time(period):
    """Constant friction and a ramp: the relative speed is a parabola from breakaway on."""
    slope, inertia, wheel_inertia = 6e-4, 0.03, 1.5e-3
    table = make_table(
        inertia,
        wheel_inertia,
        friction=(0.0, 3e-4, 3e-4, 1.0),
        history=lambda time: slope * time,
    )
    states = go(table, 0.0, period)
    share = wheel_inertia / (inertia + wheel_inertia)
    breakaway = 3e-4 / (share * slope)
    time = period * np.arange(PERIODS + 1)
    since = np.maximum(time - breakaway, 0.0)
    assert 10.0 * period < breakaway < time[-20]
    assert np.all(states.speed[since == 0.0] == 0.0)
    # relative acceleration -(share slope) t / J_e = -slope t / J
    expected = -0.5 * slope / inertia * since**2
    np.testing.assert_allclose(states.speed, expected, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("lag", [0.0, 0.004, 0.03, 0.2])
def test_agrees_with_an_event_located_solution(table_reference, lag):
    table = make_table(external=3e-4, lag=lag)
    currents = random_currents(7)
    states = go(table, currents, rate=0.01, speed=-1.3)
    assert np.sum(states.speed == 0.0) >= 5
    assert np.sum(states.speed[1:] * states.speed[:-1] < 0.0) >= 4
    own = table_reference(INERTIA, WHEEL_INERTIA, MOTOR, *FRICTION, torque=3e-4, time_constant=lag)
    state = (0.0, 0.01, -1.3, 0.0, 0.0)
    expected = [state]
    for k, current in enumerate(currents):
        state = own.carry(state, current, 0.1 * k, 0.1)
        expected.append(state)
    # without a lag the current of a state is that of the period before it
    assert not np.any(states.bristle)
    for found, values in zip(states[:5], np.array(expected).T, strict=True):
        np.testing.assert_allclose(found, values, rtol=0.0, atol=5e-7 * np.max(np.abs(values)))


def test_is_of_fourth_order_through_crossings(table_reference):
    """A torque that swings, and a friction curve so wide that it never shortens a step."""
    friction = (2e-3, 1e-3, 1.4e-3, 40.0)

    def swing(time):
        xp = jnp if isinstance(time, jax.Array) else np
        return 0.05 * xp.sin(0.9 * time) + 0.02 * xp.cos(0.31 * time)

    table = make_table(friction=friction, history=swing, wheel_inertia=0.02)
    reference = table_reference(INERTIA, 0.02, MOTOR, *friction, torque=swing)
    end, start = 25.0, (0.0, 0.0, 1.0, 0.0, 0.0)
    expected = reference.carry(start, 0.0, 0.0, end)[2]
    errors = []
    for count in (100, 200, 400):
        state, speeds = table.start(speed=1.0), []
        for part in range(count // 100):  # of one length, so that it is compiled once
            begin = part * 100 * end / count
            states, fine = carried(table, state, np.zeros(100), end / count, begin)
            assert bool(fine)
            state = jax.tree.map(lambda values: np.asarray(values)[-1], states)
            speeds.append(np.asarray(states.speed))
        speeds = np.concatenate(speeds)
        assert np.sum(speeds[1:] * speeds[:-1] < 0.0) >= 5
        errors.append(abs(float(state.speed) - expected))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 3.6), (errors, orders)
    assert errors[-1] < 1e-5


def test_sensitivities_agree_with_central_differences_through_coupled_crossings():
    """By both inertias, motor constant, friction, torque, lag, first speed and first rate."""
    values = np.array([INERTIA, WHEEL_INERTIA, MOTOR, *FRICTION, 3e-4, 0.03, -1.3, 0.011])
    currents = np.repeat([0.11, -0.13, 0.1, -0.12, 0.14], 40)

    def table_of(values):
        table = make_table(*values[:3], tuple(values[3:7]), values[7], values[8])
        return table, {"speed": values[9], "rate": values[10]}

    def ends(values):
        table, start = table_of(values)
        states, _ = carried(table, table.start(**start), currents, 0.1, 0.0)
        return jnp.stack([states.attitude[1:], states.rate[1:], states.speed[1:]])

    def plainly(values):  # the program of the other tests
        table, start = table_of(values)
        states = go(table, currents, **start)
        return np.stack([states.attitude[1:], states.rate[1:], states.speed[1:]])

    slopes = np.asarray(jax.jit(jax.jacfwd(ends))(values))
    nudges = np.array([-2.0, -1.0, 1.0, 2.0]) * 3e-4
    moved = values + nudges[None, :, None] * np.diag(values)[:, None, :]
    ways = np.array([[plainly(each) for each in row] for row in moved])
    crossings = ways[0, 0, 2, 1:] * ways[0, 0, 2, :-1] < 0.0
    assert np.sum(crossings) >= 4
    stencil = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * 3e-4)
    differences = np.tensordot(ways, stencil, (1, 0)) / values[:, None, None]
    for k, difference in enumerate(differences):
        # where a crossing passes the sample time meanwhile, the difference is none
        smooth = np.all(np.sign(ways[k, :, 2]) == np.sign(ways[k, 0, 2]), axis=0)
        assert np.mean(smooth) > 0.95
        own = slopes[..., k]
        scale = np.maximum(np.max(np.abs(own), axis=1), 1e-3)
        error = np.max(np.abs(difference - own)[:, smooth], axis=1)
        assert np.all(error < 5e-7 * scale), (k, error / scale)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("table inertia: found 0", {"inertia": 0.0}),
        ("table inertia: found -1", {"inertia": np.array([1.0, -1.0])}),
        ("wheel inertia: found 0", {"wheel": Wheel(0.0, 0.02, ViscousCoulomb(0.0, 1e-3))}),
        ("wheel inertia: found nan", {"wheel": Wheel(np.nan, 0.02, ViscousCoulomb(0.0, 1e-3))}),
        ("motor_constant: found -0.02", {"wheel": Wheel(1e-3, -0.02, ViscousCoulomb(0.0, 1e-3))}),
        ("external torque", {"external_torque": np.inf}),
        ("driver time_constant: found -1", {"driver": Driver(time_constant=-1.0)}),
        ("driver current_limit: found nan", {"driver": Driver(current_limit=np.nan)}),
        ("driver resistance: found 0", {"driver": Driver(bus_voltage=24.0)}),
    ],
)
def test_refuses_what_no_table_has(name, change):
    good = {"inertia": 1.0, "wheel": Wheel(1e-3, 0.02, ViscousCoulomb(0.0, 1e-3))}
    AirBearingTable(**good).check()
    with pytest.raises(InputError, match=f"^{name}"):
        AirBearingTable(**{**good, **change}).check()
