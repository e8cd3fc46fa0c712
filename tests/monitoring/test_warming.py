"""Viscous friction that falls exponentially with the temperature."""

from dataclasses import replace

import numpy as np
import pytest

from gyrostat.monitoring.moments import VISCOUS, WARMING, Prior
from gyrostat.monitoring.noise import Noise
from gyrostat.monitoring.regression import Rows
from gyrostat.monitoring.warming import about_its_share
from tests.monitoring.test_drive_samples import DURATION, SHEET, smooth_slews, turned
from tests.monitoring.test_instruments import scores


def orbits(swing):
    """Temperature above 20 °C at each second, K."""
    return swing * np.sin(2.0 * np.pi * np.arange(DURATION) / 5700.0)


@pytest.mark.parametrize(
    ("share", "swing"), [(0.0, 10.0), (0.02, 10.0), (0.045, 5.0), (0.045, 25.0)]
)
def test_large_swings_of_the_temperature_bias_nothing(share, swing):
    warm = orbits(swing)
    found = []
    for seed in range(8):
        samples, truth = turned(smooth_slews(), seed, fallen=np.exp(-share * warm))
        samples = replace(samples, temperature=20.0 + np.round(warm[:, None], 1))
        truth.viscous *= np.exp(-share * np.mean(warm))
        found.append(scores((samples, truth), SHEET, float(DURATION))[:, 0])
    assert np.sqrt(np.mean(np.square(found), axis=0)) == pytest.approx(0.0, abs=1.7)


def rows(share, random):
    """Rows without noise of a wheel whose viscous friction falls by a share with each kelvin."""
    warm = 12.0 * np.sin(np.arange(600) / 15.0)
    speed = 150.0 + 40.0 * random.standard_normal(600)
    torque, current_rate = 1e-4 * random.standard_normal((2, 600))
    columns = [torque, np.ones(600), speed, np.ones(600), current_rate, np.zeros(600), speed * warm]
    response = (torque + 9e-4 + 5e-6 * np.exp(-share * warm) * speed) / 0.027
    columns = np.column_stack(columns)
    return Rows(
        60.0 * np.arange(600),
        np.ones(600),
        response,
        columns,
        columns,
        np.zeros((600, 2)),
        0.0,
        36e3,
    )


@pytest.mark.parametrize("share", [-0.02, 0.0, 0.01, 0.045])
def test_the_columns_are_about_the_true_share(share, random):
    given = rows(share, random)
    prior = Prior(
        np.array([0.027, 9e-4, 5e-6, *[0.0] * 4]), np.array([1e12, 0, 1e11, 1e20, 1e5, 1e5, 1e13])
    )
    prior = replace(prior, precision=0.01 * prior.precision)
    found, about = about_its_share(given, prior, Noise(0.0, np.log(1200.0)))
    warm = given.regressors[:, WARMING] / given.regressors[:, VISCOUS]
    fallen = found.regressors[:, VISCOUS] / given.regressors[:, VISCOUS]
    np.testing.assert_allclose(fallen, np.exp(-share * warm), rtol=2e-2 if share else 0.0)
    # no change with temperature at all is as likely as before
    np.testing.assert_allclose(about.mean[WARMING], share * 5e-6, rtol=2e-2, atol=1e-12)


@pytest.fixture
def random():
    return np.random.default_rng(6)


def test_rows_without_temperature_stay_as_they_are(random):
    given = rows(0.0, random)
    for columns in (given.regressors[:, :WARMING], given.regressors * (np.arange(7) != WARMING)):
        other = replace(given, regressors=columns, instruments=columns)
        prior = Prior(np.ones(columns.shape[1]), np.ones(columns.shape[1]))
        assert about_its_share(other, prior, Noise(0.0, 7.0)) == (other, prior)
