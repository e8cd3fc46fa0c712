"""Budget examples of the kind of the handbooks: error sources in the three interpretations, 1 %.

Sources with a random size, as in annex B of ECSS-E-ST-60-10C: a bias, a drift over the observation
time, and a harmonic. The sizes are uniform between 0 and 1, spread evenly over the runs: the closed
forms have no sampling error.
"""

from math import asin, log, pi, sin

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from gyrostat.campaigns.pointing.collected import Collected
from gyrostat.campaigns.pointing.verdicts import judged
from gyrostat.scenario.requirement import Requirement

RUNS, SAMPLES, PERIOD = 500, 1201, 0.05
TIME = PERIOD * np.arange(SAMPLES)
LENGTH = TIME[-1]
RANDOM = (np.arange(RUNS) + 0.5) / RUNS
SOURCES = {
    "bias": np.ones(SAMPLES),
    "drift": TIME / LENGTH,
    "harmonic": np.sin(2.0 * pi * TIME / 4.0),
}
LEVEL, SHARE = 0.9, 0.8


def found(source, index, interpretation, **keys):
    """Size that is not exceeded at the level, of a campaign with one source."""
    required = Requirement("r", index, 1.0, LEVEL, interpretation, axis="x", share=SHARE, **keys)
    vectors = np.zeros((RUNS, SAMPLES, 3))
    vectors[..., 0] = RANDOM[:, None] * SOURCES[source]
    made = Collected(required, RUNS, PERIOD, SAMPLES, group=RUNS, masks=1)
    made.add(vectors, [np.ones((RUNS, SAMPLES), bool)])
    made.finish()
    counts = made.counts()
    totals = (counts[:, :-1] / np.maximum(counts[:, -1:], 1.0)).sum(axis=0)
    return judged(required, made.metric(), np.zeros(RUNS), totals).size.value


def level_of(cumulative):
    """Size at which a cumulative distribution reaches the level."""
    return brentq(lambda size: cumulative(size) - LEVEL, 1e-6, 1.0)


def harmonic_within(size):
    """Share of time and runs in which |A sin| is within a size, A uniform between 0 and 1."""
    within = quad(lambda a: 2.0 / pi * asin(size / a), size, 1.0)[0]
    return size + within


@pytest.mark.parametrize(
    ("source", "interpretation", "expected"),
    [
        ("bias", "ensemble", LEVEL),
        ("bias", "temporal", SHARE),
        ("bias", "mixed", LEVEL),
        # at the end of the observation time; at a level of the time; product of two uniforms
        ("drift", "ensemble", LEVEL),
        ("drift", "temporal", SHARE * LEVEL),
        ("drift", "mixed", level_of(lambda z: z * (1.0 - log(z)))),
        # amplitude; arcsine distribution; both
        ("harmonic", "ensemble", LEVEL),
        ("harmonic", "temporal", SHARE * sin(0.5 * pi * LEVEL)),
        ("harmonic", "mixed", level_of(harmonic_within)),
    ],
)
def test_the_absolute_error_of_a_source(source, interpretation, expected):
    assert found(source, "APE", interpretation) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize(
    ("source", "index", "interpretation", "expected"),
    [
        # a window of 2 s of the drift, 1 / 60 s at most; of the harmonic half a period
        ("drift", "RPE", "ensemble", LEVEL * 1.0 / LENGTH),
        ("drift", "PDE", "mixed", LEVEL * 6.0 / LENGTH),
        ("harmonic", "MPE", "ensemble", LEVEL * 2.0 / pi),
        # the two windows are one and a half periods apart: twice the mean
        ("harmonic", "PDE", "ensemble", LEVEL * 4.0 / pi),
    ],
)
def test_the_other_indices_of_a_source(source, index, interpretation, expected):
    keys = {"stability": 6.0} if index == "PDE" else {}
    size = found(source, index, interpretation, window=2.0, **keys)
    assert size == pytest.approx(expected, rel=0.01)


def test_the_memory_of_a_long_run_is_that_of_its_windows():
    """Three hundred parts of a run; only the last window and stability time are kept."""
    required = Requirement("r", "PDE", 1.0, 0.9, "ensemble", axis="x", window=1.0, stability=2.0)
    made = Collected(required, 2, PERIOD, 10**6, group=2, masks=1)
    held = set()
    for _ in range(300):
        made.add(np.zeros((2, 100, 3)), [np.ones((2, 100), bool)])
        held.add(made._windows[0]._means._recent._values.nbytes)
    # at most twice: for a part of 100 samples, and 81 before it
    assert len(held) == 1
    assert max(held) <= 2 * 2 * (100 + 81) * 3 * 8
