"""The search for test vectors, with clang as the independent judge of what they show."""

import csv
import dataclasses
import io
import re
import shutil
import subprocess
from typing import NamedTuple

import numpy as np
import pytest

from gyrostat.codegen.flight.reader.functions import functions
from gyrostat.codegen.flight.reader.tokens import UnreadableError
from gyrostat.codegen.flight.reader.translate import translate
from gyrostat.core.files import write_texts
from gyrostat.core.jax64 import jax, jnp
from gyrostat.exports import Search, files, read_results
from gyrostat.exports.folder import emitted
from gyrostat.exports.reasons import Reasons
from gyrostat.exports.target import STEPS, flight_module
from gyrostat.exports.vectors import machine
from gyrostat.exports.vectors.find import find_vectors
from gyrostat.exports.vectors.justifications import Justification, gaps

THRESHOLD = 12345.678
COVERAGE_TOOLS = ("clang-19", "llvm-profdata-19", "llvm-cov-19")


class Gains(NamedTuple):
    """Parameters of the law."""

    gain: float
    limit: float


def law(gains, memory, measured):
    """A law with conditions that are hard to reach, and one that cannot be true."""
    count = jnp.where(jnp.isfinite(measured), 0, memory + 1)
    torque = gains.gain * measured
    # no value of the test run and no special value is between these
    narrow = (torque > THRESHOLD) & (torque < THRESHOLD + 1e-3)
    late = (count > 2) & (torque != torque)
    never = (measured > 1.0) & (measured < 0.5)
    limited = jnp.clip(torque, -gains.limit, gains.limit)
    torque = jnp.where(narrow | late, 0.0, limited)
    offset = jnp.where(never, 1.0, 0.0)
    return count, torque + offset


@pytest.fixture(scope="module")
def target():
    return flight_module(
        "law",
        {"gains": Gains(0.3, 0.05)},
        {"memory": jnp.asarray(0)},
        [("start", begin, ("memory",))],
        [("step", law, ("memory", "torque"))],
        title="A law",
        period=0.1,
        constants={},
        inputs={"measured": np.linspace(-0.1, 0.1, STEPS)},
    )


def begin():
    """Set the state."""
    return jnp.asarray(0)


@pytest.fixture(scope="module")
def found(target):
    return find_vectors(target, emitted(target, "double"), "double")


def open_gaps(found):
    """Condition and what is not shown of it."""
    return {
        (each.decision.conditions[gap.condition], gap.want)
        for each in found.coverage.decisions
        for gap in gaps(each)
    }


def test_the_search_reaches_all_but_what_cannot_be(found):
    missing = open_gaps(found)
    assert {want for _, want in missing} == {"true", "alone"}
    # the second condition of `never` and the choice that it makes
    assert ("measured < 0.5", "true") in missing
    assert all("never" in text or "measured <" in text or "> 1.0" in text for text, _ in missing)


def test_without_a_search_the_narrow_conditions_are_missing(target):
    idle = find_vectors(target, emitted(target, "double"), "double", most=0.0)
    limits = {text.partition("< ")[2] for text, _ in open_gaps(idle)}
    assert repr(THRESHOLD + 1e-3) in limits


def of_mode(gains, number, measured):
    """A torque of a table, for the first two of three modes."""
    torques = jnp.stack([gains.gain, gains.limit, measured])
    index = number.astype(jnp.int32)
    torque = jax.lax.cond(number < 2, lambda: torques[index], lambda: measured)
    return number + 1, torque


def test_an_index_that_narrows_to_a_large_one_is_found():
    modes = flight_module(
        "modes",
        {"gains": Gains(0.3, 0.05)},
        {"number": jnp.asarray(0)},
        [("start", begin, ("number",))],
        [("step", of_mode, ("number", "torque"))],
        title="A law of modes",
        period=0.1,
        constants={},
        inputs={"measured": np.linspace(-0.1, 0.1, STEPS)},
    )
    found = find_vectors(modes, emitted(modes, "double"), "double")
    conditions = {text for each in found.coverage.decisions for text in each.decision.conditions}
    assert any(text.endswith("> 2") for text in conditions)  # the index is limited to the table
    assert open_gaps(found) == set()


class Locks(NamedTuple):
    """Parameters of three locks, each with a number, a key and a code."""

    number: np.ndarray
    key: np.ndarray
    code: np.ndarray


def opened(number, key, code):
    """Number that says whether a lock is open; few have the same."""
    return (number * 48271 + key * 69621 + code * 40692) % 2147483647


def locks(locks, memory, measured):
    """Torques of locks that are open."""
    is_open = opened(*(each.astype(jnp.int64) for each in locks)) == opened(1234567, 7654, 89)
    return memory, jnp.where(is_open, measured, 0.0)


def test_what_one_element_shows_is_found_for_the_others():
    target = flight_module(
        "locks",
        {"locks": Locks(*np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]))},
        {"memory": jnp.asarray(0)},
        [("start", begin, ("memory",))],
        [("step", locks, ("memory", "torque"))],
        title="Locks",
        period=0.1,
        constants={},
        inputs={"measured": np.linspace(-0.1, 0.1, STEPS)},
    )
    case = {"locks.number[1]": 1234567.0, "locks.key[1]": 7654.0, "locks.code[1]": 89.0}
    target = dataclasses.replace(target, cases=(case,))
    assert open_gaps(find_vectors(target, emitted(target, "double"), "double")) == set()


def test_the_rows_show_what_the_coverage_says(found):
    """Each condition in Python, from the values of the rows alone."""
    vectors = found.vectors
    place = {field.name: k for k, field in enumerate(vectors.fields)}
    gain, shown = 0.3, set()
    for row in vectors.rows:
        gain = 0.3 if row.begins else gain
        gain = row.changes.get(place["gains.gain"], gain)
        torque = gain * row.changes[place["measured"]]
        shown.add((torque > THRESHOLD, torque < THRESHOLD + 1e-3))
    assert {(True, True), (True, False), (False, True)} <= shown
    assert vectors.rows[0].begins
    assert len(vectors.rows) > STEPS


def test_the_same_code_gives_the_same_vectors(target, found):
    again = find_vectors(target, emitted(target, "double"), "double")
    assert again.vectors.csv() == found.vectors.csv()


def test_the_csv_has_the_rows(found):
    vectors = found.vectors
    head, *lines = csv.reader(io.StringIO(vectors.csv()))
    assert head[:2] == ["row", "begins"]
    names = [field.name for field in vectors.fields]
    assert [names.index(name) for name in head[2:]] == sorted(map(names.index, head[2:]))
    for number, (line, row) in enumerate(zip(lines, vectors.rows, strict=True)):
        assert line[:2] == [str(number), str(int(row.begins))]
        cells = {
            names.index(name): float(cell)
            for name, cell in zip(head[2:], line[2:], strict=True)
            if cell
        }
        assert cells.keys() == row.changes.keys()
        assert all(
            value == cells[k] or (np.isnan(value) and np.isnan(cells[k]))
            for k, value in row.changes.items()
        )


@pytest.fixture
def folder(target, tmp_path):
    """Write the flight folder, with a search or without; run a kind of its evidence."""

    def write(search):
        write_texts(tmp_path, files(target, "double", "", search))
        return tmp_path

    return write


def outcome(folder):
    subprocess.run(["sh", folder / "evidence" / "run.sh", "coverage"], capture_output=True)
    return next(result for result in read_results(folder) if result.name == "coverage")


def need_clang():
    if missing := [tool for tool in COVERAGE_TOOLS if shutil.which(tool) is None]:
        pytest.skip(f"{', '.join(missing)} not installed")


def test_a_folder_without_a_search_says_so(folder):
    need_clang()
    result = outcome(folder(None))
    assert result.outcome == "not run"
    assert "--evidence" in result.reason


def test_clang_agrees_on_what_is_not_shown(folder, found):
    need_clang()
    messages = []
    out = folder(Search(messages.append))
    result = outcome(out)
    assert "conditions" in messages[0]
    assert result.outcome == "failed"
    assert result.reason.startswith("not shown: ")
    assert "Not covered" in (out / "README.md").read_text(encoding="utf-8")
    ours = {
        f"branch {gap.at} {gap.want}" if gap.want != "alone" else f"condition {gap.at}"
        for each in found.coverage.decisions
        for gap in gaps(each)
        if gap.want != "alone" or each.decision.size > 1
    }
    script = (out / "evidence" / "coverage.sh").read_text(encoding="utf-8")
    (out / "evidence" / "coverage.sh").write_text(
        script.replace("set -- ", 'cp "$work/missing" missing.txt\nset -- ', 1), encoding="utf-8"
    )
    outcome(out)
    theirs = (out / "evidence" / "missing.txt").read_text(encoding="utf-8").splitlines()
    assert {line for line in theirs if not line.startswith("line")} == ours


def reasons(found, *, is_sure):
    """A reason for everything that is not shown."""
    return tuple(
        Justification(
            *each.decision.source.split(":")[:1],
            each.decision.source.split(": ", 1)[1],
            gap.condition,
            (gap.want,),
            ("law",),
            "It is so.",
            is_sure,
        )
        for each in found.coverage.decisions
        for gap in gaps(each)
    )


def test_a_justification_is_checked(folder, found):
    """With a reason for every gap the evidence passes; one for something shown makes it fail."""
    need_clang()
    out = folder(Search(print, Reasons("", reasons(found, is_sure=True))))
    result = outcome(out)
    assert (result.outcome, result.reason) == ("passed", "")
    reached = next(d.decision for d in found.coverage.decisions if d.is_complete)
    with (out / "evidence" / "coverage" / "justified.txt").open("a", encoding="utf-8") as file:
        file.write(f"branch {reached.positions[0]} true\tIt is not so.\n")
    result = outcome(out)
    assert result.outcome == "failed"
    assert result.reason.startswith("justified, but shown: ")


def test_reasons_that_a_review_must_confirm_are_counted(folder, found):
    need_clang()
    out = folder(Search(print, Reasons("", reasons(found, is_sure=False))))
    result = outcome(out)
    figures = {figure.name: int(figure.value) for figure in result.figures}
    assert result.outcome == "passed"
    assert figures["justified"] == 0
    wanted = {(gap.at, gap.want) for each in found.coverage.decisions for gap in gaps(each)}
    assert figures["justified, to be confirmed by a review"] == len(wanted)
    readme = (out / "README.md").read_text(encoding="utf-8")
    assert readme.count("It is so.") == len(wanted)


def test_a_decision_that_clang_does_not_count_is_noticed(folder):
    need_clang()
    out = folder(Search(print))
    script = out / "evidence" / "coverage.sh"
    text = script.read_text(encoding="utf-8")
    changed = re.sub(r"= (\d+) \]", lambda number: f"= {int(number[1]) + 2} ]", text)
    assert changed != text
    script.write_text(changed, encoding="utf-8")
    assert "conditions (MC/DC), expected" in outcome(out).reason


def test_code_that_cannot_be_read_has_no_coverage(folder, monkeypatch):
    """Its vectors are the test run, and the evidence says why."""
    need_clang()

    def read(text):
        return functions(text.replace("return 0;", "goto end;"))

    monkeypatch.setattr(machine, "functions", read)
    messages = []
    out = folder(Search(messages.append))
    result = outcome(out)
    assert result.outcome == "not run"
    assert "cannot be read back" in result.reason
    assert messages == [result.reason]
    assert len((out / "vectors.csv").read_text(encoding="utf-8").splitlines()) == STEPS + 1


@pytest.mark.parametrize(
    "text", ["x = remainder(x, 2.0);", "while (x > 1.0) { x = 0.0; }", "x @ 1;"]
)
def test_other_c_is_refused(text):
    whole = f"static double f(double x)\n{{\n    {text}\n    return x;\n}}\n"
    with pytest.raises(UnreadableError, match="found"):
        translate(functions(whole), [], has_margins=False)


def test_vectors_that_show_less_are_seen(folder, found):
    need_clang()
    out = folder(Search(print))
    vectors = out / "law_vectors.h"
    text = vectors.read_text(encoding="utf-8")
    rows = len(found.vectors.rows)
    assert f"VECTOR_ROWS = {rows}" in text
    before = {f.name: f.value for f in outcome(out).figures}
    program = (out / "law_test.c").read_text(encoding="utf-8")
    cut = program.replace("k < VECTOR_ROWS", f"k < {STEPS}")
    assert cut != program
    (out / "law_test.c").write_text(cut, encoding="utf-8")
    after = {f.name: f.value for f in outcome(out).figures}
    name = "conditions not shown (MC/DC)"
    assert int(after[name]) > int(before[name])
