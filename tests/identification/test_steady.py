"""Friction curves from steady speeds of known wheels."""

import functools
import itertools
import json

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.identification.bench.steady import identify_steady
from gyrostat.identification.read.lines import LINE_PARAMETERS, _cuts
from gyrostat.identification.read.plateaus import find_plateaus
from gyrostat.telemetry import Record
from gyrostat.wheel import Wheel, advance, speed_response
from gyrostat.wheel.friction import DirectionalStribeck, Stribeck, ViscousCoulomb

MOTOR = {"motor_constant": 0.0228}
LINE = ViscousCoulomb(viscous=4.83e-6, coulomb=8.795e-4)
FALL = Stribeck(viscous=4.83e-6, coulomb=8.795e-4, static=1.4e-3, stribeck_speed=4.0)
SPEEDS = (20.0, 40.0, 60.0, 80.0, 50.0, 30.0, -20.0, -40.0, -60.0, -80.0, -50.0, -30.0)
LOW_SPEEDS = (1.5, 2.5, 4.0, 6.0, 9.0, 15.0, 40.0, 80.0, -1.5, -2.5, -4.0, -6.0, -9.0, -40.0, -80.0)

respond = jax.jit(speed_response)


def wheel_of(friction):
    return Wheel(inertia=1.5e-3, motor_constant=0.0228, friction=friction)


def record_of(time, current, speed, setpoint=None, name="bench"):
    return Record(
        name=name,
        time=time,
        current=current,
        speed=speed,
        valid=np.isfinite(speed),
        setpoint=setpoint,
    )


@functools.lru_cache
def quiet_speeds(friction, speeds, jitter):
    """Time, current, speed and setpoint, without noise, of speeds that are reached and held.

    One pulse of current leads to each speed, then the current balances the friction. The pulses
    count on viscous and Coulomb friction; where a Stribeck curve adds to it, the hold starts where
    the simulated wheel has arrived.
    """
    wheel, rng = wheel_of(friction), np.random.default_rng(0)
    step, pulse, hold = 0.1, 80, 300
    decay = np.exp(-LINE.viscous * pulse * step / wheel.inertia)
    parts, now, start = [], 0.0, 0.0
    for target in speeds:
        # the speed that the pulse would lead to in the end, so that it ends at the target
        limit = (target - start * decay) / (1.0 - decay)
        kick = (LINE.viscous * limit + np.sign(target) * LINE.coulomb) / wheel.motor_constant
        duration = step * (1.0 + jitter * rng.uniform(-1.0, 1.0, pulse + hold))
        time = now + np.append(0.0, np.cumsum(duration))
        current = np.full(pulse + hold + 1, kick)
        arrived = float(respond(wheel, jnp.array(time), jnp.array(current), start)[0][pulse])
        balance = float(wheel.friction.torque(arrived, np.sign(arrived))) / wheel.motor_constant
        current[pulse:] = balance
        speed = np.asarray(respond(wheel, jnp.array(time), jnp.array(current), start)[0])
        parts.append((time[:-1], current[:-1], speed[:-1], np.full(pulse + hold, target)))
        now, start = time[-1], arrived
    return tuple(np.concatenate(part) for part in zip(*parts, strict=True))


def held_speeds(
    friction, speeds=SPEEDS, seed=0, *, speed_noise=0.0, current_noise=0.0, quantum=None, jitter=0.0
):
    """A record of speeds that are reached one after the other and held."""
    rng = np.random.default_rng(seed)
    time, current, speed, setpoint = quiet_speeds(friction, speeds, jitter)
    speed = speed + speed_noise * rng.standard_normal(len(speed))
    current = current + current_noise * rng.standard_normal(len(current))
    if quantum is not None:
        speed = quantum * np.round(speed / quantum)
    return record_of(time, current, speed, setpoint)


@jax.jit
def _loop(wheel, setpoint, noise, step):
    def sample(carry, inputs):
        speed, integral = carry
        target, error = inputs
        seen = speed + error
        wanted = 0.033 * (target - seen) + 0.004 * integral
        current = jnp.clip(wanted, -0.15, 0.15)
        integral = jnp.where(wanted == current, integral + step * (target - seen), integral)
        return (advance(wheel, speed, current, 0.0, step).speed, integral), (seen, current)

    return jax.lax.scan(sample, (0.0, 0.0), (setpoint, noise))[1]


def speed_loop(seed, speed_noise=0.52, current_noise=0.002):
    """A wheel in a slow PI speed loop, which feeds the noise of its tachometer into the current."""
    rng = np.random.default_rng(seed)
    setpoint = np.repeat(SPEEDS, 600)
    noise = speed_noise * rng.standard_normal(len(setpoint))
    speed, current = _loop(wheel_of(LINE), jnp.array(setpoint), jnp.array(noise), 0.1)
    current = np.asarray(current) + current_noise * rng.standard_normal(len(setpoint))
    return record_of(0.1 * np.arange(len(setpoint)), current, np.asarray(speed), setpoint)


def without_setpoint(record):
    return record_of(record.time, record.current, record.speed)


def distances(fit, friction):
    """Errors of the estimated friction parameters in standard deviations."""
    truth = friction.parameters()
    return np.array(
        [
            (value - float(truth[name])) / sigma
            for name, value, sigma in zip(fit.names, fit.values, fit.sigma, strict=True)
        ]
    )


@pytest.mark.parametrize("setpoint", [True, False])
def test_quiet_record_gives_the_friction_back(setpoint):
    record = held_speeds(LINE)
    fit = identify_steady(record if setpoint else without_setpoint(record), hold=MOTOR)
    assert fit.model is ViscousCoulomb
    assert fit.parameters["viscous"] == pytest.approx(LINE.viscous, rel=1e-3)
    assert fit.parameters["coulomb"] == pytest.approx(LINE.coulomb, rel=1e-4)


def test_error_falls_with_the_noise():
    errors = []
    for noise in (1.0, 0.1, 0.01):
        record = held_speeds(LINE, speed_noise=0.5 * noise, current_noise=5e-3 * noise)
        fit = identify_steady(record, hold=MOTOR)
        errors.append(abs(fit.parameters["coulomb"] / LINE.coulomb - 1.0))
        assert np.abs(distances(fit, LINE)).max() < 3.5
        assert fit.sigma[1] < 0.02 * noise * LINE.coulomb
    assert errors[2] < 1e-4


@pytest.mark.parametrize("quantum", [None, 0.5])
def test_sigmas_cover_the_error(quantum):
    options = {"speed_noise": 0.3, "current_noise": 5e-3, "jitter": 0.4, "quantum": quantum}
    found = [
        distances(identify_steady(held_speeds(LINE, seed=seed, **options), hold=MOTOR), LINE)
        for seed in range(25)
    ]
    assert np.abs(np.mean(found, axis=0)).max() < 0.6
    assert (np.std(found, axis=0) > 0.65).all()
    assert (np.std(found, axis=0) < 1.3).all()


@pytest.mark.parametrize("setpoint", [True, False])
def test_sigmas_are_safe_where_a_speed_loop_feeds_noise_back(setpoint):
    records = [speed_loop(seed) for seed in range(5)]
    found = [
        identify_steady(r if setpoint else without_setpoint(r), hold=MOTOR, inertia=1.5e-3)
        for r in records
    ]
    errors = np.array([distances(fit, LINE) for fit in found])
    assert np.abs(errors).max() < 2.5
    assert max(fit.sigma[1] for fit in found) < 0.03 * LINE.coulomb


def test_inertia_takes_off_the_torque_of_the_drift():
    record = held_speeds(LINE, speed_noise=0.01)
    drift = 0.002
    # what accelerates the wheel, and what the friction of the added speed takes
    current = record.current + drift * (1.5e-3 + LINE.viscous * record.time) / 0.0228
    speed = record.speed + drift * record.time
    drifting = record_of(record.time, current, speed, record.setpoint)
    plain = identify_steady(drifting, hold=MOTOR)
    known = identify_steady(drifting, hold=MOTOR, inertia=1.5e-3)
    worst = [
        np.abs(f.friction_points.torque - np.sign(s) * LINE.coulomb - LINE.viscous * s).max()
        for f in (plain, known)
        for s in (f.friction_points.speed,)
    ]
    assert worst[0] == pytest.approx(1.5e-3 * drift, rel=0.2)
    assert worst[1] < 0.1 * worst[0]


def test_stribeck_is_chosen_where_low_speeds_show_it():
    errors = []
    for seed in range(6):
        record = held_speeds(FALL, LOW_SPEEDS, seed, speed_noise=0.05, current_noise=2e-3)
        fit = identify_steady(record, hold=MOTOR)
        assert fit.model is Stribeck
        assert all(fit.observability[n].observable for n in fit.names)
        errors.append(distances(fit, FALL))
    assert np.sqrt(np.mean(np.square(errors))) < 1.3


@pytest.mark.parametrize("friction", [LINE, FALL])
def test_stribeck_is_not_chosen_on_high_speeds(friction):
    for seed in range(4):
        record = held_speeds(friction, seed=seed, speed_noise=0.3, current_noise=5e-3)
        assert identify_steady(record, hold=MOTOR).model is ViscousCoulomb


def test_stribeck_that_the_speeds_do_not_show_changes_nothing_else():
    record = held_speeds(LINE, speed_noise=0.3, current_noise=5e-3)
    plain = identify_steady(record, hold=MOTOR)
    asked = identify_steady(record, hold=MOTOR, model="stribeck")
    assert asked.held["stribeck_speed"] == pytest.approx(0.418879)
    assert not asked.observability["static"].observable
    assert any("static: not observable" in w for w in asked.warnings)
    for name in ("viscous", "coulomb"):
        assert asked.parameters[name] == pytest.approx(plain.parameters[name], rel=1e-4)


def test_held_parameters_stay_and_ask_for_their_model():
    record = held_speeds(FALL, LOW_SPEEDS, speed_noise=0.05, current_noise=2e-3)
    fit = identify_steady(record, hold={**MOTOR, "stribeck_speed": 4.0, "viscous": FALL.viscous})
    assert fit.names == ("coulomb", "static")
    assert np.abs(distances(fit, FALL)).max() < 3.5
    assert identify_steady(record, hold={**MOTOR, "stribeck_speed": None}).held[
        "stribeck_speed"
    ] == pytest.approx(0.418879)


def test_each_sense_has_its_own_friction():
    friction = DirectionalStribeck(
        viscous_positive=4.0e-6,
        viscous_negative=6.0e-6,
        coulomb_positive=8.0e-4,
        coulomb_negative=9.5e-4,
        static_positive=8.0e-4,
        static_negative=9.5e-4,
        stribeck_speed=1.0,
    )
    record = held_speeds(friction, speed_noise=0.05, current_noise=2e-3)
    fit = identify_steady(record, hold=MOTOR, model="directional")
    seen = [n for n in fit.names if not n.startswith("static")]
    errors = dict(zip(fit.names, distances(fit, friction), strict=True))
    assert max(abs(errors[n]) for n in seen) < 3.5
    assert all(fit.observability[n].observable for n in seen)
    speeds = (20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0)
    forward = held_speeds(friction, speeds, speed_noise=0.05, current_noise=2e-3)
    half = identify_steady(forward, hold=MOTOR, model="directional")
    assert half.observability["coulomb_positive"].observable
    assert not half.observability["coulomb_negative"].observable
    assert any("all plateaus have one sense" in w for w in half.warnings)


def test_wheel_at_rest_is_no_point_of_the_curve():
    record = held_speeds(LINE, speed_noise=0.3, current_noise=5e-3)
    turning = len(find_plateaus(record))
    rest = np.arange(400)
    stuck = record_of(
        np.concatenate([record.time, record.time[-1] + 0.1 * (1.0 + rest)]),
        np.append(record.current, np.full(400, 0.02)),
        np.append(record.speed, 0.3 * np.random.default_rng(1).standard_normal(400)),
    )
    assert len(find_plateaus(stuck)) == turning == len(SPEEDS)


def test_missing_speeds_and_outliers_are_survived():
    record = held_speeds(LINE, speed_noise=0.3, current_noise=5e-3)
    rng = np.random.default_rng(2)
    speed = np.where(rng.random(len(record.speed)) < 0.1, np.nan, record.speed)
    speed = np.where(rng.random(len(speed)) < 0.002, 0.0, speed)
    fit = identify_steady(record_of(record.time, record.current, speed), hold=MOTOR)
    assert np.abs(distances(fit, LINE)).max() < 3.5


def test_records_are_fitted_together():
    forward = held_speeds(LINE, (20.0, 40.0, 60.0), 0, speed_noise=0.3, current_noise=5e-3)
    back = held_speeds(LINE, (-30.0, -60.0, -90.0), 1, speed_noise=0.3, current_noise=5e-3)
    fit = identify_steady([forward, back], hold=MOTOR)
    assert len(fit.friction_points.speed) == 6
    assert fit.records == (forward, back)
    assert np.abs(distances(fit, LINE)).max() < 3.5


def test_long_record_is_searched_in_means():
    short = held_speeds(LINE, (30.0, -60.0, 80.0), speed_noise=0.3, current_noise=5e-3)
    repeat = 40
    fine = (short.time[:, None] + 0.1 / repeat * np.arange(repeat)).ravel()
    rng = np.random.default_rng(0)
    long = record_of(
        fine,
        np.repeat(short.current, repeat),
        np.interp(fine, short.time, short.speed) + 0.3 * rng.standard_normal(len(fine)),
    )
    fit = identify_steady(long, hold=MOTOR)
    assert len(fit.friction_points.speed) >= 3
    assert fit.parameters["coulomb"] == pytest.approx(LINE.coulomb, rel=0.05)


def test_lines_are_cut_where_no_other_cut_is_better():
    rng = np.random.default_rng(3)
    time = np.cumsum(rng.uniform(0.5, 1.5, 11))
    speed = np.where(time < 5.0, 2.0 * time, 10.0) + 0.3 * rng.standard_normal(11)
    floor = 0.2

    def cost(ends):
        total = 0.0
        for first, last in itertools.pairwise([0, *ends]):
            t, w = time[first:last], speed[first:last]
            line = np.polyval(np.polyfit(t, w, 1), t) if last - first > 1 else w
            misfit = float(np.mean((w - line) ** 2))
            total += (last - first) * np.log(max(misfit, floor**2))
            total += LINE_PARAMETERS * np.log(len(time))
        return total

    inner = range(1, len(time))
    every = [
        [*ends, len(time)]
        for size in range(len(time))
        for ends in itertools.combinations(inner, size)
    ]
    assert cost(_cuts(time, speed, floor)) == pytest.approx(min(map(cost, every)), abs=1e-9)


def test_result_has_the_shape_of_every_fit():
    record = held_speeds(LINE, speed_noise=0.3, current_noise=5e-3)
    fit = identify_steady(record, hold=MOTOR)
    assert fit.predicted == fit.residuals == ()
    assert fit.rms_speed is None
    content = json.loads(json.dumps(fit.to_dict(), allow_nan=False))
    assert content["method"] == "steady"
    assert content["rms_speed"] is None
    assert content["held"] == MOTOR
    assert content["parameters"]["viscous"]["unit"] == "N·m·s/rad"
    assert 0.2 < fit.speed_sigma < 0.4
    torque, sigma = fit.friction_curve(fit.friction_points.speed)
    near = np.abs(torque - fit.friction_points.torque) / np.hypot(sigma, fit.friction_points.sigma)
    assert near.max() < 4.0
    with pytest.raises(InputError, match="steady does not identify the inertia"):
        fit.wheel()
    whole = identify_steady(record, hold=MOTOR, inertia=1.5e-3).wheel()
    assert whole.motor_constant == MOTOR["motor_constant"]
    assert whole.inertia == 1.5e-3


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        ({}, "motor_constant: found none"),
        ({"hold": {"motor_constant": None}}, "held motor_constant: found no value"),
        ({"hold": {"motor_constant": -0.1}}, "motor_constant: found -0.1, expected more than 0"),
        ({"hold": {"motor_constant": np.nan}}, "motor_constant: found nan"),
        ({"hold": {**MOTOR, "colour": 1.0}}, "hold: found 'colour'"),
        ({"hold": MOTOR, "inertia": 0.0}, "inertia: found 0, expected more than 0 kg·m²"),
        ({"hold": MOTOR, "inertia": -1.0}, "inertia: found -1"),
        ({"hold": MOTOR, "model": "magnetic"}, "model: found 'magnetic'"),
        (
            {"hold": MOTOR, "speed_sigma": 0.0},
            "speed sigma: found 0, expected a finite value above 0",
        ),
        ({"hold": {**MOTOR, "viscous": 0.0, "coulomb": 0.0}}, "found every friction parameter"),
    ],
)
def test_bad_requests_are_refused_in_one_line(request_, message):
    record = held_speeds(LINE, speed_noise=0.3)
    with pytest.raises(InputError, match=message) as refused:
        identify_steady(record, **request_)
    assert "\n" not in str(refused.value)


def test_records_without_plateaus_are_refused(record):
    time = 0.1 * np.arange(1000)
    noise = np.random.default_rng(0).standard_normal(1000)
    ramp = record_of(time, np.full(1000, 0.1), 0.5 * time + 0.5 * noise, name="ramp")
    rest = record_of(time, np.full(1000, 0.01), 0.5 * noise, name="rest")
    tiny = record_of(time[:3], np.full(3, 0.1), np.array([1.0, 2.0, np.nan]), name="tiny")
    one = held_speeds(LINE, (40.0,), speed_noise=0.3)
    for poor in (ramp, rest, tiny, one, record("viscous-coulomb", "steps")):
        with pytest.raises(InputError, match="of steady speed, expected at least 2") as refused:
            identify_steady(poor, hold=MOTOR)
        assert str(refused.value).startswith(f"{poor.name}: found ")
    with pytest.raises(InputError, match="records: found none"):
        identify_steady([], hold=MOTOR)
    blind = record_of(time, np.full(1000, 0.1), np.full(1000, np.nan))
    with pytest.raises(InputError, match="found 0 samples"):
        identify_steady(blind, hold=MOTOR)
