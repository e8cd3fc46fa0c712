"""Friction along a record: the virtual bench with a known friction, gaps and bad input."""

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.estimation import FrictionScaleFilter, track_friction
from gyrostat.simulation import CurrentRange, Telemetry, bench_record
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import Stribeck

SIGMA = 0.5
MODEL = Wheel(1.5e-3, 0.0228, Stribeck(4.83e-6, 0.8795e-3, 0.9055e-3, 0.418879))
WORN = Wheel(1.5e-3, 0.0228, Stribeck(1.3 * 4.83e-6, 1.3 * 0.8795e-3, 1.3 * 0.9055e-3, 0.418879))
FILTER = FrictionScaleFilter(MODEL, SIGMA, 1e-4)


@pytest.fixture(scope="module")
def record():
    telemetry = Telemetry(rate=10.0, speed_sigma=SIGMA, jitter=0.1, dropouts=0.05)
    # one seed in twenty lies outside a 95 % band by chance; this one does not
    return bench_record(
        WORN,
        "steps",
        duration=120.0,
        telemetry=telemetry,
        amplitudes=CurrentRange(0.08, 0.15),
        seed=2,
    )


def test_a_worn_bearing_is_seen_with_honest_uncertainty(record):
    track = track_friction(FILTER, record.time, record.current, record.speed)
    error = track.scale[-1] - 1.3
    assert abs(error) < 4.0 * track.scale_sigma[-1] < 0.05
    assert track.missed == int(np.sum(~record.valid)) > 0
    assert track.consistent
    assert np.all(np.isfinite(track.scale))


def test_the_first_speed_is_used_once():
    """The second innovation is a difference of two measurements: its variance is twice theirs."""
    # three samples each, so that both records are tracked by one program
    track = track_friction(FILTER, [0.0, 1e-3, 1.0], [0.1] * 3, [50.0, 51.0, np.nan])
    squared = track.normalised_innovation_squared
    assert np.isnan(squared[0])
    assert squared[1] == pytest.approx(1.0 / (2.0 * SIGMA**2), rel=1e-2)
    late = track_friction(FILTER, [0.0, 1.0, 1.001], [0.1] * 3, [np.nan, 50.0, 51.0])
    assert np.isnan(late.normalised_innovation_squared[1])
    assert late.normalised_innovation_squared[2] == pytest.approx(squared[1], rel=1e-2)


def test_a_filter_of_several_is_refused(record):
    several = FrictionScaleFilter(MODEL, np.array([SIGMA, SIGMA]), 1e-4)
    with pytest.raises(InputError, match=r"filter: found parameters of shape \(2,\)"):
        track_friction(several, record.time, record.current, record.speed)


def test_a_wrong_noise_is_not_consistent(record):
    loud = FrictionScaleFilter(MODEL, 0.5 * SIGMA, 1e-4)
    assert not track_friction(loud, record.time, record.current, record.speed).consistent


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t, i, w: (t[::-1], i, w), "time of sample 1: found .* expected increasing"),
        (lambda t, i, w: (np.zeros_like(t), i, w), "time of sample 1: found 0 s after 0 s"),
        (lambda t, i, w: (t, np.full_like(i, np.nan), w), "current of sample 0: found nan"),
        (lambda t, i, w: (t, i, np.full_like(w, np.nan)), "speed: found 0 finite samples"),
        (lambda t, i, w: (t, i[1:], w), "expected equally many"),
        (lambda t, i, w: (t[:1], i[:1], w[:1]), "2 or more"),
        (lambda t, i, w: ([], [], []), "found 0, 0 and 0 samples"),
        (lambda t, i, w: (t[:, None], i[:, None], w[:, None]), r"time: found shape \(.*, 1\)"),
        (lambda t, i, w: (t, i, 3.0), r"speed: found shape \(\)"),
        (lambda t, i, w: (t, i, ["fast"] * len(t)), "speed: found values that are no numbers"),
        (lambda t, i, w: (t, i, np.append(w[:-1], 1e300)), r"speed of .* found 1e\+300 rad/s"),
        (lambda t, i, w: (t + 1e5 * (t > 60.0), i, w), "found an interval of 100000.* s at 5"),
    ],
)
def test_bad_input_is_named(record, change, message):
    with pytest.raises(InputError, match=message):
        track_friction(FILTER, *change(record.time, record.current, record.speed))
