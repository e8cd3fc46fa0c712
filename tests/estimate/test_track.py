"""Friction along a record: the virtual bench with a known friction, gaps and bad input."""

import numpy as np
import pytest

from gyrostat.errors import InputError
from gyrostat.estimate import FrictionScaleFilter, track_friction
from gyrostat.friction import Stribeck
from gyrostat.simulate import CurrentRange, Telemetry, bench_record
from gyrostat.wheel import Wheel

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
    ],
)
def test_bad_input_is_named(record, change, message):
    with pytest.raises(InputError, match=message):
        track_friction(FILTER, *change(record.time, record.current, record.speed))
