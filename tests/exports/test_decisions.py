"""Decisions of emitted C, and what MC/DC asks of them."""

from itertools import combinations, product

import pytest

from gyrostat.codegen.flight.reader.decisions import independent
from gyrostat.codegen.flight.reader.functions import functions
from gyrostat.codegen.flight.reader.translate import translate
from gyrostat.exports.vectors.coverage import DecisionCoverage

TEXT = """
static bool f(double x, double y)
{
    /* law.py:7: both = x < y */
    const bool both = %s;
    return both;
}
"""


def decision(expression):
    found = translate(functions(TEXT % expression), [], has_margins=False).decisions
    return found[-1]


def fewest(expression):
    """Smallest number of evaluations that show every condition, by trying all sets of them."""
    tested = decision(expression)
    outcomes = tested.outcomes()
    for size in range(2, len(outcomes) + 1):
        for chosen in combinations(outcomes, size):
            if len(independent(tested, chosen)) == tested.size:
                return size
    return None


@pytest.mark.parametrize(
    ("expression", "count"),
    [
        ("(x < y) ? true : false", 2),
        ("(x < y) && (y < 1.0)", 3),
        ("(x < y) && (y < 1.0) && (x > 2.0)", 4),
        ("(x < y) || (y < 1.0) || (x > 2.0)", 4),
        ("(x < y) && ((y < 1.0) || !(x > 2.0))", 4),
        ("!((x < y) && (y < 1.0)) || ((x > 2.0) && (y > 3.0))", 5),
    ],
)
def test_n_conditions_need_one_evaluation_more(expression, count):
    assert fewest(expression) == count
    assert decision(expression).size == count - 1


def test_a_condition_that_repeats_another_never_decides_alone():
    """x < y and not x < y: the values of the conditions are not free."""
    tested = decision("(x < y) && !(x < y)")
    possible = {tested.outcome(values) for values in (0b01, 0b10)}
    assert set(independent(tested, list(possible))) == set()


def test_an_evaluation_has_what_c_evaluates():
    tested = decision("((x < y) || (y < 1.0)) && (x > 2.0)")
    for values in product((False, True), repeat=3):
        code = sum(value << k for k, value in enumerate(values))
        pattern, result = tested.outcome(code)
        left = values[0] or values[1]
        assert result == (left and values[2])
        evaluated = (True, not values[0], left)
        letters = ["TF"[not value] for value in values]
        assert pattern == "".join(
            letter if is_evaluated else "-"
            for letter, is_evaluated in zip(letters, evaluated, strict=True)
        )


def test_goals_complete_what_was_seen():
    coverage = DecisionCoverage(decision("(x < y) && (y < 1.0) && (x > 2.0)"))
    coverage.add(("TTT", True), "first")
    assert {goal.outcome[0] for goal in coverage.goals()} == {"F--", "TF-", "TTF"}
    for pattern in ("F--", "TF-", "TTF"):
        assert not coverage.is_complete
        assert coverage.add((pattern, False), pattern)
    assert coverage.is_complete
    assert not coverage.goals()
    coverage.remove({id(coverage.seen["TTF", False])})
    assert coverage.missing() == [2]


def test_a_decision_knows_where_it_stands():
    found = decision("(x < y) && (y < 1.0)")
    lines = (TEXT % "(x < y) && (y < 1.0)").splitlines()
    for text, at in zip(("(x < y)", "(y < 1.0)"), found.positions, strict=True):
        assert lines[at.line - 1][at.column - 1 :].startswith(text)
    assert (found.kind, found.function, found.source) == ("value", "f", "law.py:7: both = x < y")


def test_every_kind_of_decision_is_found():
    text = """
    static int f(double x)
    {
        int32_t ways = 0;
        for (int32_t pass = 0; pass < 9; ++pass) {
            const bool goes_on = x > 1.0;
            if (!goes_on) { break; }
        }
        for (int32_t i = 0; i < 3; ++i) {
            ways = (x > 2.0) ? 1 : ((x < 0.0) ? 2 : 0);
        }
        return ways;
    }
    """
    found = translate(functions(text), [], has_margins=False).decisions
    assert [(d.kind, d.conditions) for d in found] == [
        ("for", ("pass < 9",)),
        ("if", ("!goes_on",)),
        ("for", ("i < 3",)),
        ("?:", ("x > 2.0",)),
        ("?:", ("x < 0.0",)),
    ]
