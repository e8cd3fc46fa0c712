"""Change detection against dense Gaussian likelihoods, quadrature, the law of the run length."""

import numpy as np
import pytest
import scipy.stats

from gyrostat.monitoring.change.channels import CHANNELS, Observation, Reference, observation
from gyrostat.monitoring.change.detector import EXCESS, AlarmSettings, Detector, answer
from gyrostat.monitoring.change.evidence import KINDS, NAMES, SIGNATURES, evidence, log_marginal
from gyrostat.monitoring.change.kinds.change_kind import direction
from gyrostat.monitoring.change.levels import RAMP, Levels, LevelSettings
from gyrostat.monitoring.windows import REGRESSED, Windows

SIGMA = np.array([6e-3, 15e-3, 1.5e-3, 6e-3])
INFORMATION = np.diag(SIGMA**-2.0)
SCALE_SIGMA = 2.5e-3
EXTRA_SIGMA = np.array([SCALE_SIGMA, 0.2, 0.1, 1e-3])
HEALTHY = direction(coulomb=1.0, viscous=1.0, motor_constant=1.0, speed_scale=1.0)
REFERENCE = Reference(1e-3, 5e-6, 0.027)


def noisy(random):
    """Channels of a healthy wheel, (8,)."""
    noise = np.concatenate([SIGMA, EXTRA_SIGMA]) * random.standard_normal(len(CHANNELS))
    return HEALTHY + noise


def healthy(random, shift=0.0):
    """Observation of a healthy wheel, with a change added."""
    return observed(noisy(random) + shift, 3.0 * random.standard_normal())


def observed(values, temperature=0.0, information=INFORMATION):
    """Observation of the channels."""
    return Observation.of(
        information @ values[:4], information, values[4:], temperature, SCALE_SIGMA
    )


@pytest.mark.parametrize("count", [1, 2])
def test_marginal_likelihood_equals_quadrature(count):
    random = np.random.default_rng(count)
    root = 0.4 * random.standard_normal((count, count))
    information, score = root @ root.T, random.standard_normal(count)
    sizes = np.array([0.7, 1.3])[:count]
    nodes, weights = np.polynomial.hermite_e.hermegauss(60)
    grid = np.stack(np.meshgrid(*[nodes] * count, indexing="ij"), -1).reshape(-1, count) * sizes
    mass = np.prod(np.meshgrid(*[weights / weights.sum()] * count, indexing="ij"), axis=0).ravel()
    exponent = grid @ score - 0.5 * np.einsum("nj,jk,nk->n", grid, information, grid)
    assert log_marginal(information, score, sizes) == pytest.approx(
        np.log(mass @ np.exp(exponent)), rel=1e-9
    )
    means = np.array([0.4, -0.3])[:count]
    moved = grid + means
    exponent = moved @ score - 0.5 * np.einsum("nj,jk,nk->n", moved, information, moved)
    assert log_marginal(information, score, sizes, means) == pytest.approx(
        np.log(mass @ np.exp(exponent)), rel=1e-9
    )


def test_evidence_equals_the_dense_gaussian_likelihood():
    # levels as random walks with a prior, one fault: all windows at once in one covariance
    random = np.random.default_rng(3)
    settings = LevelSettings(walk=2e-3, memory=1e12, onsets=40)
    levels = Levels(SIGNATURES, settings)
    prior = levels.covariance.copy()
    values, temperature = [], []
    for _ in range(12):
        values.append([1.0, 1.0, 1.0, 0.0] + SIGMA * random.standard_normal(4))
        temperature.append(3.0 * random.standard_normal())
        levels.update(observed(np.append(values[-1], np.full(4, np.nan)), temperature[-1]))
    onset, size = 5, 0.1
    windows = np.arange(12)
    covariance = np.zeros((12, 4, 12, 4))
    for j in range(4):
        walk = settings.walk**2 * (np.minimum.outer(windows, windows) + 1.0)
        covariance[:, j, :, j] = prior[j, j] + walk + SIGMA[j] ** 2 * np.eye(12)
    for j in (0, 1):
        covariance[:, j, :, j] += prior[8 + j, 8 + j] * np.outer(temperature, temperature)
    flat = covariance.reshape(48, 48)
    course = np.where(windows >= onset, np.minimum((windows - onset + 0.5) / RAMP, 1.0), 0.0)
    fault = np.outer(course, [1.0, 0.0, 0.0, 0.0]).ravel()
    departure = (np.array(values) - [1.0, 1.0, 1.0, 0.0]).ravel()
    with_fault = scipy.stats.multivariate_normal(cov=flat + size**2 * np.outer(fault, fault))
    without = scipy.stats.multivariate_normal(cov=flat)
    expected = with_fault.logpdf(departure) - without.logpdf(departure)
    place = int(np.flatnonzero(np.all(SIGNATURES[:, :4] == np.eye(4)[0], axis=1))[0])
    found = log_marginal(
        levels.information[place : place + 1, place : place + 1, onset, 1],
        levels.score[place : place + 1, onset, 1],
        np.array([size]),
    )
    assert found == pytest.approx(expected, rel=1e-6)


def test_mean_time_to_a_false_alarm_is_above_the_threshold():
    # the bound of the Shiryaev-Roberts statistic; the excess over the threshold lengthens the run
    threshold = 20.0
    settings = AlarmSettings(false_alarms=365.25 / EXCESS / threshold)
    runs = []
    for seed in range(16):
        random = np.random.default_rng([seed, 9])
        detector = Detector(REFERENCE, settings, onsets=40)
        runs.append(next(n for n in range(1, 2000) if detector.take(healthy(random)).alarm))
    error = np.std(runs) / np.sqrt(len(runs))
    assert EXCESS * threshold - 2.0 * error < np.mean(runs) < 20.0 * threshold


@pytest.mark.parametrize("factor", [0.3, 4.0])
def test_wrong_nominal_value_is_no_change(factor):
    random = np.random.default_rng(11)
    detector = Detector(REFERENCE, onsets=40)
    for _ in range(30):
        shift = (factor - 1.0) * direction(coulomb=1.0, viscous=1.0)
        assert not detector.take(healthy(random, shift)).alarm


CASES = {
    "Coulomb growth": (direction(coulomb=0.15, breakaway=0.12), 1),
    "viscous growth": (direction(viscous=0.3), 1),
    "motor constant": (direction(motor_constant=-0.02, breakaway=0.02), 0),
    "offset": (direction(offset=0.1), 0),
    "torque bursts": (direction(burst=1.5, coulomb=0.02), 0),
    "stiction": (direction(breakaway=0.5), 0),
    "tachometer fault": (-0.03 * direction(coulomb=1.0, motor_constant=1.0, speed_scale=-1.0), 0),
    "seizure": (direction(coulomb=20.0, standstill=0.9), 0),
}


@pytest.mark.parametrize("name", CASES)
def test_class_of_a_change(name):
    change, course = CASES[name]
    random = np.random.default_rng(4)
    detector = Detector(REFERENCE, onsets=60)
    for day in range(40):
        share = np.clip((day - 24.5) / RAMP, 0.0, 1.0) if course else float(day >= 25)
        verdict = detector.take(healthy(random, share * change))
        assert day >= 25 or not verdict.alarm
    assert verdict.alarm
    assert verdict.classes == (name,)
    assert verdict.probabilities[name] > 0.9
    peak, low, high = verdict.onset
    assert low <= peak <= high
    assert abs(peak - 25) <= (6 if course else 1)
    assert set(verdict.probabilities) == {"none", *NAMES}
    assert sum(verdict.probabilities.values()) == pytest.approx(1.0)


def test_what_looks_alike_is_a_pair():
    # at one sign of the speed a window determines the sum of Coulomb and offset torque
    random = np.random.default_rng(6)
    both = np.array([1.0, 0.0, 0.0, 1.0])
    information = np.diag(SIGMA**-2.0) * np.diag([0.0, 1.0, 1.0, 0.0])
    information += np.outer(both, both) / SIGMA[0] ** 2
    detector = Detector(REFERENCE, onsets=60)
    for day in range(40):
        values = noisy(random) + direction(coulomb=0.06 * (day >= 25))
        values[CHANNELS.index("breakaway")] = np.nan  # the wheel never stops
        verdict = detector.take(observed(values, 0.0, information))
    assert verdict.alarm
    assert set(verdict.classes) == {"Coulomb growth", "offset"}


def test_a_window_that_hardly_shows_the_scale_of_the_speed_is_no_fault():
    # a day without slews among days with many: its error is large, and so is its stated sigma
    random = np.random.default_rng(12)
    detector = Detector(REFERENCE, onsets=40)
    for day in range(60):
        sigma = 4.0 * SCALE_SIGMA if day % 7 == 0 else SCALE_SIGMA
        shift = direction(speed_scale=3.0 * (sigma - SCALE_SIGMA))
        values = noisy(random) + shift
        seen = Observation.of(INFORMATION @ values[:4], INFORMATION, values[4:], 0.0, sigma)
        assert not detector.take(seen).alarm


def test_stored_detector_continues_alike():
    random = np.random.default_rng(7)
    observations = [healthy(random) for _ in range(30)]
    whole = Detector(REFERENCE, onsets=20)
    first = Detector(REFERENCE, onsets=20)
    verdicts = [whole.take(seen) for seen in observations]
    for seen in observations[:15]:
        first.take(seen)
    second = Detector(REFERENCE, onsets=20)
    second.restore(first.stored())
    for seen, expected in zip(observations[15:], verdicts[15:], strict=True):
        assert second.take(seen) == expected


@pytest.mark.parametrize("used", [1.0, 30.0])
def test_observation_of_a_row_leaves_out_what_was_known_beforehand(used):
    # an estimate that combines data and prior; the observation has the data's part
    random = np.random.default_rng(5)
    root = random.standard_normal((4, 4))
    scales = REFERENCE.scales()
    data = 1e4 * root @ root.T
    truth = np.array([1.1, 0.9, 1.02, 0.03])
    sigma = (0.3 * scales[1], 0.01 * scales[2], 0.02 * scales[3])
    reference = Reference(*scales[:3], 0.0, sigma)
    mean, precision = reference.prior()
    precision = precision / used**2  # a window may use less of it
    covariance = np.linalg.inv(data + np.diag(precision))
    values = covariance @ (data @ truth + precision * mean) * scales
    covariance *= np.outer(scales, scales)
    row = {
        "wheel": "a",
        "start": 0.0,
        "end": 86400.0,
        "noise_sigma": 0.0,
        "noise_time": 1200.0,
        "temperature_mean": 25.0,
        "valid": True,
    }
    for j, name in enumerate(REGRESSED):
        row |= {name: values[j], f"{name}_sigma": np.sqrt(covariance[j, j])}
        row |= {f"{name}_known": used * sigma[j - 1]} if j and used != 1.0 else {}
        row |= {f"cov_{name}_{REGRESSED[k]}": covariance[j, k] for k in range(j + 1, 4)}
    windows = Windows.of([row])
    seen = observation({name: v[0] for name, v in windows.columns.items()}, reference)
    assert not seen.extras
    there = seen.direction[:, :4]
    found = there.T @ np.diag(1.0 / seen.variance) @ there
    assert found == pytest.approx(data, rel=1e-6)
    assert seen.value == pytest.approx(there @ truth, rel=1e-6)
    assert seen.temperature == pytest.approx(5.0)


def test_rates_decide_between_classes_that_fit_alike():
    levels = Levels(SIGNATURES, LevelSettings(onsets=20))
    random = np.random.default_rng(8)
    for _ in range(10):
        levels.update(healthy(random))
    found = evidence(levels)
    rates = np.array([kind.rate for kind in KINDS]) / 365.25
    probabilities, rarer = found.probabilities(rates), found.probabilities(rates / 10.0)
    assert rarer[1:] / rarer[0] == pytest.approx(probabilities[1:] / probabilities[0] / 10.0)


@pytest.mark.parametrize(
    ("given", "count"),
    [([0.92, 0.05, 0.03], 1), ([0.6, 0.31, 0.09], 2), ([0.4, 0.3, 0.25], 3), ([0.3, 0.3, 0.2], 0)],
)
def test_the_answer_is_the_smallest_set_that_is_probable_enough(given, count):
    rest = (1.0 - sum(given)) / (len(NAMES) - 3)
    changed = np.array([*given, *[rest] * (len(NAMES) - 3)])
    # whatever the probability of no change
    assert answer(np.concatenate([[0.5], 0.5 * changed])) == NAMES[:count]
