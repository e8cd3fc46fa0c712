"""Start values against the equation of motion, solved in closed form."""

import numpy as np
import pytest

from gyrostat.core.units import RPM
from gyrostat.identification import identify
from gyrostat.identification.fit.start_values import integral_regression
from gyrostat.telemetry import Record

MOTOR, VISCOUS, COULOMB = 16.0, 0.02, 0.5
"""k_m/J, rad/s²/A, b/J, 1/s, and c/J, rad/s²."""


def coasting_and_driven():
    """Speed of a wheel at two constant currents, each a decaying exponential."""
    time = np.arange(0.0, 120.0, 0.05)
    current = np.where(time < 60.0, 0.2, 0.08)
    speed, start = np.empty_like(time), 5.0
    for part, level in ((time < 60.0, 0.2), (time >= 60.0, 0.08)):
        final = (MOTOR * level - COULOMB) / VISCOUS
        decay = np.exp(-VISCOUS * (time[part] - time[part][0]))
        speed[part] = final + (start - final) * decay
        start = final + (start - final) * np.exp(-VISCOUS * 60.0)
    return Record("wheel", time, current, speed, np.ones(len(time), bool))


def test_ratios_are_those_of_the_motion():
    found = integral_regression([coasting_and_driven()])
    assert found.motor == pytest.approx(MOTOR, rel=1e-3)
    assert found.viscous == pytest.approx(VISCOUS, rel=1e-3)
    assert found.coulomb == pytest.approx(COULOMB, rel=1e-3)
    assert found.initial_speeds == pytest.approx([5.0], abs=0.01)


def test_a_parameter_of_the_size_has_the_torque_of_the_motor():
    record, inertia = coasting_and_driven(), 1.5e-3
    found = integral_regression([record])
    level = np.sqrt(np.mean(record.current**2))
    torque = inertia * found.motor * level
    assert found.size("coulomb", "torque", inertia, 0.024) == pytest.approx(torque)
    speed = np.sqrt(np.mean(record.speed**2))
    viscous = found.size("viscous", "viscous", inertia, 0.024)
    assert viscous == pytest.approx(torque / speed)


def test_the_stated_sigma_is_that_of_one_sample_of_a_dense_record():
    """A mean of n samples has 1/sqrt(n) of it: stated and estimated sigma give the same errors."""
    random = np.random.default_rng(11)
    time = np.arange(0.0, 400.0, 0.004)
    current = 0.3 * np.sign(np.sin(2.0 * np.pi * time / 100.0))
    speed, value, signed = np.empty_like(time), 0.0, 0.0
    for k in range(len(time)):
        speed[k] = value
        signed = np.sign(value) or np.sign(current[k])
        value += 0.004 * (MOTOR * current[k] - VISCOUS * value - COULOMB * signed)
    speed += random.normal(0.0, 5.0 * RPM, len(time))
    noisy = Record("dense", time, current, speed, np.ones(len(time), bool))
    options = {"inertia": 1.5e-3, "white_noise": True, "model": "viscous-coulomb"}
    stated = identify(noisy, speed_sigma=5.0 * RPM, **options)
    estimated = identify(noisy, **options)
    ratio = stated.sigma[stated.names.index("viscous")]
    ratio /= estimated.sigma[estimated.names.index("viscous")]
    assert ratio == pytest.approx(1.0, abs=0.1)
