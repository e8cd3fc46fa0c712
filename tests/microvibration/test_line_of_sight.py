"""Motion of the line of sight against loads and structures that are summed in time."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from gyrostat.microvibration.model import Harmonic, Mode, Noise, WheelDisturbance
from gyrostat.microvibration.sight import MountedWheel, line_of_sight
from gyrostat.microvibration.transfer import ModalModel

HZ, RPM = 2.0 * np.pi, np.pi / 30.0
GENERATOR = np.random.default_rng(4)
MODEL = ModalModel(
    np.array([0.0, 45.0, 90.0]),
    np.array([0.01, 0.01, 0.01]),
    GENERATOR.normal(size=(1, 3, 6)),
    0.1 * GENERATOR.normal(size=(3, 2)),
)
ROCKING = Mode(60.0 * HZ, 0.02, 1.6)
SPEED = np.linspace(300.0, 3000.0, 400) * RPM
POSITION = np.array([0.1, -0.2, 0.3])
AXIS = np.array([2.0, -1.0, 2.0]) / 3.0


def wheel(harmonics, noise=None, name="a"):
    disturbance = WheelDisturbance("wheel", harmonics, {"torque": ROCKING}, noise or {})
    return MountedWheel(name, disturbance, AXIS, POSITION)


def motion_in_time(kind, sense, coefficient, speed, time):
    """Angles of the line of sight, from loads in body axes at each time."""
    first = np.cross([0.0, 1.0, 0.0], AXIS)
    first /= np.linalg.norm(first)
    second = np.cross(AXIS, first)
    w = 2.0 * speed
    gain = ROCKING.gain(sense * w, speed) if kind == "torque" else 1.0
    turning = coefficient * speed**2 * gain * np.exp(1j * sense * w * time)
    load = np.outer(first, turning.real) + np.outer(second, turning.imag)
    zero = np.zeros_like(load)
    loads = [zero, load] if kind == "torque" else [load, np.cross(POSITION, load.T).T]
    loads = np.concatenate(loads)
    # analytic signal of each load: one frequency
    spectrum = 2.0 * np.mean(loads * np.exp(-1j * w * time), axis=1)
    angle = MODEL.at(np.array([w / HZ]), 0)[0] @ spectrum
    return (angle[:, None] * np.exp(1j * w * time)).real


@pytest.mark.parametrize("kind", ["force", "torque"])
@pytest.mark.parametrize("sense", [1, -1])
def test_mean_square_of_a_whirling_load_is_that_of_its_motion(kind, sense):
    values = {kind: 1e-6}
    harmonic = Harmonic(2.0, values) if sense > 0 else Harmonic(2.0, {}, values)
    result = line_of_sight([wheel((harmonic,))], MODEL, SPEED, exposure=10.0)
    for k in (50, 200, 399):
        period = 2.0 * np.pi / (2.0 * SPEED[k])
        time = np.arange(256) / 256.0 * period
        motion = motion_in_time(kind, sense, 1e-6, SPEED[k], time)
        square = result.wheels[0].mean_square("jitter", 10.0)[:, k]
        np.testing.assert_allclose(square, np.mean(motion**2, axis=1), rtol=1e-3)


def test_noise_is_the_integral_of_its_density():
    noise = {"axial": Noise(1e-6, 2.0, SPEED[-1])}
    result = line_of_sight([wheel((), noise)], MODEL, SPEED, exposure=0.05)
    frequency = np.arange(0.4, 270.0, 0.01)
    load = np.concatenate([AXIS, np.cross(POSITION, AXIS)])
    density = np.abs(MODEL.at(frequency, 0) @ load) ** 2 * 1e-6
    x = np.pi * frequency * 0.05
    weight = 1.0 - np.sinc(x / np.pi) ** 2
    expected = np.sqrt(np.sum(np.trapezoid(density.T * weight, frequency, axis=1)))
    assert result.rms()[0, -1] == pytest.approx(expected, rel=0.01)
    assert result.rms()[0, 0] == pytest.approx(0.1 * expected, rel=0.02)


def test_the_limit_holds_while_no_wheel_is_in_a_band():
    harmonics = (Harmonic(1.0, {"force": 1e-6}), Harmonic(2.0, {"torque": 1e-8}))
    wheels = [wheel(harmonics, name="a"), wheel(harmonics, name="b")]
    free = line_of_sight(wheels, MODEL, SPEED, 0.05)
    limit = float(np.median(np.linalg.norm(free.rms(), axis=0)))
    result = replace(free, limit=limit)
    bands = result.bands()
    assert bands
    inside = np.zeros(len(SPEED), dtype=bool)
    for low, high in bands:
        end = SPEED[-1] * (1.0 + 1e-9) if high == SPEED[-1] else high
        inside |= (SPEED - low) * (SPEED - end) < 0.0
    outside = ~inside
    rms = result.rms()
    assert np.hypot(rms[0, outside].max(), rms[1, outside].max()) <= limit * (1.0 + 1e-12)
    assert np.all(rms.max(axis=0)[inside] > limit / np.sqrt(2.0))
    assert all(a[1] < b[0] for a, b in pairwise(bands))
    assert free.bands() == []


def test_a_speed_outside_the_bands_is_known_to_keep_the_limit():
    """The motion is above the limit at the lowest speed, which counts for those below it."""
    speed = np.linspace(44.0, 60.0, 300) * HZ
    free = line_of_sight([wheel((Harmonic(1.0, {"force": 1e-6}),))], MODEL, speed, 0.05)
    for share in (0.5, 0.02):  # without and with the highest speed above the limit
        result = replace(free, limit=share * float(free.rms()[0, 0]), most=2.0 * speed[-1])
        bands = np.array(result.bands())
        tried = np.concatenate([[0.1, 0.9 * speed[0]], speed, speed[-1] * np.array([1.01, 1.9])])
        inside = np.any((tried[:, None] > bands[:, 0]) & (tried[:, None] < bands[:, 1]), axis=1)
        outside = result.in_run(tried[~inside, None])
        assert np.all(np.sqrt(outside) <= result.limit)
        assert inside[[0, 1, -2, -1]].all()
        assert (share == 0.5) == (not inside.all())
        assert np.all(bands[1:, 0] > bands[:-1, 1])


def test_limits_hold_in_both_senses_of_rotation():
    """A wheel that turns the other way is one with the opposite axis."""
    near = replace(MODEL, frequency=np.array([0.0, 45.0, 48.0]))
    one = wheel((Harmonic(1.0, {"force": 1e-6}),))
    both, other = (
        line_of_sight([each], near, SPEED, 0.05) for each in (one, replace(one, axis=-AXIS))
    )
    np.testing.assert_allclose(both.rms(), other.rms(), rtol=1e-12)
    alone = [replace(each, reverse=()).rms() for each in (both, other)]
    assert np.max(np.abs(alone[0] / alone[1] - 1.0)) > 0.01
    np.testing.assert_array_equal(both.rms(), np.maximum(*alone))


def test_mtf_falls_where_the_line_of_sight_jitters_most():
    result = line_of_sight([wheel((Harmonic(1.0, {"force": 1e-6}),))], MODEL, SPEED, 0.05)
    rms = result.rms()[0]
    worst, calm = SPEED[np.argmax(rms)], SPEED[np.argmin(rms)]
    detail = np.array([0.0, 0.3 / rms.max()])
    blurred = result.mtf(detail, np.array([worst]), 0)
    assert blurred[0] == pytest.approx(1.0)
    assert result.mtf(detail, np.array([calm]), 0)[1] > blurred[1]


def test_the_sense_of_rotation_counts_in_mtf_and_in_runs():
    """A wheel that turns the other way is one with the opposite axis, in every result."""
    near = replace(MODEL, frequency=np.array([0.0, 45.0, 48.0]))
    one = wheel((Harmonic(1.0, {"force": 1e-6}),))
    both, other = (
        line_of_sight([each], near, SPEED, 0.05) for each in (one, replace(one, axis=-AXIS))
    )
    detail = np.array([0.3 / both.rms().max()])
    speed = SPEED[np.argmax(np.abs(np.diff(both.mean_squares()[:, 0], axis=0)))]
    curves = [both.mtf(detail, np.array([sense * speed]), 0) for sense in (1.0, -1.0)]
    assert abs(curves[0] - curves[1]) > 1e-3
    np.testing.assert_allclose(curves[1], other.mtf(detail, np.array([speed]), 0), rtol=1e-12)
    worst = both.worst()
    np.testing.assert_allclose(worst, -other.worst())
    assert both.in_run(worst[None, :])[0] == pytest.approx(np.max(both.mean_squares()))
    assert both.in_run(-worst[None, :])[0] < np.max(both.mean_squares()) * 0.999


def test_motion_in_a_run_is_the_sum_over_wheels_and_unknown_above_the_speeds_computed():
    harmonics = (Harmonic(1.0, {"force": 1e-6}),)
    result = line_of_sight([wheel(harmonics), wheel(harmonics, name="b")], MODEL, SPEED, 0.05)
    squares = result.mean_squares()
    speed = np.array([[SPEED[10], -SPEED[70]], [-SPEED[20], SPEED[399]], [0.0, 0.0]])
    expected = [squares[0, 0, 10] + squares[1, 1, 70], squares[1, 0, 20] + squares[0, 1, 399]]
    found = result.in_run(np.vstack([speed, [SPEED[-1] * 1.01, SPEED[0]]]))
    np.testing.assert_allclose(found[:2], expected, rtol=1e-12)
    # below the speeds computed, that of the lowest one
    assert found[2] == pytest.approx(squares[0, 0, 0] + squares[0, 1, 0])
    assert np.isnan(found[3])
