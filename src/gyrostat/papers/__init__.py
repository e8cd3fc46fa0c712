"""Reproduction of published papers with the public interface, with a verdict on each claim."""

import difflib

from gyrostat.core.errors import InputError
from gyrostat.papers.carrara_kuga import CARRARA_KUGA
from gyrostat.papers.carvalho_fenili import CARVALHO_FENILI
from gyrostat.papers.claims import Claim, Row, Verdict
from gyrostat.papers.ecss_control_performance import ECSS_CONTROL_PERFORMANCE
from gyrostat.papers.endo_sekiguchi_nonaka import ENDO_SEKIGUCHI_NONAKA
from gyrostat.papers.figures import Drawing
from gyrostat.papers.moreira_lopes_kuga import MOREIRA_LOPES_KUGA
from gyrostat.papers.reproduction import Paper, Part, Reproduction, Run

PAPERS: dict[str, Paper] = {
    paper.name: paper
    for paper in (
        CARRARA_KUGA,
        MOREIRA_LOPES_KUGA,
        CARVALHO_FENILI,
        ENDO_SEKIGUCHI_NONAKA,
        ECSS_CONTROL_PERFORMANCE,
    )
}
"""Papers that can be reproduced, by name."""


def paper_named(name: str) -> Paper:
    """Find a paper by its name.

    Raises:
        InputError: No paper that can be reproduced has this name.
    """
    if name in PAPERS:
        return PAPERS[name]
    near = difflib.get_close_matches(name.strip().casefold().replace("_", "-"), PAPERS, n=1)
    hint = f" (did you mean {near[0]}?)" if near else ""
    raise InputError(f"paper: found {name!r}{hint}, expected one of {', '.join(PAPERS)}")


__all__ = [
    "PAPERS",
    "Claim",
    "Drawing",
    "Paper",
    "Part",
    "Reproduction",
    "Row",
    "Run",
    "Verdict",
    "paper_named",
]
