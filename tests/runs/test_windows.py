"""Metrics of a window against NumPy and SciPy on the full history, and on analytic signals."""

from functools import cache
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest
from scipy.signal import butter, sosfilt, sosfilt_zi
from scipy.spatial.transform import Rotation

from gyrostat.control.guidance import AttitudeReference, Mode
from gyrostat.core.jax64 import jax, jnp
from gyrostat.runs.metrics.windows import WindowObserver, concluded, pointing_error
from gyrostat.scenario.metrics.results import kinds_of_window, window_metrics
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.metrics.window_metric import WindowStart
from gyrostat.scenario.scenario import Event, Part, Window

PERIOD = 0.1
SETTLED = {"metrics.settled_angle": 0.02, "metrics.settled_rate": 0.01}
WHEELS = ("a", "b")
Z = (0.0, 0.0, 1.0)


class State(NamedTuple):
    """State of a plant, as far as metrics use it."""

    attitude: object
    wheel_speed: object


class Signals(NamedTuple):
    """Command or record."""

    flow: object


def quaternions(vectors):
    """Attitudes of rotation vectors, (n, 3), scalar first."""
    return np.roll(Rotation.from_rotvec(vectors).as_quat(), 1, axis=1)


@cache
def program(window, slews):
    """Compiled function: (values, history) -> running values of a window, its errors."""
    structure = SimpleNamespace(
        wheels=WHEELS,
        boresight=None,
        events=[Event(name, "slew") for name in slews],
        parts=[Part("reference.mode", name, "nadir") for name in ("first", "second")],
    )
    target = jnp.array([1.0, 0.0, 0.0, 0.0])
    reference = AttitudeReference(target, jnp.zeros(3), jnp.zeros(3))

    def run(values, rows):
        observer = WindowObserver.of(window, structure, values)

        def step(seen, row):
            k, attitude, rate, speed, flow, *mode = row
            error = pointing_error(attitude, target, None)
            state, signals = State(attitude, speed), Signals(flow)
            about = (k * PERIOD, error, rate, reference, Mode(*mode), {})
            sample = Sample(*about, state, (), signals, signals)
            return observer(seen, sample, k)

        return jax.lax.scan(step, observer.start(), rows)

    return jax.jit(run)


def observed(window, numbers, vectors, *, rate=None, speed=None, flow=None, slews=(), mode=None):
    """Metrics of a window over a history of error vectors, and the errors in the window."""
    count = len(vectors)
    rate = np.zeros((count, 3)) if rate is None else rate
    speed = np.zeros((count, 2)) if speed is None else speed
    flow = np.zeros((count, 1)) if flow is None else flow
    values = {"window.w.from": 0.0, "window.w.until": np.inf, "run.control_period": PERIOD}
    values |= SETTLED | {f"event.{name}.time": time for name, time in dict(slews).items()}
    values |= {f"window.w.{key}": value for key, value in numbers.items()}
    mode = (np.zeros(count, int), np.zeros(count)) if mode is None else mode
    rows = (jnp.arange(count), quaternions(vectors), rate, speed, flow, *mode)
    run = program(window, tuple(dict(slews)))
    seen, errors = run({key: jnp.asarray(value) for key, value in values.items()}, rows)
    start = WindowStart(window, WHEELS, window.boresight, numbers)
    found = concluded(kinds_of_window(start), jax.tree.map(np.asarray, seen))
    assert set(found) == set(window_metrics(start))
    return {name: float(value) for name, value in found.items()}, np.asarray(errors)


def wandering(count, size=0.03, seed=0):
    """Error vectors of an attitude that wanders."""
    random = np.random.default_rng(seed)
    return size * np.cumsum(random.normal(size=(count, 3)), axis=0) / np.sqrt(count)


def largest_turn(lines, periods, first, last):
    """Largest angle between two directions within an exposure, by trying all pairs."""
    found = -np.inf
    for start in range(first, last - periods + 1):
        chords = np.linalg.norm(lines[start : start + periods + 1] - lines[start], axis=1)
        found = max(found, 2.0 * np.arcsin(0.5 * chords.max()))
    return found


def test_every_metric_is_that_of_the_history():
    """With exposures that start at every sample, and a window in the middle of the run."""
    count, first, last = 400, 120, 333
    random = np.random.default_rng(3)
    vectors, rate = wandering(count), 0.02 * random.normal(size=(count, 3))
    vectors[300:], rate[300:] = 0.001 * vectors[300:], 0.1 * rate[300:]
    speed, flow = random.normal(size=(count, 2)), random.normal(size=(count, 4))
    numbers = {"from": 12.0, "until": 33.3, "exposure": 1.2, "dwell_above": 0.3, "dwell_below": 0.9}
    numbers |= {"jitter_above": 0.5, "jitter_below": 2.0}
    window = Window("w", boresight=(0.6, 0.0, 0.8), propellant="flow")
    found, errors = observed(window, numbers, vectors, rate=rate, speed=speed, flow=flow)
    inside = slice(first, last + 1)
    turns = Rotation.from_rotvec(vectors)
    lines = turns.apply([0.6, 0.0, 0.8])
    angle = np.arctan2(
        np.linalg.norm(np.cross(lines, [0.6, 0.0, 0.8]), axis=1), lines @ [0.6, 0.0, 0.8]
    )
    x, _, z, w = turns.as_quat(canonical=True).T
    about = np.abs(2.0 * np.arctan2(0.6 * x + 0.8 * z, w))[inside]
    size = np.linalg.norm(rate, axis=1)
    out = np.flatnonzero((angle >= 0.02) | (size >= 0.01))
    within = (np.abs(speed) >= 0.3) & (np.abs(speed) <= 0.9)
    sections = [
        butter(4, f, kind, fs=1 / PERIOD, output="sos") for f, kind in ((0.5, "high"), (2, "low"))
    ]
    passed = lines
    for part in sections:
        start = sosfilt_zi(part)[:, :, None] * passed[0]
        passed, _ = sosfilt(part, passed, axis=0, zi=start)
    expected = {
        "error_max": angle[inside].max(),
        "error_rms": np.sqrt(np.mean(angle[inside] ** 2)),
        "error_end": angle[last],
        "rotation_max": about.max(),
        "rotation_rms": np.sqrt(np.mean(about**2)),
        "rate_error_max": size[inside].max(),
        "rate_error_rms": np.sqrt(np.mean(size[inside] ** 2)),
        "settling": PERIOD * (out[out <= last].max() + 1) - 12.0,
        "smear": largest_turn(lines, 12, first, last),
        "jitter": np.sqrt(np.mean(np.sum(passed[inside] ** 2, axis=1))),
        "dwell": np.mean(within[inside].any(axis=1)),
        "dwell.a": np.mean(within[inside, 0]),
        "dwell.b": np.mean(within[inside, 1]),
        "propellant": PERIOD * flow[inside].sum(),
    }
    assert 0.0 < expected["settling"] < 21.0
    for name, value in expected.items():
        np.testing.assert_allclose(found[name], value, rtol=1e-10, atol=1e-15, err_msg=name)
    np.testing.assert_allclose(errors[inside], angle[inside], rtol=1e-12, atol=1e-15)
    assert np.all(np.isinf(np.delete(errors, np.arange(first, last + 1))))


def test_the_error_of_the_full_attitude_needs_no_boresight():
    vectors = wandering(50)
    found, _ = observed(Window("w"), {"jitter_above": 0.5}, vectors)
    np.testing.assert_allclose(
        found["error_max"], np.linalg.norm(vectors, axis=1).max(), rtol=1e-12
    )
    part = butter(4, 0.5, "high", fs=1 / PERIOD, output="sos")
    passed, _ = sosfilt(part, vectors, axis=0, zi=sosfilt_zi(part)[:, :, None] * vectors[0])
    rms = np.sqrt(np.mean(np.sum(passed**2, axis=1)))
    np.testing.assert_allclose(found["jitter"], rms, rtol=1e-9)


def test_a_constant_error_has_neither_jitter_nor_smear():
    vectors = np.tile([0.01, -0.02, 0.03], (200, 1))
    numbers = {"jitter_above": 0.01, "jitter_below": 1.0, "exposure": 2.0}
    found, _ = observed(Window("w", boresight=Z), numbers, vectors)
    assert found["smear"] == 0.0
    assert found["jitter"] < 1e-12
    np.testing.assert_allclose(found["error_rms"], found["error_max"], rtol=1e-12)


@pytest.mark.parametrize("exposure", [0.1, 0.8, 1.6, 1.7, 5.0, 9.9])
def test_the_smear_of_a_drift_is_rate_times_exposure(exposure):
    """Also where exposures do not start at every sample."""
    vectors = np.outer(np.arange(200) * PERIOD * 0.003, [1.0, 0.0, 0.0])
    found, _ = observed(Window("w", boresight=Z), {"exposure": exposure}, vectors)
    np.testing.assert_allclose(found["smear"], 0.003 * exposure, rtol=1e-9)
    assert found["rotation_max"] < 1e-12


@pytest.mark.parametrize("ratio", [0.5, 0.7, 2.0])
def test_exposures_miss_little_of_a_sine(ratio):
    """The largest turn of a sine within an exposure of half a period or more."""
    exposure, spacing = 20.0, 1.3
    phase = 2.0 * np.pi * ratio / exposure * PERIOD * np.arange(3000)
    vectors = np.outer(0.01 * np.sin(phase + 0.3), [0.0, 1.0, 0.0])
    found, _ = observed(Window("w", boresight=Z), {"exposure": exposure}, vectors)
    share = 0.5 * (1.0 + np.cos(np.pi * spacing * ratio / exposure))
    assert 0.02 * share * (1.0 - 1e-4) < found["smear"] <= 0.02 * (1.0 + 1e-9)


@pytest.mark.parametrize("frequency", [0.25, 0.5, 1.0, 2.0, 4.0])
def test_jitter_of_a_sine_is_that_of_a_butterworth_filter(frequency):
    """Half and twice the cut-off frequencies, and within the band."""
    time = PERIOD * np.arange(4000)
    vectors = np.outer(1e-6 * np.sin(2 * np.pi * frequency * time + 0.7), [1.0, 0.0, 0.0])
    numbers = {"from": 40.0, "until": 399.9, "jitter_above": 0.5, "jitter_below": 2.0}
    found, _ = observed(Window("w", boresight=Z), numbers, vectors)
    warped, low, high = np.tan(np.pi * PERIOD * np.array([frequency, 0.5, 2.0]))
    gain = 1.0 / np.sqrt((1.0 + (low / warped) ** 8) * (1.0 + (warped / high) ** 8))
    np.testing.assert_allclose(found["jitter"], 1e-6 / np.sqrt(2.0) * gain, rtol=2e-6)


def test_jitter_of_white_noise_is_that_of_the_band():
    """The root of the power density times the width of the band; one axis is the boresight."""
    vectors = 1e-4 * np.random.default_rng(1).normal(size=(40_000, 3))
    numbers = {"from": 10.0, "jitter_above": 0.5, "jitter_below": 2.0}
    found, _ = observed(Window("w", boresight=Z), numbers, vectors)
    exact = np.sqrt(2 * 1e-8 * 1.5 / 5.0)
    np.testing.assert_allclose(found["jitter"], exact, rtol=0.02)


def test_a_window_without_samples_has_no_metrics():
    numbers = {
        "from": 0.62,
        "until": 0.68,
        "exposure": 0.1,
        "jitter_above": 1.0,
        "dwell_below": 1.0,
    }
    window = Window("w", boresight=Z, propellant="flow")
    found, errors = observed(window, {**numbers, "dwell_above": 0.0}, wandering(20))
    assert len(found) == 14
    assert all(np.isnan(value) for value in found.values())
    assert np.all(np.isinf(errors))


def test_a_window_shorter_than_its_exposure_has_no_smear():
    found, _ = observed(
        Window("w", boresight=Z), {"from": 0.5, "until": 0.9, "exposure": 0.5}, wandering(20)
    )
    assert np.isnan(found["smear"])
    assert np.isfinite(found["error_max"])


def test_a_window_of_a_slew_ends_at_the_next_one():
    vectors = np.zeros((100, 3))
    vectors[20:35, 0] = 0.1
    slews = {"one": 2.0, "two": 6.0, "three": 8.0}
    found, errors = observed(Window("w", event="one"), {}, vectors, slews=slews)
    assert np.flatnonzero(np.isfinite(errors)).tolist() == list(range(20, 60))
    np.testing.assert_allclose(found["settling"], 1.5)
    given = {"from": 0.5, "until": 4.5}
    _, errors = observed(Window("w", event="one"), given, vectors, slews=slews)
    assert np.flatnonzero(np.isfinite(errors)).tolist() == list(range(25, 66))
    _, errors = observed(Window("w", event="three"), {}, vectors, slews=slews)
    assert np.flatnonzero(np.isfinite(errors)).tolist() == list(range(80, 100))


def test_a_window_that_is_not_settled_at_its_end_never_settles():
    vectors = np.zeros((100, 3))
    vectors[50, 1] = 0.1
    assert np.isnan(observed(Window("w"), {"until": 5.0}, vectors)[0]["settling"])
    assert observed(Window("w"), {"until": 5.1}, vectors)[0]["settling"] == pytest.approx(5.1)
    assert observed(Window("w"), {"until": 4.9}, vectors)[0]["settling"] == 0.0


def test_a_window_of_a_mode_is_the_time_of_the_mode():
    """Times are from its start; of several times, the longest settling counts."""
    number = np.repeat([0, 1, 0, 1, 0], 20)
    start = np.repeat([0.0, 2.0, 4.0, 6.0, 8.0], 20)
    vectors = np.zeros((100, 3))
    vectors[18:25, 0] = vectors[55:69, 0] = 0.1
    window = Window("w", mode="second")
    found, errors = observed(window, {}, vectors, mode=(number, start))
    assert np.flatnonzero(np.isfinite(errors)).tolist() == [*range(20, 40), *range(60, 80)]
    np.testing.assert_allclose(found["settling"], 0.9)
    given = {"from": 0.5, "until": 1.0}
    found, errors = observed(window, given, vectors, mode=(number, start))
    assert np.flatnonzero(np.isfinite(errors)).tolist() == [*range(25, 31), *range(65, 71)]
    np.testing.assert_allclose(found["settling"], 0.4)
    vectors[39, 0] = 0.1
    assert np.isnan(observed(window, {}, vectors, mode=(number, start))[0]["settling"])


def test_an_exposure_does_not_extend_over_two_times_of_a_mode():
    number, start = np.repeat([1, 0, 1], 10), np.repeat([0.0, 1.0, 2.0], 10)
    vectors = np.zeros((30, 3))
    vectors[20:, 0] = 0.1
    window = Window("w", mode="second", boresight=Z)
    found, _ = observed(window, {"exposure": 0.5}, vectors, mode=(number, start))
    assert found["smear"] == 0.0
