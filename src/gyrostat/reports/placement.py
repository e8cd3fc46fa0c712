"""Files of the directions that `place` finds."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from gyrostat.core.outputs import new_files
from gyrostat.reports.body_sky_map import body_sky_chart
from gyrostat.reports.template import render
from gyrostat.runs.placement_result import Placement

FILES = ("place.json", "report.html")


def write_placement(
    result: Placement,
    out: Path,
    *,
    command: str,
    say: Callable[[str], None],
    force: bool = False,
) -> None:
    """Write place.json and report.html, and print a summary.

    Args:
        result: The result.
        out: Output folder.
        command: Command line that produced it.
        say: Called with each line of the summary.
        force: Whether to replace files that `place` did not write; see `gyrostat.core.outputs`.

    Raises:
        InputError: A file of the user is in the way, or the folder cannot be written.
    """
    text = json.dumps(result.content(), indent=1, ensure_ascii=False, allow_nan=False)
    exclusion, (chart, legend) = result.exclusion, body_sky_chart(result)
    page = render(
        "placement.html",
        result=result,
        chart=chart,
        legend=legend,
        exclusion=[
            (name, f"{np.degrees(value):.4g}°")
            for name, value in (
                ("Sun", exclusion.sun),
                ("limb of the Earth", exclusion.earth),
                ("Moon", exclusion.moon),
                ("angle between two heads", result.apart),
            )
        ],
        command=command,
    )
    with new_files(out, by="place", force=force) as folder:
        (folder / "report.html").write_text(page, encoding="utf-8")
        (folder / "place.json").write_text(text + "\n", encoding="utf-8")
    for line in result.lines():
        say(line)
    say(f"written: {out / 'report.html'}, {out / 'place.json'}")
