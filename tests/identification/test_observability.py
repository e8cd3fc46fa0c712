"""What a record shows, and what it only seems to show."""

import numpy as np
import pytest

from gyrostat.core.units import RPM
from gyrostat.identification import identify
from gyrostat.identification.uncertainty.observability import judge
from gyrostat.simulation import CurrentRange, Telemetry, bench_record
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import Stribeck

INERTIA = 1.5e-3
SCALE = ("motor_constant", "inertia", "viscous", "coulomb", "static")


def test_the_scale_of_the_torques_rests_on_the_a_priori_alone(record):
    """Current and speed show ratios only: a common factor of all five leaves them as they are."""
    prior = {"static": (0.9055e-3, 0.3e-3)}
    fit = identify(record(), inertia=INERTIA, free=["inertia"], prior=prior, speed_sigma=5.0 * RPM)
    for name in SCALE:
        seen = fit.observability[name]
        assert not seen.observable
        assert abs(seen.significance) < 0.01
        assert "a-priori knowledge" in seen.advice
    assert fit.observability["initial_speed"].observable


def test_a_prior_of_the_inertia_does_not_hide_what_the_record_shows(record):
    """Observability is about the record: it is judged at the inertia given, whatever its sigma."""
    options = {"inertia": INERTIA, "speed_sigma": 5.0 * RPM}
    held = identify(record(), **options)
    known = identify(record(), prior={"inertia": (INERTIA, 0.1 * INERTIA)}, **options)
    assert not known.observability["inertia"].observable
    for name in held.names:
        seen, reference = known.observability[name], held.observability[name]
        assert seen.observable == reference.observable
        assert seen.significance == pytest.approx(reference.significance, rel=0.02)


def test_the_ratios_are_as_certain_as_with_the_inertia_held(record, given):
    prior = {"inertia": (INERTIA, 7.5e-5)}
    free = identify(record(), inertia=INERTIA, prior=prior, speed_sigma=5.0 * RPM)
    motor, inertia = (free.names.index(n) for n in ("motor_constant", "inertia"))
    slope = np.zeros(len(free.names))
    slope[motor] = 1.0 / free.values[inertia]
    slope[inertia] = -free.values[motor] / free.values[inertia] ** 2
    ratio_sigma = np.sqrt(slope @ free.covariance @ slope)
    assert ratio_sigma == pytest.approx(given.sigma[0] / INERTIA, rel=0.01)


def test_a_difference_is_judged_without_cancellation():
    """Two parameters known to 1e6 each, their difference to 1: the square root keeps it."""
    root = np.array([[1e6, 0.0], [1e6, 1.0]])
    values = {"coulomb": 1.0, "static": 6.0}
    seen = judge(Stribeck, values, ("coulomb", "static"), root, lambda *_: "")
    assert seen["static"].significance == pytest.approx(5.0)
    assert seen["coulomb"].significance == pytest.approx(1e-6)
    lower = judge(Stribeck, {**values, "static": -4.0}, ("coulomb", "static"), root, lambda *_: "")
    assert lower["static"].significance == pytest.approx(-5.0)


def below(seed=0):
    """A record whose friction rises as the wheel starts to turn."""
    friction = Stribeck(viscous=4.83e-6, coulomb=0.8795e-3, static=0.5e-3, stribeck_speed=2.0)
    wheel = Wheel(inertia=INERTIA, motor_constant=0.0228, friction=friction)
    return bench_record(
        wheel,
        "steps",
        duration=300.0,
        telemetry=Telemetry(speed_sigma=1.0 * RPM),
        amplitudes=CurrentRange(0.06, 0.15),
        seed=seed,
    )


def test_a_static_torque_clearly_below_coulomb_contradicts_the_model(plain):
    fit = identify(below(), inertia=INERTIA, hold={"stribeck_speed": 2.0})
    assert fit.observability["static"].observable
    assert fit.observability["static"].significance < -2.0
    assert any("below coulomb: the model contradicts the record" in w for w in fit.warnings)
    assert not any("contradicts the record" in w for w in plain.warnings)


def test_a_static_torque_that_nothing_shows_stays_with_coulomb(record, changed):
    whole = record("viscous-coulomb")
    part = (whole.time > 2.0) & (whole.time < 29.0)
    fields = {n: getattr(whole, n)[part] for n in ("time", "current", "speed", "valid")}
    fit = identify(changed(whole, **fields), inertia=INERTIA, hold={"motor_constant": 0.0228})
    assert not fit.observability["static"].observable
    coulomb = fit.parameters["coulomb"]
    assert fit.parameters["static"] == pytest.approx(coulomb, rel=1e-3)
    assert abs(coulomb - 0.8795e-3) < 4.0 * fit.sigma[fit.names.index("coulomb")]
