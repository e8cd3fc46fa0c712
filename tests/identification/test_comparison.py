"""The ranking of friction models."""

import numpy as np
import pytest
from scipy.special import huber

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import RPM
from gyrostat.identification import compare, identify, validate
from gyrostat.identification.fit.loss import Huber
from gyrostat.telemetry import Record
from gyrostat.wheel import Wheel, speed_response
from gyrostat.wheel.friction import Stribeck

INERTIA = 1.5e-3


def by_model(rows):
    return {row.model: row for row in rows}


@pytest.mark.parametrize(("friction", "best"), [("sticky", "stribeck"), ("directional",) * 2])
def test_the_true_model_comes_first(record, friction, best):
    rows = compare(record(friction, sigma_rpm=1.0), inertia=INERTIA, hold={"stribeck_speed": 2.0})
    assert rows[0].model == best
    assert rows[0].bic == 0.0


def test_outliers_weigh_in_the_ranking_what_they_weigh_in_the_fit(record, changed):
    clean = record(seed=7)
    random = np.random.default_rng(0)
    speed = clean.speed.copy()
    hit = random.choice(len(speed), 90, replace=False)
    speed[hit] += random.choice([-1.0, 1.0], 90) * 40.0
    rows = by_model(compare(changed(clean, speed=speed), inertia=INERTIA, loss="huber"))
    noise = min(row.fit.speed_sigma for row in rows.values())
    deviance = {
        name: 2.0 * np.sum(huber(Huber().knee, row.fit.residuals[0] / noise))
        for name, row in rows.items()
    }
    for name in ("viscous-coulomb", "directional"):
        more = len(rows[name].fit.names) - len(rows["stribeck"].fit.names)
        expected = deviance[name] - deviance["stribeck"] + more * np.log(len(speed))
        assert rows[name].bic - rows["stribeck"].bic == pytest.approx(expected, abs=1e-6)


def test_what_a_candidate_does_not_have_is_left_out_for_it(record):
    rows = by_model(
        compare(
            record(),
            inertia=INERTIA,
            free=["stribeck_speed"],
            prior={"static": (9e-4, 1e-4), "stribeck_speed": (0.4, 0.1)},
            start={"static": 9e-4},
            hold={"viscous": 4.83e-6},
            speed_sigma=5.0 * RPM,
        )
    )
    assert rows["viscous-coulomb"].fit.names == ("motor_constant", "coulomb", "initial_speed")
    assert {"static", "stribeck_speed"} <= set(rows["stribeck"].fit.names)
    assert rows["stribeck"].fit.held["viscous"] == 4.83e-6


def test_a_candidate_that_cannot_be_fitted_is_a_row_with_its_reason(record):
    """Held at no value that a wheel has for the one that has the parameter, absent elsewhere."""
    rows = compare(record(), inertia=INERTIA, hold={"static": None})
    assert rows[-1].model == "stribeck"
    assert rows[-1].bic is None
    assert "held static" in rows[-1].failure
    assert rows[0].bic == 0.0


def test_a_known_fit_is_not_made_again(record):
    known = identify(record(), inertia=INERTIA, white_noise=True)
    rows = by_model(compare(record(), inertia=INERTIA, known=known))
    assert rows["stribeck"].fit is known


def test_criteria_rest_on_least_squares(record, plain):
    """Effects beside the model would hide what a friction model misses."""
    assert plain.effects
    row = by_model(compare(record(), inertia=INERTIA, known=plain, models=["stribeck"]))["stribeck"]
    assert row.fit.effects == ()
    np.testing.assert_allclose(row.fit.values, plain.least_squares, rtol=1e-9)


def test_held_out_records_are_predicted_with_the_same_current_between_samples():
    friction = Stribeck(viscous=4.83e-6, coulomb=0.88e-3, static=0.9e-3, stribeck_speed=0.42)
    wheel = Wheel(inertia=INERTIA, motor_constant=0.0228, friction=friction)
    time = 1.0 * np.arange(301)
    current = 0.15 * np.sin(2.0 * np.pi * time / 24.0)
    respond = jax.jit(speed_response, static_argnames="hold")
    speed, _ = respond(wheel, jnp.asarray(time), jnp.asarray(current), 0.0, hold="linear")
    fitted, kept = (
        Record(
            f"linear {seed}",
            time,
            current,
            np.asarray(speed) + 0.1 * np.random.default_rng(seed).standard_normal(301),
            np.ones(301, bool),
        )
        for seed in (1, 2)
    )
    rows = compare([fitted], [kept], inertia=INERTIA, models=["stribeck"], current_hold="linear")
    assert rows[0].held_out_rms == pytest.approx(0.1, rel=0.1)
    direct = validate(rows[0].fit.model, rows[0].fit.parameters, kept, current_hold="linear")
    assert rows[0].held_out_rms == pytest.approx(direct.rms_speed)
