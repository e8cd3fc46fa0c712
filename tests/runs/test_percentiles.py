"""Percentiles of errors: the rank definition, exact or in bins."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gyrostat.runs.metrics import percentiles
from gyrostat.runs.metrics.percentiles import BinnedErrors, SortedErrors, collectors, rank

PERCENTS = (5.0, 50.0, 95.0, 99.7)
ERRORS = arrays(float, (3, 50), elements=st.floats(1e-9, 3.2) | st.just(0.0) | st.just(np.inf))


def collected(kind, errors, parts=3):
    """Errors taken in one part after the other."""
    runs, samples = errors.shape
    made = kind(runs, samples) if kind is SortedErrors else kind(runs)
    for part in np.array_split(errors, parts, axis=1):
        made.add(part)
    return made


@given(percent=st.sampled_from([0.1, 5.0, 33.3, 50.0, 99.7]), count=st.integers(1, 5000))
def test_a_rank_is_the_first_that_holds_the_share(percent, count):
    found = rank(percent, count)
    share = Fraction(str(percent)) / 100 * count
    assert found >= share
    assert found == 1 or found - 1 < share


def test_a_rank_that_comes_out_whole_is_not_rounded_up():
    # 0.07 * 100 is 7.000000000000001
    assert rank(7.0, 100) == 7
    assert rank(99.7, 1000) == 997


@given(ERRORS)
def test_sorted_errors_give_numpys_percentiles(errors):
    found = collected(SortedErrors, errors)
    for percent in PERCENTS:
        for value, row in zip(found.percentile(percent), errors, strict=True):
            counted = row[row < np.inf]
            if counted.size == 0:
                assert np.isnan(value)
            else:
                assert value == np.percentile(counted, percent, method="inverted_cdf")


@given(ERRORS)
def test_bins_give_them_to_a_thousandth_and_none_above_the_maximum(errors):
    exact, found = collected(SortedErrors, errors), collected(BinnedErrors, errors)
    for percent in PERCENTS:
        value, expected = found.percentile(percent), exact.percentile(percent)
        np.testing.assert_allclose(value, expected, rtol=1e-3, atol=1e-9)
        largest = np.max(np.where(errors < np.inf, errors, 0.0), axis=1)
        assert not np.any(value > largest)


@pytest.mark.parametrize("kind", [SortedErrors, BinnedErrors])
def test_sixty_four_histories(kind):
    errors = np.random.default_rng(1).lognormal(-7.0, 1.0, (64, 1601))
    found = collected(kind, errors, 4)
    for percent in PERCENTS:
        exact = np.percentile(errors, percent, method="inverted_cdf", axis=1)
        rtol = 0.0 if kind is SortedErrors else 1e-3
        np.testing.assert_allclose(found.percentile(percent), exact, rtol=rtol)


def test_what_exceeds_the_memory_is_binned(monkeypatch):
    assert isinstance(collectors(1, 390_625, 64, 1)[0], SortedErrors)
    # the choice is that of the whole group, so that a part of it gives the same numbers
    assert isinstance(collectors(1, 390_626, 64, 1)[0], BinnedErrors)
    monkeypatch.setattr(percentiles, "MEMORY", 1e3)
    assert isinstance(collectors(1, 100, 64, 1)[0], BinnedErrors)


def test_windows_share_the_memory():
    three = collectors(2, 130_208, 64, 3)
    assert [type(each) for each in three] == [SortedErrors] * 3
    assert [type(each) for each in collectors(2, 130_209, 64, 3)] == [BinnedErrors] * 3
