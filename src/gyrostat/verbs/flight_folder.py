"""Evidence of a flight folder: its results, its page, and their part of the README."""

import shutil
from collections.abc import Iterable
from pathlib import Path, PurePath

from gyrostat.verbs.arguments import Say

PAGE = "evidence.html"
CHECK = "expected.txt"
"""File that only the flight folder has."""


def flight_folder(names: Iterable[str]) -> PurePath:
    """Folder of the flight module among the files of an export, relative to them."""
    return next((path.parent for path in map(PurePath, names) if path.name == CHECK), PurePath())


def complete(
    scratch: Path, folder: Path, *, evidence: bool, command: str, say: Say
) -> dict[str, str]:
    """Add the page of evidence to a flight folder, and its results to the README.

    Args:
        scratch: Folder with the files of the export.
        folder: Folder in which they will be, with results of an earlier run.
        evidence: Whether to run the evidence.
        command: Command that the page names.
        say: Function that receives the outcome of each kind of evidence.

    Returns:
        Files of the results, which are no longer in `scratch`: `make evidence` replaces them later.
    """
    from gyrostat.exports import DIFFERS, read_content, read_results, results_text, run_evidence
    from gyrostat.reports import evidence_page

    for line in (scratch / "README.md").read_text(encoding="utf-8").splitlines():
        if line.startswith(DIFFERS):
            say(f"warning: {line}")
    results, earlier = scratch / "evidence" / "results", folder / "evidence" / "results"
    if evidence:
        for result in run_evidence(scratch):
            say(str(result))
    elif earlier.is_dir():
        shutil.copytree(earlier, results)
    page = evidence_page(read_content(scratch), command=command)
    (scratch / PAGE).write_text(page, encoding="utf-8")
    if not results.is_dir():
        return {}
    with (scratch / "README.md").open("a", encoding="utf-8") as readme:
        readme.write(f"\n{results_text(read_results(scratch))}")
    texts = {
        path.relative_to(scratch).as_posix(): path.read_text(encoding="utf-8", errors="replace")
        for path in sorted(results.iterdir())
    }
    shutil.rmtree(results)
    return texts
