"""What test vectors show, for reports."""

from collections.abc import Iterator

from gyrostat.codegen.flight.reader.decisions import independent
from gyrostat.exports.target import STEPS
from gyrostat.exports.vectors.coverage import DecisionCoverage
from gyrostat.exports.vectors.find import Found
from gyrostat.exports.vectors.justifications import Gap, gaps

HEAD = (
    *("at", "function", "decision", "condition", "text", "true_row", "false_row"),
    *("alone_rows", "justified", "source"),
)


def condition_rows(found: Found) -> Iterator[tuple[str, ...]]:
    """Table of all conditions, with a head.

    A row has the position in C, the function, the kind of decision, the number of the condition in
    it, its text, the first rows of the vectors in which it is true and false and the rows that show
    that it acts alone, the reason if something cannot be shown, and the line of Python.
    """
    every = (gap for each in found.coverage.decisions for gap in gaps(each))
    possible = found.possible
    confirm = {gap: f"To be confirmed: {possible[gap]}" for gap in every if gap in possible}
    reasons = {**found.reasons, **confirm}
    yield HEAD
    for each in found.coverage.decisions:
        yield from _rows(each, reasons)


def _rows(coverage: DecisionCoverage, reasons: dict[Gap, str]) -> Iterator[tuple[str, ...]]:
    decision, seen = coverage.decision, coverage.seen
    outcomes = list(seen)
    pairs = independent(decision, outcomes)
    for k, (text, at) in enumerate(zip(decision.conditions, decision.positions, strict=True)):
        first = {
            state: min((row for (states, _), row in seen.items() if states[k] == state), default="")
            for state in "TF"
        }
        alone = " ".join(str(seen[outcomes[o]]) for o in pairs[k]) if k in pairs else ""
        found = {
            r: None for gap, r in reasons.items() if (gap.decision, gap.at) == (decision.number, at)
        }
        yield (
            *(str(at), decision.function, decision.kind, str(k + 1), text),
            *(str(first["T"]), str(first["F"]), alone, " ".join(found), decision.origin),
        )


def shown(found: Found) -> list[str]:
    """Lines of Markdown: how much the vectors show, by which means, and what they do not show."""
    every = found.coverage.decisions
    conditions = sum(each.decision.size for each in every)
    reasons, possible = found.reasons, found.possible
    open_gaps = [gap for each in every for gap in gaps(each) if gap not in reasons]
    confirm = [gap for gap in open_gaps if gap in possible]
    open_gaps = [gap for gap in open_gaps if gap not in possible]
    missing = sum(len(each.missing()) for each in every)
    vectors = found.vectors
    roles = {vectors.fields[k].role for row in vectors.rows for k in row.changes} - {"input"}
    means = {"parameter": "parameters", "constant": "constants", "state": "the state"}
    changed = [text for role, text in means.items() if role in roles]
    lines = [
        f"{len(every)} decisions with {conditions} conditions (`if`, `?:`, loop tests, `&&` and "
        "`||`; listed in `evidence/coverage/conditions.csv`). "
        f"The {len(vectors.rows)} steps of the vectors, of which the first {STEPS} are the test "
        f"run, show {conditions - missing} conditions: true, false, and deciding alone.",
    ]
    if changed:
        lines.append(
            f"Some steps change {', '.join(changed)}, which are arguments of the functions: "
            "conditions that no measurement reaches are shown so."
        )
    if reasons:
        lines.append(f"Justified, since it cannot be shown: {len(reasons)} values of conditions.")
    if confirm:
        lines += ["", "Not shown, and impossible if a review confirms the reason:", ""]
        lines += [f"- line {gap.at}: {_words(gap, found)}. {possible[gap]}" for gap in confirm]
    if open_gaps:
        lines += ["", "Not covered:", ""]
        lines += [f"- line {gap.at}: {_words(gap, found)}" for gap in open_gaps]
    return lines


def _words(gap: Gap, found: Found) -> str:
    text = found.coverage.decisions[gap.decision].decision.conditions[gap.condition]
    words = {"true": "is never true", "false": "is never false", "alone": "never decides alone"}
    return f"`{text}` {words[gap.want]}"
