"""The motor constant from steps of current."""

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.identification import identify_torque_step
from gyrostat.telemetry import Record
from gyrostat.wheel import Wheel, speed_response
from gyrostat.wheel.friction import ViscousCoulomb

INERTIA = 1.5e-3

respond = jax.jit(speed_response)


@pytest.mark.parametrize("friction", ["viscous-coulomb", "directional"])
def test_noise_free_steps_give_the_motor_constant_whatever_the_friction(record, friction):
    fit = identify_torque_step(record(friction, sigma_rpm=0.0), inertia=INERTIA)
    assert fit.names == ("motor_constant",)
    # direction-dependent viscous friction bends each sense of rotation in its own way
    assert fit.values[0] == pytest.approx(
        0.0228, rel=1e-6 if friction == "viscous-coulomb" else 1e-3
    )


def test_sigma_is_honest_over_seeds(record):
    fits = [
        identify_torque_step(record("viscous-coulomb", seed=s), inertia=INERTIA) for s in range(60)
    ]
    relative = [(f.values[0] - 0.0228) / f.sigma[0] for f in fits]
    assert abs(np.mean(relative)) < 4.0 / np.sqrt(60.0)
    assert 0.65 < np.std(relative) < 1.35


def test_missing_samples_and_jitter(record):
    spoiled = record("viscous-coulomb", dropouts=0.3, jitter=0.2)
    fit = identify_torque_step(spoiled, inertia=INERTIA)
    assert abs(fit.values[0] - 0.0228) < 4.0 * fit.sigma[0]


def test_it_identifies_no_friction_and_says_so(record):
    fit = identify_torque_step(record("viscous-coulomb"), inertia=INERTIA)
    assert fit.wheel_model() is None
    with pytest.raises(InputError):
        fit.wheel()


def test_what_cannot_be_met_is_said(record):
    steps = record("viscous-coulomb")
    for options, message in (
        ({"inertia": None}, "inertia: found none"),
        ({"inertia": 0.0}, "inertia: found 0"),
        ({"inertia": INERTIA, "hold": {"motor_constant": 1.0}}, "'motor_constant'"),
    ):
        with pytest.raises(InputError) as caught:
            identify_torque_step(steps, **options)
        assert message in str(caught.value)
    with pytest.raises(InputError) as caught:
        identify_torque_step(record("viscous-coulomb", "sines"), inertia=INERTIA)
    assert "found no step" in str(caught.value)


def staircase(seed):
    """A wheel that keeps its sense, its current now above and now below the friction."""
    wheel = Wheel(
        inertia=INERTIA,
        motor_constant=0.0228,
        friction=ViscousCoulomb(viscous=4.83e-6, coulomb=0.8795e-3),
    )
    time = 0.1 * np.arange(2400)
    current = np.where((time // 10.0) % 2, 0.03, 0.08)
    speed, _ = respond(wheel, jnp.array(time), jnp.array(current), 40.0)
    noise = 0.5 * np.random.default_rng(seed).standard_normal(len(time))
    return Record("staircase", time, current, np.asarray(speed) + noise, np.ones(2400, bool))


def test_no_speed_counts_twice_where_the_sense_never_changes():
    fits = [identify_torque_step(staircase(seed), inertia=INERTIA) for seed in range(40)]
    assert fits[0].samples <= 2400
    relative = [(f.values[0] - 0.0228) / f.sigma[0] for f in fits]
    assert abs(np.mean(relative)) < 4.0 / np.sqrt(40.0)
    assert 0.65 < np.std(relative) < 1.2


def test_a_record_without_speeds_is_refused(record, changed):
    steps = record("viscous-coulomb")
    nothing = np.full(len(steps.time), np.nan)
    blind = changed(steps, speed=nothing, valid=np.isfinite(nothing))
    with pytest.raises(InputError, match="found 0 samples"):
        identify_torque_step(blind, inertia=INERTIA)


def test_a_step_that_the_drive_spreads_over_two_samples_is_one_step(record, changed):
    """The rise is part of the current that the wheel saw, so the truth is known."""
    wheel = Wheel(
        inertia=INERTIA,
        motor_constant=0.0228,
        friction=ViscousCoulomb(viscous=4.83e-6, coulomb=0.8795e-3),
    )
    time = 0.1 * np.arange(2400)
    current = np.where((time // 20.0) % 2, 0.03, 0.08)
    edges = np.flatnonzero(np.diff(current)) + 1
    current[edges] = 0.3 * current[edges - 1] + 0.7 * current[edges]
    speed, _ = respond(wheel, jnp.array(time), jnp.array(current), 40.0)
    spread = Record("spread", time, current, np.asarray(speed), np.ones(2400, bool))
    fit = identify_torque_step(spread, inertia=INERTIA)
    assert fit.samples > 2000
    assert fit.values[0] == pytest.approx(0.0228, rel=1e-4)


def test_each_sense_of_rotation_has_its_own_viscous_friction(record):
    """Over seeds, quiet records of a wheel whose friction depends on the sense."""
    relative = []
    for seed in range(12):
        fit = identify_torque_step(record("directional", seed=seed, sigma_rpm=0.1), inertia=INERTIA)
        relative.append((fit.values[0] - 0.0228) / fit.sigma[0])
    assert 0.4 < np.sqrt(np.mean(np.square(relative))) < 1.6


def test_wrong_units_and_a_wrong_noise_are_suspected(record, changed):
    steps = record("viscous-coulomb")
    mixed = changed(steps, speed=steps.speed * 30.0 / np.pi)
    assert any("units" in w for w in identify_torque_step(mixed, inertia=INERTIA).warnings)
    stated = identify_torque_step(steps, inertia=INERTIA, speed_sigma=0.05)
    assert any("stated speed sigma is 0.05" in w for w in stated.warnings)
    assert identify_torque_step(steps, inertia=INERTIA).warnings == ()
