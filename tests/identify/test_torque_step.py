"""The motor constant from steps of current."""

import numpy as np
import pytest

from gyrostat.errors import InputError
from gyrostat.identify import identify_torque_step

INERTIA = 1.5e-3


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
