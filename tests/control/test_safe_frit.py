"""FRIT with its bounds, and the compensator for limited actuators, on textbook plants."""

import numpy as np
import pytest

from gyrostat.control import (
    ConditionedCompensator,
    FirstOrderLags,
    Integrators,
    OnlineFrit,
    SafeFrit,
)
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

PERIOD = 0.1
FEEDBACK = 0.5
LAG = FirstOrderLags(jnp.array([FEEDBACK]))


def safe(**changes):
    fields = {
        "feedback": jnp.array([FEEDBACK]),
        "reference": LAG,
        "forgetting": 0.98,
        "smoothing": 0.1,
        "dead_zone": jnp.array([0.05]),
        "initial_gain": jnp.array([0.3]),
        "lowest": jnp.array([-50.0]),
        "highest": jnp.array([50.0]),
        "largest_covariance": 100.0,
        "wait": -1.0,
    }
    return SafeFrit(**{**fields, **changes})


@pytest.fixture(scope="module")
def signals():
    random = np.random.default_rng(4)
    rows = random.normal(size=(400, 3, 1))
    rows[:, 1] -= 2.0 * rows[:, 0]
    return jnp.asarray(rows), jnp.asarray(random.uniform(size=400) < 0.01)


def tuned(frit, signals):
    """Gains, covariances and information of each sample."""

    def step(memory, row):
        (error, input, output), cut = row
        memory = frit(memory, error=error, input=input, output=output, cut=cut, period=PERIOD)
        return memory, (memory.gain[0], memory.rows.covariance[0, 0, 0])

    return jax.lax.scan(step, frit.start(signals[0][0, 2]), signals)[1]


def test_without_its_bounds_it_is_online_frit(signals):
    rows, _ = signals
    free = OnlineFrit(
        feedback=jnp.array([FEEDBACK]),
        reference=LAG,
        forgetting=0.98,
        smoothing=0.1,
        dead_zone=jnp.array([0.05]),
        initial_gain=jnp.array([[0.3]]),
        initial_covariance=98.0,  # 100 after the first sample, where the filters are empty
        filters_from_output=True,
    )

    def step(memory, row):
        error, input, output = row
        memory = free(memory, error=error, input=input, output=output, period=PERIOD)
        return memory, memory.gain[0, 0]

    expected = jax.lax.scan(step, free.start(rows[0, 2]), rows)[1]
    gains, _ = tuned(safe(), (rows, jnp.zeros(len(rows), dtype=bool)))
    assert np.ptp(expected) > 0.1
    assert np.allclose(gains, expected, atol=1e-9)


def test_it_stays_in_its_range_and_covariance(signals):
    low, high = jnp.array([0.28]), jnp.array([0.33])
    gains, covariance = tuned(safe(lowest=low, highest=high, largest_covariance=0.5), signals)
    assert np.all((gains >= low) & (gains <= high))
    assert np.min(gains) < 0.29
    assert np.all((covariance <= 0.5) & (covariance > 0.0))


def test_covariance_does_not_grow_without_information():
    nothing = jnp.full((3000, 3, 1), 1e-9)
    quiet = jnp.zeros(3000, dtype=bool)
    _, covariance = tuned(safe(dead_zone=jnp.zeros(1)), (nothing, quiet))
    assert covariance[-1] == 100.0


def test_it_waits_after_a_cut(signals):
    cuts = np.asarray(signals[1])
    gains, _ = tuned(safe(wait=1.95), signals)
    moved = np.flatnonzero(np.diff(np.asarray(gains), prepend=0.3) != 0.0)
    last = [max(np.flatnonzero(cuts[: k + 1]), default=-1) for k in moved]
    # quiet for longer than the wait: 20 samples after the cut, or after the start
    assert np.min(moved - last) == 20
    assert len(moved) > 50


def test_it_is_nearly_blind_to_the_gain():
    # y' = u + d, u = -F y + K (y_n - y): whatever K makes K e = -d, the estimate calls right
    integrator = ConditionedCompensator(Integrators())
    for start in (0.1, 0.5):
        frit = safe(initial_gain=jnp.array([start]), dead_zone=jnp.zeros(1), forgetting=0.995)

        def step(carry, _, frit=frit):
            y, memory, tuning, given = carry
            tuning = frit(
                tuning,
                error=memory.error,
                input=given,
                output=y,
                cut=jnp.array(False),
                period=PERIOD,
            )
            memory = integrator(memory, given, y, frit.initial_gain, PERIOD)
            given = -FEEDBACK * y + memory.correction
            return (y + PERIOD * (given + 0.02), memory, tuning, given), tuning.rows.estimate

        zero = jnp.zeros(1)
        first = (zero, integrator.start(zero), frit.start(zero), zero)
        found = jax.lax.scan(step, first, length=3000)[1]
        assert found[-1, 0, 0] == pytest.approx(start, rel=0.02)


def limited(conditioned, gain=0.5, bias=0.05, limit=0.2, steps=900):
    """Error of y' = clip(u) + bias towards 0 from 10, with F y as the law."""
    compensator = ConditionedCompensator(Integrators())

    def step(carry, _):
        y, memory, given = carry
        memory = compensator(memory, given, y, gain, PERIOD)
        wanted = -FEEDBACK * y + memory.correction
        acts = jnp.clip(wanted, -limit, limit)
        told = acts if conditioned else wanted
        return (y + PERIOD * (acts + bias), memory, told), (y[0], memory.correction[0])

    start = jnp.array([10.0])
    first = (start, compensator.start(start), jnp.zeros(1))
    return jax.lax.scan(step, first, length=steps)[1]


def test_told_what_the_actuators_did_it_does_not_wind_up():
    output, correction = limited(True)
    # the estimate of the bias is a lag of rate K, whether the actuator is at its limit or not
    decay = (1.0 - 0.5 * PERIOD) ** np.arange(len(output))
    assert np.allclose(correction, -0.05 * (1.0 - decay), atol=1e-9)
    assert np.min(output) > -0.15
    assert abs(output[-1]) < 1e-3
    wound, _ = limited(False)
    assert np.max(np.abs(wound[300:])) > 1.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"forgetting": 0.0}, "forgetting"),
        ({"forgetting": 1.1}, "forgetting"),
        ({"smoothing": 0.0}, "smoothing"),
        ({"smoothing": np.nan}, "smoothing"),
        ({"largest_covariance": 0.0}, "covariance"),
        ({"feedback": jnp.array([0.0])}, "feedback"),
        ({"wait": -1.0}, "wait"),
        ({"lowest": jnp.array([-1.0])}, "lowest"),
        ({"initial_gain": jnp.array([3.0])}, "initial gain"),
        ({"initial_gain": jnp.array([np.nan])}, "initial gain"),
    ],
)
def test_bad_tunings_are_refused(change, words):
    sound = {"lowest": jnp.array([0.1]), "highest": jnp.array([1.0]), "wait": 60.0}
    safe(**sound).check()
    with pytest.raises(InputError, match=words):
        safe(**{**sound, **change}).check()
