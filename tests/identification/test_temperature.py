"""Friction over temperature."""

import dataclasses

import numpy as np
import pytest

from gyrostat.core.units import RPM
from gyrostat.identification import identify, temperature_trends
from gyrostat.simulation import CurrentRange, Telemetry, bench_record
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import ViscousCoulomb

INERTIA = 1.5e-3
OPTIONS = {"inertia": INERTIA, "model": "viscous-coulomb"}


def at(temperature, viscous, seed=0):
    """A record at one temperature."""
    wheel = Wheel(
        inertia=INERTIA,
        motor_constant=0.0228,
        friction=ViscousCoulomb(viscous=viscous, coulomb=0.8795e-3),
    )
    whole = bench_record(
        wheel,
        "steps",
        duration=200.0,
        telemetry=Telemetry(speed_sigma=1.0 * RPM),
        amplitudes=CurrentRange(0.06, 0.15),
        seed=seed,
        name=f"at {temperature}",
    )
    return dataclasses.replace(whole, temperature=np.full(len(whole.time), temperature))


def trend_of(name, trends):
    return next(t for t in trends if t.name == name)


def test_a_change_with_temperature_is_found():
    records = [at(t, 10e-6 - 0.1e-6 * t, seed) for seed, t in enumerate((10.0, 25.0, 40.0))]
    viscous = trend_of("viscous", temperature_trends(records, **OPTIONS))
    assert abs(viscous.slope + 0.1e-6) < 4.0 * viscous.slope_sigma
    assert viscous.slope_sigma < 0.02e-6
    assert viscous.temperature.tolist() == [10.0, 25.0, 40.0]


def test_scatter_beyond_the_sigmas_makes_a_slope_uncertain():
    """Values off a straight line by many sigmas: the slope knows the residual of the line."""
    offsets = (0.0, 3e-6, -3e-6, 0.0)
    records = [at(10.0 * (k + 1), 10e-6 + o, k) for k, o in enumerate(offsets)]
    viscous = trend_of("viscous", temperature_trends(records, **OPTIONS))
    line, covariance = np.polyfit(
        viscous.temperature, viscous.value, 1, w=1.0 / viscous.sigma, cov=True
    )
    assert viscous.slope == pytest.approx(line[0], rel=1e-6)
    assert viscous.slope_sigma == pytest.approx(np.sqrt(covariance[0, 0]), rel=1e-6)


def test_requests_for_all_records_are_read_for_each():
    records = [at(20.0, 5e-6, 1), at(30.0, 5e-6, 2)]
    trends = temperature_trends(
        records,
        hold={"initial_speed_1": 0.0},
        start={"initial_speed_2": 0.1},
        speed_sigma=[1.0 * RPM, 1.0 * RPM],
        **OPTIONS,
    )
    first = identify(records[0], hold={"initial_speed": 0.0}, speed_sigma=1.0 * RPM, **OPTIONS)
    assert trend_of("viscous", trends).value[0] == pytest.approx(first.parameters["viscous"])


def test_a_record_that_cannot_be_fitted_alone_is_left_out_and_said():
    records = [at(20.0, 5e-6, 1), at(30.0, 5e-6, 2), at(40.0, 5e-6, 3)]
    constant = np.full(len(records[2].time), 0.1)
    records[2] = dataclasses.replace(records[2], current=constant)
    said = []
    trends = temperature_trends(records, on_left_out=said.append, **OPTIONS)
    assert len(said) == 1
    assert "at 40.0" in said[0]
    assert trend_of("viscous", trends).temperature.tolist() == [20.0, 30.0]


def test_a_record_that_does_not_converge_alone_is_left_out():
    records = [at(20.0, 5e-6, 1), at(30.0, 5e-6, 2)]
    said = []
    assert temperature_trends(records, on_left_out=said.append, max_iterations=1, **OPTIONS) == []
    assert [s for s in said if "did not converge" in s] == said
    assert len(said) == 2


def test_records_at_several_temperatures_share_one_model():
    """Viscous friction and its change per degree from one fit, at the mean temperature."""
    records = [at(t, 10e-6 - 0.1e-6 * t, seed) for seed, t in enumerate((10.0, 25.0, 40.0))]
    fit = identify(records, **OPTIONS)
    for name, true in (("viscous", 7.5e-6), ("viscous_per_degC", -0.1e-6), ("dry_per_degC", 0.0)):
        place = fit.names.index(name)
        assert abs(fit.values[place] - true) < 4.0 * fit.sigma[place]
    assert fit.sigma[fit.names.index("viscous_per_degC")] < 0.02e-6
    assert fit.to_dict()["parameters"]["viscous_per_degC"]["unit"] == "N·m·s/rad/°C"
    model = fit.wheel_model()
    assert model is not None
    assert set(model.values) == {"motor_constant", "inertia", "viscous", "coulomb"}
    assert model.origin["temperature"] == "25 °C"
