"""Test for feedback: open and closed loops, and what is stated."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gyrostat.identification import identify
from gyrostat.identification.judge.plausibility import fit_warnings
from gyrostat.identification.uncertainty import feedback
from gyrostat.identification.uncertainty.feedback import feedback_in
from gyrostat.telemetry import Record

COUNT = 3000


def signals(seed, gain, *, memory=0.9, steps=None):
    """Record whose speed answers the current, and drives it by a gain, if that is not zero."""
    rng = np.random.default_rng(seed)
    noise, programme = rng.normal(size=(2, COUNT))
    current, speed = np.zeros(COUNT), np.zeros(COUNT)
    for k in range(1, COUNT):
        friction = 0.5 * np.sign(speed[k - 1])
        speed[k] = memory * (speed[k - 1] - friction) + 0.5 * current[k - 1] + noise[k]
        current[k] = 0.95 * current[k - 1] + programme[k] - gain * speed[k - 1]
        if steps is not None:
            current[k] = steps[k]
    time = 0.1 * np.arange(COUNT)
    valid = np.ones(COUNT, dtype=bool)
    return Record(name="r", time=time, current=current, speed=speed, valid=valid)


def test_feedback_is_found_in_few_open_loops():
    """Of 200 records, 5 % are 10, and 4 sigma more are 22; the level of the test is below 0.1 %."""
    found = 0
    for seed in range(200):
        found += feedback_in([signals(seed, 0.0, memory=(0.0, 0.9, 0.99)[seed % 3])]).found
    assert found <= 2


@pytest.mark.parametrize("gain", [0.1, 0.2])
def test_feedback_is_found_in_closed_loops(gain):
    assert all(feedback_in([signals(seed, gain)]).found for seed in range(5))


def test_a_current_that_is_recorded_late_is_no_feedback():
    for seed in range(20):
        record = signals(seed, 0.0)
        late = np.concatenate([record.current[:1], record.current[:-1]])
        assert not feedback_in([replace(record, current=late)]).found


def test_missing_speeds_are_no_feedback():
    """Interpolated speeds would know the currents after them."""
    for seed in range(20):
        record = signals(seed, 0.0)
        valid = np.random.default_rng(seed).random(COUNT) > 0.3
        speed = np.where(valid, record.speed, np.nan)
        assert not feedback_in([replace(record, speed=speed, valid=valid)]).found


def test_a_programme_of_steps_shows_no_feedback():
    found = 0
    for seed in range(100):
        steps = np.repeat(np.random.default_rng(seed).normal(size=COUNT // 100), 100)
        verdict = feedback_in([signals(seed, 0.0, steps=steps)])
        found += verdict.verdict != "feedback not excluded"
    assert found <= 1


@pytest.fixture(scope="module")
def closed(module_at):
    path = Path(__file__).resolve().parents[2] / "benchmarks" / "drives.py"
    module = module_at(path)
    case = replace(module.CASES["speed-p"], duration=40.0)
    return module.simulate(case, 1)


@pytest.mark.parametrize("loop", ["closed", "open"])
def test_a_stated_loop_is_not_tested(closed, loop):
    record, true = closed
    options = {"inertia": true["inertia"], "model": "viscous-coulomb", "white_noise": True}
    fit = identify(record, **options, loop=loop)
    assert fit.to_dict()["feedback"]["verdict"] == f"{loop} loop, as stated"
    assert any("--method inverse" in w for w in fit.warnings) == (loop == "closed")


def test_least_squares_of_a_closed_loop_is_warned_about(closed):
    record, true = closed
    inertia = true["inertia"]
    fit = identify(record, inertia=inertia, model="viscous-coulomb", white_noise=True)
    fit = replace(fit, feedback=feedback_in(fit.records))
    words = [w for w in fit_warnings(fit, "", []) if "--method inverse" in w]
    assert len(words) == 1
    assert "the current answers earlier residuals of the speed" in words[0]


def test_batch_fits_are_tested(plain):
    assert plain.feedback.verdict == "feedback not excluded"
    assert plain.to_dict()["feedback"]["probability"] > 1e-3


def test_a_rounded_sweep_is_no_feedback():
    """The speed predicts the rounding error of a current that its own past predicts."""
    share = np.arange(COUNT) / COUNT
    sweep = 300.0 * np.sin(2.0 * np.pi * (3.0 + 45.0 * share) * share)
    for seed in range(3):
        record = signals(seed, 0.0, steps=sweep)
        rounded = replace(record, current=3.0 * np.round(record.current / 3.0))
        assert not feedback_in([rounded]).found


def test_periods_that_current_and_speed_share_are_no_feedback():
    for seed, period in enumerate(np.linspace(21.3, 58.7, 12)):
        phase = (np.arange(COUNT) / period) % 1.0
        ramps = 300.0 * (2.0 * np.abs(2.0 * phase - 1.0) - 1.0)
        assert not feedback_in([signals(seed, 0.0, steps=ramps)]).found


def test_a_long_record_is_tested_from_its_first_to_its_last_part(monkeypatch):
    """Only the last two thirds are in closed loop, and a third of the samples is tested."""
    monkeypatch.setattr(feedback, "MOST", COUNT)
    monkeypatch.setattr(feedback, "PIECE", 300)
    parts = [signals(0, 0.0), signals(1, 0.3), signals(2, 0.3)]
    current = np.concatenate([part.current for part in parts])
    speed = np.concatenate([part.speed for part in parts])
    time = 0.1 * np.arange(len(speed))
    record = Record("r", time=time, current=current, speed=speed, valid=np.ones(len(speed), bool))
    assert feedback_in([record]).found
    assert not feedback_in([replace(record, current=np.roll(current, COUNT // 2))]).found
