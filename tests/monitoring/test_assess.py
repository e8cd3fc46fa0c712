"""Health of wheels from window tables."""

import json

import numpy as np
import pytest

from gyrostat.monitoring.change.assess import DAY, Limit, assess, episodes
from gyrostat.monitoring.windows import COLUMNS, Windows


def table(days, growth, seed=0):
    """Window table of two wheels; the Coulomb torque of the second grows from day 60."""
    random = np.random.default_rng(seed)
    rows = []
    for day in range(days):
        warm = 5.0 * np.sin(day / 9.0)
        for name, share in (("a", 0.0), ("b", growth)):
            coulomb = 1e-3 * (1.0 + share * max(day - 60.0, 0.0)) * (1.0 - 1e-3 * warm)
            rows.append(
                {
                    "wheel": name,
                    "start": DAY * day,
                    "end": DAY * (day + 1),
                    "coulomb": coulomb + 6e-6 * random.standard_normal(),
                    "coulomb_sigma": 6e-6,
                    "coulomb_observable": True,
                    "viscous": 5e-6 * np.exp(-0.02 * warm) + 5e-8 * random.standard_normal(),
                    "viscous_sigma": 5e-8,
                    "viscous_observable": True,
                    "motor_constant": 0.027 + 5e-5 * random.standard_normal(),
                    "motor_constant_sigma": 5e-5,
                    "offset": 6e-6 * random.standard_normal(),
                    "offset_sigma": 6e-6,
                    **{name: 0.0 for name in COLUMNS if name.startswith("cov_")},
                    "speed_mean": 150.0,
                    "temperature_mean": 20.0 + warm,
                    "valid": True,
                }
            )
    return Windows.of(rows)


@pytest.fixture(scope="module")
def healths():
    """Health after 120 days, with a limit at twice the Coulomb torque."""
    limits = {name: Limit(1e-3 * 2.0 + 5e-6 * 150.0, 150.0) for name in "ab"}
    return assess(table(120, 0.006), limits=limits)


def test_growing_wheel_has_an_alarm_and_the_other_none(healths):
    healthy, growing = healths
    assert not healthy.alarm
    assert healthy.alarms == ()
    assert growing.alarm
    assert 60 <= growing.alarms[0] <= 72
    assert growing.verdicts[-1].classes == ("Coulomb growth",)


def test_temperature_is_taken_out_of_the_trend(healths):
    # 10 % of viscous friction per 5 K are gone from the friction at 20 °C
    friction = healths[0].friction[30:]
    assert np.std(friction) < 1.5 * np.hypot(6e-6, 150.0 * 5e-8)


def test_forecast_names_the_day(healths):
    # grows by 0.6 % a day since day 60: twice the torque at 60 + 1/0.006 days
    forecast = healths[1].forecast
    expected = 60.0 + 1.0 / 0.006 - 119.0
    assert forecast.quantile(0.05) < expected < forecast.quantile(0.95)
    assert forecast.quantile(0.95) - forecast.quantile(0.05) < 80.0
    assert healths[0].as_json()["forecast"]["reached_within_a_year"] < 0.1


def test_health_is_json(healths):
    content = json.loads(json.dumps([health.as_json() for health in healths]))
    assert content[1]["alarm"] is True
    assert content[1]["onset"]["from"] <= content[1]["onset"]["start"] <= content[1]["onset"]["to"]
    assert sum(content[1]["probabilities"].values()) == pytest.approx(1.0)


def test_alarms_less_than_two_weeks_apart_are_one():
    start = DAY * np.arange(60.0)
    alarms = [k in (3, 10, 24, 25, 45) for k in range(60)]
    assert episodes(alarms, start) == (3, 45)
