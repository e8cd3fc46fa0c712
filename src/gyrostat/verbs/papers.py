"""Verb `reproduce`: reproduce a paper and test its claims."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

from gyrostat.verbs.arguments import Say, figure_names, opener_of, silent

if TYPE_CHECKING:
    from gyrostat.papers import Reproduction


def reproduce(
    paper: str,
    out: "str | Path | None" = None,
    *,
    quick: bool = False,
    scheduler: str | None = None,
    force: bool = False,
    figures: str | None = None,
    say: Say = silent,
    command: str = "gyrostat.reproduce",
) -> "Reproduction":
    """Reproduce a paper's experiments and test each of its claims.

    Args:
        paper: "carrara-kuga", "moreira-lopes-kuga", "carvalho-fenili",
            "endo-sekiguchi-nonaka" or "ecss-e-st-60-10c".
        out: Folder for claims.json and report.html; None writes no file.
        quick: Whether to use fewer seeds.
        scheduler: Address of a Dask scheduler, whose workers run one experiment each.
        force: Whether to replace files that gyrostat did not write.
        figures: "pdf", "svg" or "png": write the figures for papers too; None: none.
        say: Function that receives each message for the user.
        command: Text that the page names as its origin.

    Raises:
        InputError: The paper is unknown, or existing files would be replaced.
    """
    from gyrostat.core.outputs import check_outputs, new_files
    from gyrostat.papers import paper_named

    experiment = paper_named(paper)
    figure_names(figures)
    if out is not None:
        check_outputs(Path(out), ("claims.json", "report.html"), by="reproduce", force=force)
    result = experiment.reproduce(quick=quick, say=say, opener=opener_of(scheduler, say))
    if out is not None:
        text = json.dumps(result.to_dict(), indent=1, ensure_ascii=False, allow_nan=False)
        page = result.page(command=command)
        with new_files(Path(out), by="reproduce", force=force) as folder:
            (folder / "report.html").write_text(page, encoding="utf-8")
            (folder / "claims.json").write_text(text + "\n", encoding="utf-8")
        if figures:
            from gyrostat.reports.paper_figures import write_figures

            drawn = {f"figure_{k}": d.figure for k, d in enumerate(result.drawings, 1)}
            write_figures(drawn, Path(out), figures, by="reproduce", say=say, force=force)
    for line in result.lines():
        say(line)
    return result
