"""Page of the evidence about flight code."""

from typing import Any

from gyrostat.reports.template import render

CREDIBILITY = (
    (
        "Data pedigree",
        "the digest of the model or scenario; its file names the source of the values",
    ),
    ("Verification", None),
    ("Validation", "not of the code: `gyrostat validate` compares a wheel with records"),
    ("Input pedigree", "the digests and the command at the top of this page"),
    (
        "Uncertainty characterization",
        "not of the code: a campaign of the scenario disperses its values",
    ),
    ("Results robustness", "not of the code: a search of the scenario finds the worst case"),
    ("M&S history", "not recorded here"),
    (
        "M&S process and product management",
        "version and digest of the generator; the same inputs give the same code, byte by byte",
    ),
)
"""Credibility factor of NASA-STD-7009B -> where it is shown; None: the results of the page."""


def evidence_page(content: Any, *, command: str) -> str:
    """HTML page of the evidence about a flight folder.

    Args:
        content: Content of the folder, a `gyrostat.exports.evidence.content.Content`.
        command: Command line that made the folder.
    """
    executed = [count for each in content.trace for _, _, count in each.groups]
    return render(
        "evidence.html",
        content=content,
        command=command,
        credibility=CREDIBILITY,
        groups=len(executed),
        missed=sum(count == 0 for count in executed),
        known=bool(executed) and None not in executed,
        lines={group.first for each in content.trace for group, _, _ in each.groups},
    )
