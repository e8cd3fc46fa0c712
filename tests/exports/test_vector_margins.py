"""What the search for test vectors learns from margins, against values by hand and a parabola."""

import numpy as np
import pytest

from gyrostat.codegen.flight.reader.functions import functions
from gyrostat.codegen.flight.reader.margins import Logic
from gyrostat.codegen.flight.reader.translate import translate
from gyrostat.exports.vectors.coverage import Coverage, Goal
from gyrostat.exports.vectors.descend import _peak

TEXT = """
static double smaller(double x)
{
    return (x < 1.0) ? 0.0 : x;
}
"""
WANTED = Goal(0, ("T", True))


def record(coverage, lanes, path, margin):
    """A call of the function, in which the comparison has a margin in each lane."""
    margin = np.array(margin)
    coverage.record(0, np.array(lanes), np.array(path), (Logic(margin > 0.0, margin),))


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_a_call_that_reaches_the_decision_counts_before_one_that_is_nearer(order):
    coverage = Coverage(translate(functions(TEXT), [], has_margins=False).decisions)
    coverage.begin([False])
    calls = [
        ([True, False, False], [3.0, -7.0, -2.0], [-5.0, 1.0, 1.0]),
        ([False, True, False], [-0.1, 2.0, -4.0], [4.0, -6.0, 4.0]),
    ]
    for call in order:
        record(coverage, *calls[call])
    reached, margin = coverage.margins[WANTED]
    np.testing.assert_array_equal(reached, [1.0, 1.0, 0.0])
    np.testing.assert_array_equal(margin, [-5.0, -6.0, -2.0])


def test_the_peak_is_that_of_a_parabola():
    at = {x: 3.0 - 2.0 * (x - 0.7) ** 2 for x in (-40.0, -3.0, 1.0, 12.0)}
    assert _peak(at) == pytest.approx(0.7, rel=1e-14)


@pytest.mark.parametrize(
    "margins",
    [
        {0.0: 1.0, 1.0: 2.0},
        {0.0: 1.0, 1.0: 2.0, 2.0: 3.0},
        {0.0: 1.0, 1.0: 0.0, 2.0: 1.0},
        {0.0: 1.0, 1.0: 2.0, np.inf: 1.0},
    ],
    ids=["two values", "a line", "a minimum", "an infinite value"],
)
def test_without_a_maximum_there_is_no_peak(margins):
    assert _peak(margins) is None
