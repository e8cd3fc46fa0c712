"""Changes of mode against a state machine in plain Python, and hysteresis by its properties."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrostat.control.guidance import Condition, Fixed, ModeChange, Reference, SlewLimits
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import SpacecraftMeasurement

REST = np.array([1.0, 0.0, 0.0, 0.0])
PERIOD = 0.25
LIMITS = SlewLimits(1.0, 100.0, np.inf)


def turned(angle):
    return np.array([np.cos(0.5 * angle), 0.0, 0.0, np.sin(0.5 * angle)])


CHANGES = [
    ModeChange(0, Condition(rate_above=0.5, held=0.5, reached=0.0)),
    ModeChange(1, Condition(rate_below=0.2, held=1.0, reached=0.0), (0,)),
    ModeChange(2, Condition(at=10.0, reached=0.0), (1,)),
    ModeChange(1, Condition(after=3.0, reached=0.0), (2,)),
    ModeChange(3, Condition(tracker_lost=1.5, reached=0.0), (1, 2)),
    ModeChange(0, Condition(after=2.0, error_below=0.3, reached=0.0), (3,)),
    ModeChange(0, Condition(after=1.75, reached=0.0), (0,)),
]
DWELL = np.array([1.0, 0.0, 0.5, 0.0])
MODES = Reference.branching(
    [Fixed(turned(angle)) for angle in (0.0, 0.1, 0.2, 0.15)],
    CHANGES,
    dwell=DWELL,
    limits=LIMITS,
)


@jax.jit
def chosen(rates, tracked):
    """Mode and change at each sample."""

    def sample(mode, row):
        k, rate, is_tracked = row
        measurement = SpacecraftMeasurement(
            jnp.asarray(REST), rate * jnp.array([1.0, 0.0, 0.0]), jnp.zeros(4), jnp.ones(4, bool)
        )
        measurement = WithTracker(*measurement, is_tracked)
        mode = MODES.step(mode, measurement, k * PERIOD)
        return mode, (mode.number, mode.watch.taken)

    count = len(rates)
    start = jax.tree.map(jnp.asarray, MODES.start())
    return jax.lax.scan(sample, start, (jnp.arange(count), rates, tracked))[1]


class WithTracker(tuple):
    """Measurement with `attitude_measured`."""

    __slots__ = ()

    def __new__(cls, *values):
        return super().__new__(cls, values)

    attitude, rate, wheel_speed, _, attitude_measured = (
        property(lambda self, k=k: self[k]) for k in range(5)
    )


def starts_in(change, mode):
    return mode != change.to if change.origins is None else mode in change.origins


def machine(rates, tracked):
    """Modes and changes by a state machine that counts samples; no rotation takes a sample."""
    mode, start, last, taken = 0, 0, 0, 0
    held = [0] * len(CHANGES)  # samples for which each change has held
    results = []
    for k, (rate, is_tracked) in enumerate(zip(rates, tracked, strict=True)):
        last = k if is_tracked else last
        elapsed, time = (k - start) * PERIOD, k * PERIOD
        error = (0.0, 0.1, 0.2, 0.15)[mode]
        holds = []
        for change in CHANGES:
            c = change.condition
            at = c.at < 0.0 or (time >= c.at and start * PERIOD < c.at)
            error_holds = error < c.error_below and error > c.error_above
            limits = rate < c.rate_below and rate > c.rate_above and error_holds
            holds.append(
                limits and at and elapsed >= c.after and (k - last) * PERIOD >= c.tracker_lost
            )
        held = [n + 1 if hold else 0 for n, hold in zip(held, holds, strict=True)]
        if k == 0:  # times are counted from the start of a mode
            held = [n if c.condition.held == 0.0 else 0 for n, c in zip(held, CHANGES, strict=True)]
        for number, change in enumerate(CHANGES):
            starts_here = starts_in(change, mode)
            needed = change.condition.held
            ripe = held[number] >= 1 and (held[number] - 1) * PERIOD >= needed
            if ripe and starts_here and elapsed >= DWELL[mode]:
                held = [
                    n if c is not change and starts_in(c, mode) and starts_in(c, change.to) else 0
                    for n, c in zip(held, CHANGES, strict=True)
                ]
                mode, start, taken = change.to, k, number + 1
                break
        results.append((mode, taken))
    return np.array(results)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_modes_are_those_of_a_state_machine(seed):
    random = np.random.default_rng(seed)
    count = 120
    rates = np.repeat(random.choice([0.1, 0.3, 0.6], count // 6), 6)
    tracked = np.repeat(random.random(count // 8) < 0.6, 8)
    numbers, taken = chosen(rates, tracked)
    expected = machine(rates, tracked)
    np.testing.assert_array_equal(numbers, expected[:, 0])
    np.testing.assert_array_equal(taken, expected[:, 1])


def test_every_change_of_the_oracle_is_taken():
    """Otherwise the comparison would be empty."""
    seen = set()
    for seed in range(40):
        random = np.random.default_rng(seed)
        rates = np.repeat(random.choice([0.1, 0.3, 0.6], 20), 6)
        seen |= set(machine(rates, np.repeat(random.random(15) < 0.6, 8))[:, 1])
    assert seen == set(range(len(CHANGES) + 1))


@pytest.mark.parametrize(("origins", "number"), [(None, 3), ((1, 2), 3), ((2,), 2)])
def test_a_condition_watched_from_several_modes_holds_on_across_their_changes(origins, number):
    """Fast from 1.25 s on, and the mode changes at 2 s; 2 s of it are needed."""
    reference = Reference.branching(
        [Fixed(REST)] * 4,
        [
            ModeChange(1, Condition(at=1.0, reached=0.0), (0,)),
            ModeChange(2, Condition(at=2.0, reached=0.0), (1,)),
            ModeChange(3, Condition(rate_above=0.5, held=2.0, reached=0.0), origins),
        ],
        limits=LIMITS,
    )
    mode = reference.start()
    for k in range(14):
        rate = np.array([1.0 if k > 4 else 0.0, 0.0, 0.0])
        fast = SpacecraftMeasurement(REST, rate, np.zeros(4), np.ones(4, bool))
        mode = reference.step(mode, fast, jnp.asarray(k * PERIOD))
    assert mode.number == number


@pytest.mark.parametrize("unrelated", [(), (ModeChange(2, Condition(rate_above=1e6), (0, 1)),)])
def test_a_condition_holds_on_across_a_change_of_its_mode_to_itself(unrelated):
    """Fast from 1.25 s on, and the mode begins anew at 2 s; 2 s of it are needed."""
    reference = Reference.branching(
        [Fixed(REST)] * 3,
        [
            ModeChange(0, Condition(at=2.0, reached=0.0), (0,)),
            ModeChange(1, Condition(rate_above=0.5, held=2.0, reached=0.0), (0,)),
            *unrelated,
        ],
        limits=LIMITS,
    )
    mode, numbers = reference.start(), []
    for k in range(16):
        rate = np.array([1.0 if k > 4 else 0.0, 0.0, 0.0])
        fast = SpacecraftMeasurement(REST, rate, np.zeros(4), np.ones(4, bool))
        mode = reference.step(mode, fast, jnp.asarray(k * PERIOD))
        numbers.append(int(mode.number))
    assert numbers == [*(13 * [0]), *(3 * [1])]


HYSTERESIS = Reference.branching(
    [Fixed(REST), Fixed(REST)],
    [
        ModeChange(1, Condition(rate_above=0.5, held=1.0, reached=0.0), (0,)),
        ModeChange(0, Condition(rate_below=0.3, held=1.0, reached=0.0), (1,)),
    ],
    dwell=np.array([0.0, 2.0]),
    limits=LIMITS,
)


@jax.jit
def switched(rates):
    def sample(mode, row):
        k, rate = row
        vector = rate * jnp.array([0.0, 1.0, 0.0])
        measurement = SpacecraftMeasurement(REST, vector, jnp.zeros(4), jnp.ones(4, bool))
        mode = HYSTERESIS.step(mode, measurement, k * PERIOD)
        return mode, mode.number

    start = jax.tree.map(jnp.asarray, HYSTERESIS.start())
    return jax.lax.scan(sample, start, (jnp.arange(80), rates))[1]


@given(st.lists(st.floats(0.0, 1.0), min_size=80, max_size=80))
@settings(max_examples=60, deadline=None)
def test_hysteresis_holds(rates):
    modes = np.asarray(switched(np.array(rates)))
    changes = np.flatnonzero(np.diff(modes, prepend=0))
    for k in changes:
        before = np.array(rates[k - 4 : k + 1])
        assert np.all(before > 0.5) if modes[k] else np.all(before < 0.3)
    for begin, end in itertools.pairwise(changes):
        assert end - begin >= (8 if modes[begin] else 5)


@pytest.mark.parametrize("rate", [0.31, 0.49])
def test_between_the_thresholds_nothing_changes(rate):
    for first in (0.0, 1.0):
        modes = np.asarray(switched(np.r_[np.full(20, first), np.full(60, rate)]))
        assert np.all(modes[20:] == modes[19])
        assert modes[19] == (first > 0.5)


def test_the_middle_of_a_slew_is_left_without_a_step():
    """From a slew at its largest rate to another mode: attitude, rate and acceleration."""
    slow = SlewLimits(0.05, 0.01, 0.01)
    modes = [Fixed(turned(angle)) for angle in (0.0, 2.0, -1.0)]
    reference = Reference.branching(modes, [], limits=slow)
    enter = jax.jit(lambda mode, number, time: reference.entered(mode, number, time))
    at = jax.jit(lambda mode, time: reference.at(mode, time))
    first = enter(reference.start(), jnp.array(1), 0.0)
    time = 0.4 * float(first.transition.duration)
    before = at(first, time)
    assert np.linalg.norm(before.rate) > 0.04
    second = enter(first, jnp.array(2), time)
    after = at(second, time)
    for earlier, later in zip(before, after, strict=True):
        np.testing.assert_allclose(earlier, later, atol=1e-12)
    end = at(second, time + float(second.transition.duration))
    assert abs(end.attitude @ turned(-1.0)) == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(end.rate, 0.0, atol=1e-12)


@pytest.mark.parametrize(("count", "number"), [(4, 0), (5, 1)])
def test_a_missing_sample_neither_fulfils_nor_interrupts(count, number):
    """The third of the samples is missing; 1 s after the first one the change is taken."""
    reference = Reference.branching(
        [Fixed(REST), Fixed(REST)],
        [ModeChange(1, Condition(rate_above=0.5, held=1.0, reached=0.0), (0,))],
        limits=LIMITS,
    )
    fast = SpacecraftMeasurement(REST, np.array([1.0, 0.0, 0.0]), np.zeros(4), np.ones(4, bool))
    mode = reference.start()
    for k in range(count):
        mode = reference.step(mode, None if k == 2 else fast, jnp.asarray((k + 1) * PERIOD))
    assert mode.number == number


def test_one_sample_after_a_gap_has_not_held():
    """The limit does not hold before the gap, which is longer than the time to hold."""
    reference = Reference.branching(
        [Fixed(REST), Fixed(REST)],
        [ModeChange(1, Condition(rate_above=0.5, held=1.0, reached=0.0), (0,))],
        limits=LIMITS,
    )
    slow, fast = (
        SpacecraftMeasurement(REST, np.array([rate, 0.0, 0.0]), np.zeros(4), np.ones(4, bool))
        for rate in (0.1, 1.0)
    )
    samples = [slow, *(8 * [None]), *(5 * [fast])]
    mode, numbers = reference.start(), []
    for k, sample in enumerate(samples):
        mode = reference.step(mode, sample, jnp.asarray((k + 1) * PERIOD))
        numbers.append(int(mode.number))
    # 1 s after the first of the fast samples
    assert numbers == [*(13 * [0]), 1]
