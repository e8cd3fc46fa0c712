"""Prediction of a record by a wheel that was not fitted to it."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.identification import validate
from gyrostat.wheel import Wheel, speed_response
from gyrostat.wheel.friction import Stribeck

INERTIA = 1.5e-3

respond = jax.jit(speed_response)


def rms(values, record, initial):
    """Residual of a forward simulation."""
    friction = Stribeck(**{n: values[n] for n in Stribeck.dimensions()})
    wheel = Wheel(values["inertia"], values["motor_constant"], friction)
    speed, _ = respond(wheel, jnp.asarray(record.time), jnp.asarray(record.current), initial)
    return float(np.sqrt(np.mean((record.speed - np.asarray(speed)) ** 2)))


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("static", 1.0),
        ("coulomb", 1.5),
        ("coulomb", 2.5),
        ("static", 4.0),
        ("motor_constant", 0.4),
        ("motor_constant", -1.0),
    ],
)
def test_a_wheel_however_bad_has_a_residual(record, truth, name, factor):
    """Even one that rests where the real one turns."""
    values = {**truth["stribeck"], name: factor * truth["stribeck"][name]}
    result = validate(Stribeck, values, record())
    assert result.converged
    found = result.initial_speed
    assert abs(found) < 5.0
    assert result.rms_speed == pytest.approx(rms(values, record(), found), rel=1e-9)
    if factor == 1.0:
        best = minimize_scalar(lambda w: rms(values, record(), w), bounds=(-1, 1), method="bounded")
        assert result.rms_speed == pytest.approx(best.fun, rel=1e-4)


def test_the_offset_of_the_drive_can_be_told(record, changed, truth):
    biased = changed(record(), current=record().current - 0.005)
    without = validate(Stribeck, truth["stribeck"], biased)
    told = validate(Stribeck, {**truth["stribeck"], "current_bias": 0.005}, biased)
    plain = validate(Stribeck, truth["stribeck"], record())
    assert told.rms_speed == pytest.approx(plain.rms_speed, rel=1e-6)
    assert without.rms_speed > 1.5 * plain.rms_speed


def test_a_wheel_that_lacks_a_parameter_is_refused(record, truth):
    values = {n: v for n, v in truth["stribeck"].items() if n != "inertia"}
    with pytest.raises(InputError, match="found no inertia"):
        validate(Stribeck, values, record())


def test_missing_samples_are_skipped(record, truth):
    gaps = record(dropouts=0.3)
    result = validate(Stribeck, truth["stribeck"], gaps)
    assert result.samples == int(gaps.valid.sum())
    assert result.rms_speed == pytest.approx(0.5236, rel=0.08)


def test_spread_and_information_are_those_of_predictions_with_a_refitted_start(record, truth):
    """Derivatives as differences of two predictions, each with the best initial speed."""
    values, given = truth["stribeck"], record(dropouts=0.1)
    names = ("viscous", "coulomb")
    sigmas = np.array([0.02 * values[name] for name in names])
    found = validate(Stribeck, values, given, covariance=(names, np.diag(sigmas**2)))
    columns = []
    for name in names:
        moved = [{**values, name: factor * values[name]} for factor in (1.001, 0.999)]
        above, below = (validate(Stribeck, each, given).predicted for each in moved)
        columns.append((above - below) / (0.002 * values[name]))
    columns = np.array(columns).T
    spread = np.sqrt((columns * sigmas) ** 2 @ np.ones(2))
    # but for the samples at which the wheel sticks or not
    assert np.mean(np.abs(found.predicted_sigma - spread) < 0.01 * spread.max()) > 0.995
    used = columns[given.valid]
    information = used.T @ used / found.noise**2
    size = np.sqrt(np.outer(np.diag(information), np.diag(information)))
    np.testing.assert_allclose(found.information / size, information / size, rtol=0, atol=0.01)
