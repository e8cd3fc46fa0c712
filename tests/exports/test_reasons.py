"""Files of reasons: what they say goes into the evidence, and what is about nothing is refused."""

from dataclasses import replace

import pytest

from gyrostat.codegen.flight.reader.decisions import Decision
from gyrostat.codegen.flight.reader.tokens import Position
from gyrostat.core.errors import InputError
from gyrostat.exports.evidence.kinds import coverage
from gyrostat.exports.reasons import read_reasons
from gyrostat.exports.vectors.justifications import Gap
from gyrostat.verbs import export

LINE = "tests/my_law.py:12: never = (measured > 1.0) & (measured < 0.5)"
GOOD = """
[[justified]]
file = "tests/my_law.py"
text = "never = (measured > 1.0)"
condition = 1
cannot_be = ["true", "alone"]
reason = '''
No number is above 1
and below 0.5.'''

[[deviation]]
rule = "15.5"
reason = "A guard returns early."
"""


@pytest.fixture
def read(tmp_path):
    def of(text):
        path = tmp_path / "reasons.toml"
        path.write_text(text, encoding="utf-8")
        return read_reasons(path)

    return of


def decision(source):
    return Decision(
        number=0,
        function="law",
        at=Position(1, 1),
        kind="if",
        source=source,
        conditions=("measured > 1.0", "measured < 0.5"),
        positions=(Position(1, 1), Position(1, 9)),
        tree=("&&", 0, 1),
    )


def test_a_reason_may_be_about_a_helper_function_of_c(read):
    helper = replace(decision(""), function="integer_of", conditions=("a == a",), tree=0)
    text = GOOD.replace('"tests/my_law.py"', '"C"').replace("condition = 1", "condition = 0")
    (reason,) = read(text.replace("never = (measured > 1.0)", "integer_of: a == a")).justified
    assert reason.names(helper)
    assert not reason.names(replace(helper, conditions=("a >= limit",)))
    assert not reason.names(decision(LINE))


def test_a_file_is_read(read):
    found = read(GOOD)
    assert found.deviations == {"15.5": "A guard returns early."}
    (each,) = found.justified
    assert (each.condition, each.wants, each.is_sure) == (1, ("true", "alone"), True)
    assert each.reason == "No number is above 1 and below 0.5."
    found.check([decision(LINE)])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('rule = "15.5"', "", r"\[\[deviation\]\] 1: key rule: found none, expected a text"),
        ('rule = "15.5"', "rule = 15.5", "key rule: found 15.5, expected a text"),
        ("cannot_be", "cannot", r"unknown key \(did you mean .*cannot_be"),
        ('["true", "alone"]', '["yes"]', "expected a list of true, false, alone"),
        ('["true", "alone"]', "true", "expected a list of true, false, alone"),
        ("condition = 1", "condition = -1", "expected a whole number from 0"),
        ("condition = 1", "condition = true", "expected a whole number from 0"),
        ("condition = 1", 'confirm = "yes"', "expected true or false"),
        ("condition = 1", 'modules = "law"', "expected a list of names"),
        ("[[deviation]]", "[deviation]", r"found a table, expected \[\[deviation\]\]"),
        ("[[deviation]]", "[[deviations]]", "unknown key"),
        ("A guard returns early.", " ", "key reason: found ' ', expected a text"),
    ],
)
def test_a_wrong_file_is_refused(read, old, new, message):
    with pytest.raises(InputError, match=message):
        read(GOOD.replace(old, new))


def test_a_reason_about_no_decision_is_refused(read):
    with pytest.raises(InputError, match=r"1: found 'tests/my_law.py' with .*such as 'tests"):
        read(GOOD).check([decision(LINE.replace("never", "often"))])
    with pytest.raises(InputError, match=r"expected the line of a decision.*conditions.csv"):
        read(GOOD).check([])


def test_a_reason_about_no_condition_is_refused(read):
    with pytest.raises(InputError, match="key condition: found 2, expected less than 2"):
        read(GOOD.replace("condition = 1", "condition = 2")).check([decision(LINE)])


def test_reasons_without_evidence_are_refused(tmp_path):
    with pytest.raises(InputError, match="--reasons: found without --evidence"):
        export("model.toml", tmp_path / "out", "c", reasons=tmp_path / "reasons.toml")


def test_a_condition_that_is_not_evaluated_may_leave_its_second_line_out():
    at = Position(5, 3)
    only = {Gap(0, 1, at, "true"): "So.", Gap(0, 2, at, "alone"): "So."}
    assert not coverage._unevaluated_lines(only)
    both = {**only, Gap(0, 1, at, "false"): "So."}
    assert coverage._unevaluated_lines(both) == "line 6\tSo.\n"
