"""The loop: runs and batches, delays, failures as data, and what it refuses."""

from dataclasses import dataclass
from typing import NamedTuple

import equinox as eqx
import numpy as np
import pytest
import xarray as xr

from gyrostat.control import AttitudePID, CurrentMode, EstimatingCompensator
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.simulation import Status, control_loop, simulate, stack
from gyrostat.spacecraft import AirBearingTable, Gyro, TableCommand, TableSensors
from gyrostat.wheel import Delayed, Driver, LowPass, PulseTachometer, Tachometer, Wheel
from gyrostat.wheel.friction import ViscousCoulomb

PERIOD, COUNT = 0.1, 100
NOISY = TableSensors(Gyro(1e-4), Tachometer(0.3))
QUIET = TableSensors(Gyro(0.0), Tachometer(0.0))
PID = (0.06, 0.01, 0.2)


def controller(gains=PID, motor=0.02):
    return CurrentMode(AttitudePID(*gains), motor)


@pytest.fixture(scope="module")
def loop(g2):
    """`simulate` with what is the same in most tests here, so that little is compiled."""

    def call(plant=g2.table, control=None, sensor=QUIET, **options):
        control = controller() if control is None else control
        options.setdefault("start", g2.table.start(attitude=0.01, speed=-3.0))
        options = {"duration": PERIOD * COUNT, "control_period": PERIOD, **options}
        return simulate(plant, control, sensor, **options)

    return call


@pytest.fixture(scope="module")
def noisy(loop, g2):
    """Three runs that differ by their noise, and the controllers' gains where given."""

    def call(seed=0, sensor=NOISY, gains=(PID,) * 3):
        start = g2.table.start(attitude=0.01, speed=-3.0)
        plant, sensor, start = (stack([x] * 3) for x in (g2.table, sensor, start))
        control = stack([controller(g) for g in gains])
        return loop(plant, control, sensor, start=start, runs=3, seed=seed)

    return call


@pytest.fixture(scope="module")
def quiet(loop):
    return loop()


def test_a_folded_run_is_the_run(g2, noisy):
    def fold(kept, row, k):
        count, _, total = kept
        return (count + (row.status == 0), k, total + row.measurement.speed), None

    zero = jnp.zeros(())
    start = g2.table.start(attitude=0.01, speed=-3.0)
    key = jax.random.split(jax.random.key(0), 3)[1]
    loop = control_loop(g2.table, controller(), NOISY, start, key, PERIOD)
    folded = loop.folded(fold, (zero, jnp.array(0), zero))
    (_, (count, last, total)), rows = folded.scan(folded.begin(), jnp.array(0), COUNT + 1)
    assert rows is None
    assert count == COUNT + 1
    assert last == COUNT
    whole = noisy().isel(run=1)
    assert total == pytest.approx(float(np.sum(whole.measured_speed)), rel=1e-9)


def test_histories_have_names_units_and_coordinates(quiet):
    assert quiet.sizes == {"time": COUNT + 1}
    np.testing.assert_allclose(quiet.time, PERIOD * np.arange(COUNT + 1))
    units = {name: quiet[name].attrs.get("units") for name in quiet.variables}
    assert units == {
        "time": "s",
        "run": None,
        "attitude": "rad",
        "rate": "rad/s",
        "speed": "rad/s",
        "wheel_angle": "rad",
        "current": "A",
        "bristle": "rad",
        "measured_attitude": "rad",
        "measured_rate": "rad/s",
        "measured_speed": "rad/s",
        "commanded_current": "A",
        "attitude_current": "A",
        "friction_current": "A",
        "saturated": "1",
        "power": "W",
        "status": None,
        "valid_until": "s",
    }
    assert quiet.status == Status.COMPLETE
    assert quiet.valid_until == PERIOD * COUNT
    assert quiet.status.attrs["flag_meanings"].split()[int(Status.DIVERGED)] == "diverged"
    # without a lag the motor carries what was commanded a period before
    np.testing.assert_array_equal(quiet.current[1:], quiet.commanded_current[:-1])
    np.testing.assert_array_equal(quiet.measured_speed, quiet.speed)
    heat = 0.0228 * quiet.commanded_current * quiet.speed
    np.testing.assert_allclose(quiet.power, heat, rtol=1e-14)


def test_histories_survive_netcdf(noisy, tmp_path):
    data = noisy(2)
    data.to_netcdf(tmp_path / "runs.nc", engine="h5netcdf")
    again = xr.load_dataset(tmp_path / "runs.nc", engine="h5netcdf")
    xr.testing.assert_identical(data, again)
    assert data.sizes == {"run": 3, "time": COUNT + 1}
    assert again.saturated.dtype == bool


def test_a_run_of_a_batch_is_the_run_alone(loop, g2):
    """Every run its own plant, controller, sensor and start."""
    inertias, gains = (0.4, 0.5, 0.6), ((0.05, 0.0, 0.2), (0.1, 0.01, 0.3), PID)
    plants = [AirBearingTable(j, g2.wheel, external_torque=4e-4) for j in inertias]
    controls = [controller(g, 0.02 + 0.001 * k) for k, g in enumerate(gains)]
    sensors = [TableSensors(Gyro(0.0, 1e-5 * k), Tachometer(0.0)) for k in range(3)]
    starts = [g2.table.start(attitude=0.002 * k, speed=k - 3.0) for k in range(3)]
    parts = (plants, controls, sensors, starts)
    plant, control, sensor, start = (stack(x) for x in parts)
    batch = loop(plant, control, sensor, start=start, runs=3)
    for k, (plant, control, sensor, start) in enumerate(zip(*parts, strict=True)):
        alone = loop(plant, control, sensor, start=start)
        assert set(alone.data_vars) == set(batch.data_vars)
        for name in alone.data_vars:
            np.testing.assert_allclose(
                batch[name][k], alone[name], rtol=1e-9, atol=1e-13, err_msg=name
            )
    assert np.ptp(batch.speed.values[:, -1]) > 0.5


def test_equal_seeds_give_equal_noise_and_every_run_its_own(noisy):
    first, again, other = (noisy(seed) for seed in (1, 1, 2))
    xr.testing.assert_identical(first, again)
    assert not np.any(first.measured_speed == other.measured_speed)
    noise = (first.measured_speed - first.speed) / 0.3
    assert abs(np.corrcoef(noise)[np.triu_indices(3, 1)]).max() < 4.0 / np.sqrt(COUNT)
    assert 0.7 < float(noise.std()) < 1.3


def test_smaller_steps_give_the_same_run(loop, quiet):
    fine = loop(step=0.025)
    for name in ("attitude", "rate", "speed", "wheel_angle", "commanded_current"):
        scale = float(np.max(np.abs(quiet[name])))
        np.testing.assert_allclose(fine[name], quiet[name], rtol=0.0, atol=1e-7 * scale)
    assert np.any(fine.speed != quiet.speed)


def test_an_unstable_loop_is_reported_with_its_time_and_no_numbers_after(noisy):
    data = noisy(gains=(PID, (-5.0, 0.0, 0.0), (0.06, 0.0, -9.0)))
    assert data.status.values.tolist() == [Status.COMPLETE, Status.DIVERGED, Status.DIVERGED]
    assert data.valid_until[0] == PERIOD * COUNT
    for k in (1, 2):
        until = float(data.valid_until[k])
        assert PERIOD <= until < PERIOD * (COUNT - 5)
        ended = data.isel(run=k)
        valid = ended.time.values <= until + 1e-9
        for name, values in ended.data_vars.items():
            if values.dtype.kind == "f" and values.ndim:
                assert np.all(np.isfinite(values[valid])), name
                assert np.all(np.isnan(values[~valid])), name
        assert not np.any(ended.saturated[~valid])
        assert np.all(np.abs(ended.attitude[valid]) < np.pi)


def test_a_wheel_that_saturates_is_flagged(loop, g2):
    limit = 0.011
    table = AirBearingTable(
        g2.inertia, g2.wheel, Driver(current_limit=limit), external_torque=g2.fan
    )
    data = loop(table, start=table.start(attitude=0.01, speed=-3.0))
    beyond = np.abs(data.commanded_current) > limit
    assert 5 < np.sum(beyond) < COUNT - 5
    np.testing.assert_array_equal(data.saturated, beyond)
    applied = np.clip(data.commanded_current, -limit, limit)
    np.testing.assert_allclose(data.current[1:], applied[:-1], rtol=1e-15)


class Position(NamedTuple):
    attitude: float
    rate: float


class Cart:
    """A plant as a user writes one: a unit mass, exact, that knows no friction."""

    def check(self):
        pass

    def diverged(self, state):
        return jnp.abs(state.attitude) > 1e6

    def record(self, state, command):
        return Position(0.0 * state.attitude, 2.0 * state.rate)

    def __call__(self, state, command, time, duration):
        rate = state.rate + command.current * duration
        return Position(state.attitude + 0.5 * (state.rate + rate) * duration, rate), jnp.array(
            True
        )


class Sight:
    """A sensor as a user writes one."""

    def start(self, state, period):
        return ()

    def __call__(self, memory, state, key):
        return memory, state


@dataclass
class Pushing:
    """A controller as a user writes one: a plain class, plain numbers."""

    current: float
    fails_from: float = np.inf

    def start(self, period):
        return 0

    def __call__(self, memory, measurement):
        bad = (memory >= self.fails_from) & (measurement.attitude > 0.0)
        current = jnp.where(bad, jnp.nan, self.current) if self.fails_from < 99 else self.current
        return memory + 1, TableCommand(current)


OWN = {"duration": 1.0, "control_period": PERIOD}


def test_plain_classes_are_plants_sensors_and_controllers():
    control = Pushing(0.5)
    first = simulate(Cart(), control, Sight(), start=Position(0.0, 1.0), **OWN)
    time = first.time.values
    np.testing.assert_allclose(first.rate, 1.0 + 0.5 * time, rtol=1e-14)
    np.testing.assert_allclose(first.attitude, time + 0.25 * time**2, rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(first.recorded_rate, 2.0 * first.rate)
    np.testing.assert_array_equal(first.measured_rate, first.rate)
    # compiled code is kept, the values of a plain object are not
    control.current = -0.5
    second = simulate(Cart(), control, Sight(), start=Position(0.0, 1.0), **OWN)
    np.testing.assert_allclose(second.rate, 1.0 - 0.5 * time, rtol=1e-13)


@pytest.mark.parametrize("delay", [1, 4])
def test_a_delayed_command_acts_later(delay):
    start = Position(0.0, 1.0)
    late = simulate(Cart(), Pushing(0.5), Sight(), start=start, command_delay=delay, **OWN)
    np.testing.assert_array_equal(late.current, [0.0] * delay + [0.5] * (11 - delay))
    since = np.maximum(late.time - delay * PERIOD, 0.0)
    np.testing.assert_allclose(late.rate, 1.0 + 0.5 * since, rtol=1e-14)


@pytest.mark.parametrize("delay", [0, 3])
def test_nan_of_a_controller_names_it_and_the_time(delay):
    control, options = Pushing(0.0, fails_from=3), {"command_delay": delay, **OWN}
    message = r"^Pushing: found a command that is not finite at 0\.3 s, expected"
    with pytest.raises(InputError, match=message):
        simulate(Cart(), control, Sight(), start=Position(1.0, 0.0), **options)
    starts = stack([Position(x, 0.0) for x in (-1.0, -2.0, 1.0)])
    message = r"^Pushing: found a command that is not finite at 0\.3 s of run 2, expected"
    with pytest.raises(InputError, match=message):
        simulate(Cart(), control, Sight(), start=starts, runs=3, **options)


def test_a_run_that_starts_beyond_all_bounds_was_never_valid():
    data = simulate(Cart(), Pushing(0.5), Sight(), start=Position(2e6, 0.0), **OWN)
    assert data.status == Status.DIVERGED
    assert np.isnan(data.valid_until)
    assert np.all(np.isnan(data.attitude))


def test_values_of_another_kind_are_not_compiled_again():
    """Plain numbers, numpy's and JAX's; stacked, and one for all."""
    traced = []

    class ModuleCart(Cart, eqx.Module):
        pass

    class ModuleSight(Sight, eqx.Module):
        pass

    class Push(eqx.Module):
        current: float

        def start(self, period):
            return ()

        def __call__(self, memory, measurement):
            traced.append(1)
            return memory, TableCommand(self.current)

    for runs in (None, 2):
        counts = []
        for kind in (float, np.float64, jnp.asarray, lambda x: jnp.asarray(x, float)):
            control, start = Push(kind(0.5)), Position(kind(0.0), kind(1.0))
            if runs:
                control, start = stack([control] * runs), stack([start] * runs)
            simulate(ModuleCart(), control, ModuleSight(), start=start, runs=runs, **OWN)
            counts.append(len(traced))
        assert counts[0] == counts[-1]


def test_more_runs_than_are_carried_together_keep_their_order():
    told = []
    starts = stack([Position(float(k), 0.0) for k in range(150)])
    data = simulate(
        Cart(),
        Pushing(0.5),
        Sight(),
        start=starts,
        runs=150,
        on_progress=lambda *now: told.append(now),
        **OWN,
    )
    np.testing.assert_allclose(data.attitude[:, -1], np.arange(150) + 0.25, rtol=1e-14)
    assert told == [(64, 150), (128, 150), (150, 150)]


def test_time_reaches_the_plant():
    """Momentum takes up the integral of a cubic torque, whatever the wheel does."""

    def cubic(time):
        return 2e-4 - 6e-5 * time + 1e-5 * time**2 - 4e-7 * time**3

    wheel = Wheel(1.5e-3, 0.0228, ViscousCoulomb(5e-6, 1e-3))
    table = AirBearingTable(0.03, wheel, torque_history=cubic)
    options = {"start": table.start(speed=-3.0), "duration": 10.0, "control_period": PERIOD}
    data = simulate(table, Pushing(0.06), TableSensors(), step=0.05, **options)
    time = data.time.values
    impulse = 2e-4 * time - 3e-5 * time**2 + 1e-5 / 3.0 * time**3 - 1e-7 * time**4
    momentum = 1.5e-3 * data.speed + 0.0315 * data.rate
    np.testing.assert_allclose(momentum, -4.5e-3 + impulse, rtol=0.0, atol=1e-15)
    assert data.speed[0] < 0.0 < data.speed[-1]


@pytest.mark.parametrize(
    ("message", "change"),
    [
        ("duration: found 10.05 s, expected a whole multiple", {"duration": 10.05}),
        ("duration: found 0.05 s, expected a whole multiple", {"duration": 0.05}),
        ("duration: found 0 s", {"duration": 0.0}),
        ("duration: found nan s", {"duration": np.nan}),
        ("control period: found -0.1 s", {"control_period": -0.1}),
        ("control period: found 0.1 s, expected a whole multiple of the step", {"step": 0.03}),
        ("control period: found 0.1 s, expected a whole multiple of the step", {"step": 0.2}),
        ("step: found 0 s", {"step": 0.0}),
        ("control period: found 1e-300 s, expected 1e-09 to", {"control_period": 1e-300}),
        (
            "control period: found 1e-300 s, expected 1e-09 to",
            {"duration": 1e-300, "control_period": 1e-300},
        ),
        ("control period: found 1e[+]300", {"duration": 1e300, "control_period": 1e300}),
        ("duration: found 1e[+]300 s, expected a whole multiple", {"duration": 1e300}),
        ("step: found 1e-300 s", {"step": 1e-300}),
        ("runs: found 0", {"runs": 0}),
        ("runs: found -2", {"runs": -2}),
        ("command delay: found -1", {"command_delay": -1}),
    ],
)
def test_refuses_times_and_counts_that_do_not_fit(loop, message, change):
    with pytest.raises(InputError, match=f"^{message}"):
        loop(**change)


def test_refuses_a_batch_of_another_number_of_runs(loop, g2):
    plants = stack([g2.table] * 3)
    for runs, found in ((None, "found a batch, expected one item"), (2, "found a batch of 3, ex")):
        with pytest.raises(InputError, match=f"^plant: {found}"):
            loop(plants, runs=runs)


@pytest.mark.parametrize("inertia", [0.0, -0.5, np.nan, np.inf])
def test_refuses_an_inertia_that_is_none(loop, g2, inertia):
    with pytest.raises(InputError, match=r"^table inertia: found"):
        loop(AirBearingTable(inertia, g2.wheel))
    with pytest.raises(InputError, match=r"^wheel inertia: found"):
        loop(AirBearingTable(1.0, Wheel(inertia, 0.02, g2.wheel.friction)))
    good = AirBearingTable(0.5, g2.wheel)
    with pytest.raises(InputError, match=r"^table inertia: found"):
        loop(stack([good, AirBearingTable(inertia, g2.wheel), good]), runs=3)


@pytest.mark.parametrize(
    ("sensors", "message"),
    [
        (TableSensors(tachometer=Tachometer(np.nan)), "tachometer sigma: found nan"),
        (TableSensors(tachometer=PulseTachometer(0.0)), "tachometer pulses: found 0"),
        (TableSensors(tachometer=LowPass(Tachometer(), 0.0)), "low pass time constant: found 0"),
        (TableSensors(gyro=Gyro(sigma=-1.0)), "gyro sigma: found -1"),
    ],
)
def test_a_bad_sensor_is_named_and_not_the_controller(loop, sensors, message):
    with pytest.raises(InputError, match=message):
        loop(sensor=sensors)


def test_a_start_or_a_tuning_that_is_no_number_is_refused(loop, g2):
    with pytest.raises(InputError, match="start: found"):
        loop(start=g2.table.start(speed=np.nan))
    silent = EstimatingCompensator.tune(g2.law, g2.wheel, 0.495, 0.0, PERIOD)
    with pytest.raises(InputError, match="compensator speed sigma: found 0"):
        loop(control=silent)


def test_a_part_without_a_check_of_its_own_is_taken_as_it_is(loop):
    """A user's sensor behind one of ours: only what offers a check is asked."""

    class Plain:
        def start(self, state, period):
            return ()

        def __call__(self, memory, state, key):
            return memory, state.speed

    late = loop(sensor=TableSensors(tachometer=Delayed(Plain(), 2)))
    assert int(late.status) == Status.COMPLETE
    np.testing.assert_array_equal(late.measured_speed[2:], late.speed[:-2])
