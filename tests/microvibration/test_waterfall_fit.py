"""Fit of waterfalls that equations of motion in time and `scipy.signal.welch` have made."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gyrostat.microvibration.estimates import Estimate
from gyrostat.microvibration.fit import fit_waterfall
from gyrostat.microvibration.model import Mode
from gyrostat.microvibration.simulate import simulated_waterfall
from gyrostat.microvibration.waterfall import Waterfall, Window

PATH = Path(__file__).parents[2] / "benchmarks" / "waterfall_coverage.py"
SPECIFICATION = importlib.util.spec_from_file_location("waterfall_coverage", PATH)
coverage = importlib.util.module_from_spec(SPECIFICATION)
SPECIFICATION.loader.exec_module(coverage)


@pytest.fixture(scope="module")
def waterfall():
    return simulated_waterfall(
        coverage.WHEEL, coverage.SPEED, np.random.default_rng(5), floor=coverage.FLOOR
    )


@pytest.fixture(scope="module")
def fit(waterfall):
    return fit_waterfall(waterfall)


def test_harmonics_modes_and_noise_are_found_within_their_sigmas(fit):
    assert fit.valid
    assert len(fit.harmonics) == len(coverage.WHEEL.harmonics)
    scores = {
        name: (estimate.value - truth) / estimate.sigma
        for name, estimate, truth in coverage.intervals(fit)
    }
    # 37 scores: one beyond 4 by chance once in 400 waterfalls
    assert max(map(abs, scores.values())) < 4.0
    assert 0.6 < np.std(list(scores.values())) < 1.5


def test_estimates_are_sharp(fit):
    assert fit.kinds["torque"].mode["inertia_ratio"].sigma < 0.002
    assert fit.kinds["force"].mode["damping"].sigma < 0.05 * 0.02
    first = fit.harmonics[1]
    assert first.number.sigma < 1e-4
    assert first.coefficients["force"].total.sigma < 0.01 * 1e-6


def test_sense_of_whirl_is_found_where_the_gyroscopic_mode_splits(fit):
    second = fit.harmonics[2].coefficients["torque"]
    assert second.backward.observable
    assert not second.forward.observable


def test_loads_of_a_pair_have_the_coefficient_of_the_pair(fit):
    loads = fit.harmonics[1].coefficients["force"].loads
    for load in ("Fx", "Fy"):
        assert loads[load].low <= 1e-6 <= loads[load].high


def test_what_is_left_out_of_the_disturbance_is_told(fit):
    unknown = Estimate(0.0, 1.0, 0.0, 1.0, "kg·m²")
    first = fit.harmonics[0]
    total = Estimate.normal(1e-9, 1e-10, "kg·m²")
    coefficient = replace(
        next(iter(first.coefficients.values())),
        total=total,
        forward=unknown,
        backward=unknown,
        splits=True,
    )
    lost = replace(first, coefficients={"torque": coefficient})
    weak = replace(first, coefficients={"torque": replace(coefficient, total=unknown)})
    for harmonic, text in ((lost, "kg·m², sense not determined: left"), (weak, "no coefficient")):
        result = replace(fit, harmonics=(harmonic,))
        assert not result.disturbance().harmonics
        assert any(text in line for line in result.lines())


def test_too_few_speeds_and_a_coarse_resolution_are_not_valid(waterfall):
    few = {load: values[:5] for load, values in waterfall.density.items()}
    result = fit_waterfall(replace(waterfall, speed=waterfall.speed[:5], density=few))
    assert not result.valid
    assert "too few speeds" in result.reasons[0]
    coarse = {load: values[:, ::16] for load, values in waterfall.density.items()}
    result = fit_waterfall(replace(waterfall, frequency=waterfall.frequency[::16], density=coarse))
    assert "too coarse" in result.reasons[0]


def test_noise_alone_has_no_harmonic():
    generator = np.random.default_rng(3)
    frequency = np.arange(1.0, 300.0, 0.5)
    density = {"Fz": generator.gamma(8.0, 1.0, (20, len(frequency)))}
    speed = np.linspace(50.0, 300.0, 20)
    result = fit_waterfall(Waterfall("noise", speed, frequency, density, Window.named("hann")))
    assert result.harmonics == ()
    assert "no harmonic" in result.reasons[0]


def test_a_line_that_does_not_move_is_no_harmonic(waterfall):
    bin_of_line = int(np.argmin(np.abs(waterfall.frequency - 50.0)))
    # two loads that show all harmonics together
    density = {load: waterfall.density[load].copy() for load in ("Fx", "Fz")}
    for values in density.values():
        values[:, bin_of_line - 1 : bin_of_line + 2] += 100.0 * np.median(values)
    result = fit_waterfall(replace(waterfall, density=density))
    numbers = [harmonic.number.value for harmonic in result.harmonics]
    # where a line crosses it, its power is not that of the harmonic
    truth = [harmonic.number for harmonic in coverage.WHEEL.harmonics]
    np.testing.assert_allclose(numbers, truth, atol=5e-4)
    assert len(result.warnings) == 2
    assert all("do not move" in text for text in result.warnings)


def test_the_narrow_peak_of_a_mode_is_no_line_that_does_not_move():
    """Lines that cross the peak carry its damping: without them, its sigma is 4 times as large."""
    axial = Mode(220.0 * coverage.HZ, 0.005)
    axial_harmonics = [each for each in coverage.WHEEL.harmonics if "axial" in each.forward]
    wheel = replace(
        coverage.WHEEL,
        harmonics=tuple(axial_harmonics),
        modes={**coverage.WHEEL.modes, "axial": axial},
    )
    rng = np.random.default_rng(7)
    made = simulated_waterfall(wheel, coverage.SPEED, rng, floor=coverage.FLOOR)
    result = fit_waterfall(replace(made, density={"Fz": made.density["Fz"]}))
    damping = result.kinds["axial"].mode["damping"]
    assert damping.sigma < 0.05 * 0.005
    assert abs(damping.value - 0.005) < 3.0 * damping.sigma
    assert result.warnings == ()


def test_kernel_of_the_window_is_what_welch_does_to_a_tone():
    window = Window.named("hann")
    shown = window.kernel[window.kernel > 1e-6]
    np.testing.assert_allclose(shown, [1 / 6, 2 / 3, 1 / 6], rtol=1e-6)
    assert window.noise_bandwidth == pytest.approx(1.5)
    assert window.half_width == 2
