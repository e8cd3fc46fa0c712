"""Results of evidence as Markdown, for the README of the flight folder."""

from collections.abc import Iterable, Sequence

from gyrostat.exports.evidence.pivot import pivots
from gyrostat.exports.evidence.results import Result


def results_text(results: Iterable[Result]) -> str:
    """Section with the outcome, the figures and the tools of each result."""
    lines = ["### Results", "", "| evidence | outcome |", "|---|---|"]
    results = tuple(results)
    for result in results:
        reason = f": {result.reason}" if result.reason else ""
        lines.append(f"| `{result.name}`: {result.title} | {result.outcome}{reason} |")
    for result in results:
        if result.figures:
            lines += ["", f"#### {result.title}", *_figures(result)]
        if result.tools:
            lines += ["", f"Tools: {'; '.join(result.tools)}."]
    return "\n".join([*lines, ""])


def _figures(result: Result) -> Iterable[str]:
    tables, others = pivots(result.figures)
    for each in tables:
        yield from _table(
            (each.title, *each.columns), [(row, *values) for row, values in each.rows]
        )
    if others:
        rows = [(figure.name, f"{figure.value} {figure.unit}".strip()) for figure in others]
        yield from _table(("figure", "value"), rows)


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterable[str]:
    yield ""
    yield f"| {' | '.join(header)} |"
    yield f"|---|{'---:|' * (len(header) - 1)}"
    yield from (f"| {' | '.join(row)} |" for row in rows)
