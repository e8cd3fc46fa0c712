"""Pointing indices against their definitions, closed forms and spectra."""

from math import asin, pi, sqrt

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.special import erf, erfinv

from gyrostat.campaigns.pointing.collected import Collected, counted_sizes
from gyrostat.campaigns.pointing.indices import WindowIndex
from gyrostat.campaigns.pointing.spectrum import size_from_spectrum, window_gain
from gyrostat.core.errors import InputError
from gyrostat.scenario.requirement import INDICES, Requirement

PERIOD = 0.05
Z = (0.0, 0.0, 1.0)


def asked(index, **keys):
    """Requirement with a window of 2 s, and a stability time of 5 s for PDE."""
    keys = {"value": 1e-3, "level": 0.95, "interpretation": "ensemble", "axis": "x"} | keys
    operation = INDICES[index][1]
    times = {} if operation == "absolute" else {"window": 2.0}
    times |= {"stability": 5.0} if operation == "drift" else {}
    return Requirement("r", index, **(times | keys))


def collected(requirement, vectors, inside=None, *, parts=4, period=PERIOD):
    """Values of runs, (runs, samples, 3), that arrive in parts of unequal length."""
    runs, samples = vectors.shape[:2]
    masks = [np.ones((runs, samples), bool)] if inside is None else inside
    made = Collected(requirement, runs, period, samples, group=runs, masks=len(masks))
    cuts = np.sort(np.random.default_rng(parts).integers(0, samples, parts - 1))
    for rows in np.split(np.arange(samples), cuts):
        made.add(vectors[:, rows], [mask[:, rows] for mask in masks])
    made.finish()
    return made


def metric(index, vectors, inside=None, parts=4, **keys):
    return collected(asked(index, **keys), vectors, inside, parts=parts).metric()


def along_x(*series):
    """Vectors of runs whose error is about x."""
    values = np.zeros((len(series), len(series[0]), 3))
    values[..., 0] = series
    return values


def trapezoid_mean(series):
    return np.trapezoid(series, axis=0) / (len(series) - 1)


@pytest.mark.parametrize("axis", ["x", "full", "half_cone", "about"])
@pytest.mark.parametrize("parts", [1, 2, 7, 60])
def test_indices_are_their_definitions_for_any_division_into_parts(axis, parts):
    """One run, evaluated in two separate intervals, sample by sample from the whole series."""
    random = np.random.default_rng(1)
    whole = random.normal(size=(300, 3)).cumsum(axis=0) * 1e-4
    inside = np.zeros(300, bool)
    inside[31:120], inside[140:277] = True, True
    seen = {
        "x": whole[:, :1],
        "full": whole,
        "half_cone": whole[:, :2],
        "about": whole[:, 2:],
    }[axis]
    n, s, sets = 12, 30, ((31, 120), (140, 277))
    norm = np.linalg.norm
    mean = {k: trapezoid_mean(seen[k - n : k + 1]) for a, b in sets for k in range(a + n, b)}
    expected = {
        ("APE", "any"): [norm(seen[k]) for a, b in sets for k in range(a, b)],
        ("MPE", "any"): [norm(each) for each in mean.values()],
        ("RPE", "end"): [norm(seen[k] - each) for k, each in mean.items()],
        ("RPE", "centre"): [norm(seen[k - n // 2] - each) for k, each in mean.items()],
        ("RPE", "any"): [
            norm(seen[k] - mean[e])
            for a, b in sets
            for e in range(a + n, b, n)
            for k in range(e - n + (e > a + n), e + 1)
        ],
        ("PDE", "any"): [norm(mean[k] - mean[k - s]) for a, b in sets for k in range(a + n + s, b)],
        ("PRE", "any"): [norm(mean[140 + n] - mean[31 + n])],
    }
    for (index, instant), values in expected.items():
        for interpretation, level in (("ensemble", 0.5), ("temporal", 0.9), ("mixed", 0.5)):
            if index == "PRE" and interpretation == "temporal":
                continue
            value = float(np.quantile(values, 0.7, method="inverted_cdf")) * (1 + 1e-9)
            found = metric(
                index,
                whole[None],
                [inside[None]],
                parts,
                window=n * PERIOD if index != "APE" else 0.0,
                stability=s * PERIOD if index == "PDE" else 0.0,
                instant=instant,
                axis=axis,
                boresight=Z if axis in ("half_cone", "about") else None,
                interpretation=interpretation,
                level=level,
                value=value,
            )[0]
            wanted = {
                "ensemble": max(values),
                "temporal": np.quantile(values, 0.9, method="inverted_cdf"),
                "mixed": np.mean(np.array(values) > value),
            }[interpretation]
            assert found == pytest.approx(wanted, rel=1e-9, abs=1e-15), (index, instant)


def test_a_constant_error_has_no_relative_error_and_no_drift():
    constant = along_x(np.full(400, 7e-4))
    assert metric("APE", constant) == pytest.approx(7e-4)
    assert metric("MPE", constant) == pytest.approx(7e-4)
    for index in ("RPE", "PDE"):
        assert metric(index, constant) < 1e-16
    assert metric("PRE", constant, [np.arange(400)[None] < 100, np.arange(400)[None] > 200]) < 1e-16


def test_a_drift():
    """Error D t: a mean lags by half a window; PDE is the drift in the stability time."""
    drift, time = 1e-5, PERIOD * np.arange(800)
    vectors = along_x(drift * time)
    assert metric("MPE", vectors)[0] == pytest.approx(drift * (time[-1] - 1.0))
    assert metric("RPE", vectors, instant="end")[0] == pytest.approx(drift * 1.0)
    assert metric("RPE", vectors, instant="any")[0] == pytest.approx(drift * 1.0)
    assert metric("RPE", vectors, instant="centre")[0] < 1e-15
    assert metric("PDE", vectors)[0] == pytest.approx(drift * 5.0)
    periods = [(time >= start)[None] & (time < start + 10.0)[None] for start in (0.0, 25.0)]
    assert metric("PRE", vectors, periods)[0] == pytest.approx(drift * 25.0)
    # uniform between -D T / 2 and D T / 2 in the window
    found = metric("RPE", vectors, interpretation="temporal", level=0.6)
    assert found == pytest.approx(0.6 * drift, rel=0.03)


@pytest.mark.parametrize("frequency", [0.07, 0.31, 0.9])
def test_a_sinusoid_has_the_gain_of_the_window_in_time_and_frequency(frequency):
    """Amplitude of each index, from its largest value, against the transfer function: 1 %."""
    time = 0.01 * np.arange(40_000)
    vectors = along_x(np.sin(2.0 * pi * frequency * time))
    for index, instant in (("MPE", "any"), ("RPE", "end"), ("RPE", "centre"), ("PDE", "any")):
        requirement = asked(index, instant=instant)
        found = collected(requirement, vectors, period=0.01).metric()[0]
        gain = sqrt(window_gain(requirement, np.array([frequency]))[0])
        assert found == pytest.approx(gain, rel=0.01), (index, instant)
    # temporal level of a sinusoid: arcsine distribution
    found = metric("APE", vectors, interpretation="temporal", level=0.9)[0]
    assert 2.0 / pi * asin(found) == pytest.approx(0.9, abs=2e-3)


@pytest.fixture(scope="module")
def coloured():
    """Gauss-Markov errors of unit variance with the corner frequency 0.4 Hz, sampled at 50 Hz."""
    decay = np.exp(-2.0 * pi * 0.4 * 0.02)
    shocks = np.random.default_rng(5).normal(size=(128, 10_000))
    shocks[:, 1:] *= sqrt(1.0 - decay**2)
    return along_x(*lfilter([1.0], [1.0, -decay], shocks))


INDEX_INSTANTS = [("APE", "any"), ("MPE", "any"), ("PDE", "any")]
INDEX_INSTANTS += [("RPE", instant) for instant in ("any", "end", "centre")]


@pytest.mark.parametrize(("index", "instant"), INDEX_INSTANTS)
def test_time_and_frequency_domain_agree_for_a_gauss_markov_error(coloured, index, instant):
    """Mixed size of simulated runs against that of the spectrum, 1 %."""
    requirement = asked(index, instant=instant, interpretation="mixed", value=1.0, level=0.9)
    counts = collected(requirement, coloured, period=0.02).counts().sum(axis=0)
    found = np.interp(0.9, counts[:-1] / counts[-1], counted_sizes(1.0))
    frequency = np.concatenate([np.linspace(0.0, 5.0, 20_001), np.geomspace(5.001, 2e4, 20_000)])
    density = 2.0 / (pi * 0.4) / (1.0 + (frequency / 0.4) ** 2)
    # the spectrum that sampling folds is small: the corner is at 1/60 of half the sample rate
    assert found == pytest.approx(size_from_spectrum(requirement, frequency, density), rel=0.01)


def response(index, instant, signal):
    """Sizes of an index of a signal that is not 0 before the end of the series."""
    made = WindowIndex(asked(index, instant=instant, axis="x"), len(signal), 100, 250)
    parts = made.add(along_x(*signal), np.ones(signal.shape, bool)), made.finish()
    sizes = np.concatenate([part.sizes for part in parts], axis=1)
    return np.where(sizes < np.inf, sizes, 0.0)


def test_white_noise_and_random_walk_in_closed_form():
    """Variance by the sum of squared responses to an impulse (noise) or a step (walk).

    A window has n samples. The mean of a continuous random walk differs by terms of 1 / n.
    """
    n, samples = 100, 1200
    place = np.arange(600, 600 + n)
    impulse = np.zeros((n, samples))
    impulse[np.arange(n), place] = 1.0
    mean = (n - 0.5) / n**2
    expected = {
        ("APE", "any"): (1.0, None),
        ("MPE", "any"): (mean, None),
        ("RPE", "end"): (1.0 - 1.0 / n + mean, n / 3.0),
        ("RPE", "centre"): (1.0 - 2.0 / n + mean, n / 12.0),
        ("RPE", "any"): (1.0 - mean, n / 6.0),
        ("PDE", "any"): (2.0 * mean, 2.5 * n - n / 3.0),
    }
    for (index, instant), (noise, walk) in expected.items():
        for signal, variance in ((impulse, noise), (impulse.cumsum(axis=1), walk)):
            if variance is not None:
                # the index is the same in every window: squares over all shocks in one of them
                squares = np.sum(response(index, instant, signal)[:, 350:1100] ** 2)
                assert squares / n == pytest.approx(variance, rel=0.01), (index, instant)


def test_a_level_of_a_relative_error_at_any_time_of_its_window():
    """Random walk: normal at each place s of the window, with the variance n (1/3 - s + s²)."""
    frequency = np.geomspace(1e-5, 1e3, 200_001)
    density = 2.0 / (2.0 * pi * frequency) ** 2  # a walk of 1 rad²/s, one-sided
    found = size_from_spectrum(asked("RPE", level=0.9), frequency, density)
    places = (np.arange(2000) + 0.5) / 2000
    sigmas = np.sqrt(2.0 * (1.0 / 3.0 - places + places**2))
    assert np.mean(erf(found / sigmas / sqrt(2.0))) == pytest.approx(0.9, abs=5e-4)


def test_a_half_cone_of_two_equal_axes_is_a_rayleigh_distribution():
    frequency, flat = np.linspace(0.0, 1.0, 1001), np.full(1001, 4e-8)
    half_cone = asked("APE", axis="half_cone", boresight=Z, level=0.997)
    sigma = sqrt(4e-8)
    found = size_from_spectrum(half_cone, frequency, np.array([flat, flat]))
    assert found == pytest.approx(sigma * sqrt(-2.0 * np.log(0.003)), rel=1e-9)
    # one axis alone: a normal distribution
    found = size_from_spectrum(half_cone, frequency, np.array([flat, 0.0 * flat]))
    assert found == pytest.approx(sigma * sqrt(2.0) * erfinv(0.997), rel=1e-9)
    # unequal axes against random numbers
    random = np.random.default_rng(0).normal(size=(2, 2_000_000)) * [[1.0], [0.4]]
    wanted = sigma * np.quantile(np.hypot(*random), 0.95)
    half_cone = asked("APE", axis="half_cone", boresight=Z, level=0.95)
    found = size_from_spectrum(half_cone, frequency, np.array([flat, 0.16 * flat]))
    assert found == pytest.approx(wanted, rel=2e-3)


@pytest.mark.parametrize(
    ("axis", "frequency", "density"),
    [
        ("x", [0.0, 1.0], [[1.0, 1.0], [1.0, 1.0]]),
        ("half_cone", [0.0, 1.0], [1.0, 1.0]),
        ("full", [0.0, 1.0], [1.0, 1.0]),
        ("x", [1.0, 0.0], [1.0, 1.0]),
        ("x", [0.0, 1.0], [1.0, -1.0]),
        ("x", [0.0, 1.0], [1.0, np.nan]),
    ],
)
def test_other_spectra_are_refused(axis, frequency, density):
    boresight = Z if axis == "half_cone" else None
    with pytest.raises(InputError, match="spectrum of r: found"):
        size_from_spectrum(
            asked("APE", axis=axis, boresight=boresight), np.array(frequency), np.array(density)
        )


def test_a_missing_measurement_interrupts_the_windows_and_nothing_else():
    """Knowledge error 1 with one sample of NaN: windows before and after it have the mean 1."""
    vectors = along_x(np.ones(200))
    vectors[0, 90] = np.nan
    for index in ("AKE", "MKE"):
        assert metric(index, vectors)[0] == pytest.approx(1.0)
    found = collected(asked("MKE", interpretation="mixed", value=1.0), vectors)
    # the sample is in 41 of the 160 windows
    assert found.counts()[0, -1] == 160 - 41


def test_a_run_without_values_has_none():
    vectors, inside = along_x(np.ones(100), np.ones(100)), np.zeros((2, 100), bool)
    inside[1, 10:30] = True  # shorter than a window of 40 samples
    for interpretation in ("ensemble", "temporal", "mixed"):
        assert np.isnan(metric("MPE", vectors, [inside], interpretation=interpretation)).all()
    assert np.isnan(metric("PRE", vectors, [inside, inside], interpretation="mixed")).all()
