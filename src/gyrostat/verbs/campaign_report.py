"""Verb `report`: the report of a finished campaign, and the check of its requirements."""

import json
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Say, figure_names, silent


def report(
    folder: "str | Path",
    *,
    check: bool = False,
    fly: bool = False,
    figures: str | None = None,
    say: Say = silent,
    command: str = "gyrostat.report",
) -> "dict[str, Any]":
    """Write report.html and report.json of a finished campaign into its folder.

    Args:
        folder: Folder of a finished campaign, or its address as for `campaign`.
        check: Whether the pointing requirements are to be checked: the command line then ends with
            exit code 1 unless all are met.
        fly: Whether to write fly.html too: the nominal run, the worst and the first runs, with the
            compiled program, to fly them again with other values.
        figures: "pdf", "svg" or "png": write the figures for papers too; None: none.
        say: Function that receives each message for the user.
        command: Text that the page names as its origin.

    Returns:
        The content of report.json, SI units. `requirements` has the verdict on each requirement.

    Raises:
        InputError: There is no finished campaign, the folder cannot be written, or there are no
            requirements to check.
    """
    from gyrostat.core.remote_folder import local_folder
    from gyrostat.reports.campaign import write_campaign

    figure_names(figures)
    with local_folder(folder, say, "FOLDER") as (copy, tell):
        text = write_campaign(
            copy, command=command, say=tell, address=str(folder), fly=fly, figures=figures
        )
    content = json.loads(text)
    if check and not content.get("requirements"):
        kind = "a scenario without [[requirement]]" if "requirements" in content else "a search"
        raise InputError(f"{folder}: found {kind}, expected a campaign with [[requirement]]")
    return content
