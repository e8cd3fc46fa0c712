"""A wheel like that of Carrara and Kuga on the virtual bench."""

import functools

import numpy as np
import pytest

from gyrostat.core.units import RPM
from gyrostat.identification import identify
from gyrostat.simulation import CurrentRange, Telemetry, bench_record
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import DirectionalStribeck, Stribeck, ViscousCoulomb

INERTIA = 1.5e-3
FRICTION = {
    "viscous-coulomb": ViscousCoulomb(viscous=4.83e-6, coulomb=0.8795e-3),
    "stribeck": Stribeck(
        viscous=4.83e-6, coulomb=0.8795e-3, static=0.9055e-3, stribeck_speed=0.418879
    ),
    "sticky": Stribeck(viscous=4.83e-6, coulomb=0.8795e-3, static=1.4e-3, stribeck_speed=2.0),
    "directional": DirectionalStribeck(
        viscous_positive=4.0e-6,
        viscous_negative=6.0e-6,
        coulomb_positive=0.8e-3,
        coulomb_negative=0.95e-3,
        static_positive=1.1e-3,
        static_negative=1.2e-3,
        stribeck_speed=1.0,
    ),
}


@functools.lru_cache
def make_record(friction="stribeck", profile="steps", seed=0, sigma_rpm=5.0, **options):
    wheel = Wheel(inertia=INERTIA, motor_constant=0.0228, friction=FRICTION[friction])
    period = options.pop("period", None)
    duration = options.pop("duration", 300.0)
    return bench_record(
        wheel,
        profile,
        duration=duration,
        telemetry=Telemetry(speed_sigma=sigma_rpm * RPM, **options),
        amplitudes=CurrentRange(0.06, 0.15),
        period=period,
        seed=seed,
        name=f"{friction}-{profile}-{seed}",
    )


@pytest.fixture(scope="session")
def record():
    """Make a record of a known wheel: friction, profile, seed, sigma_rpm, telemetry options."""
    return make_record


@pytest.fixture(scope="session")
def followed(record):
    """Fit of the plain record with the inertia alone; stage and count of each progress report."""
    stages = []
    fit = identify(
        record(),
        inertia=INERTIA,
        on_progress=lambda stage, count, cost: stages.append((stage, count)),
    )
    return fit, stages


@pytest.fixture(scope="session")
def plain(followed):
    """Fit of the plain record with the inertia alone."""
    return followed[0]


@pytest.fixture(scope="session")
def given(record):
    """Fit of the plain record with the inertia and the noise."""
    return identify(record(), inertia=INERTIA, speed_sigma=5.0 * RPM)


@pytest.fixture
def truth():
    """True parameters by friction name."""
    return {
        name: {"motor_constant": 0.0228, "inertia": INERTIA, **model.parameters()}
        for name, model in FRICTION.items()
    }


@pytest.fixture
def changed():
    """Copy a record with some fields replaced."""
    import dataclasses

    def change(record, **fields):
        return dataclasses.replace(record, **{k: np.asarray(v) for k, v in fields.items()})

    return change
