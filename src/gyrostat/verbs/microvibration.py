"""Verbs `waterfall` and `jitter`: loads of a wheel, and the line of sight that they move."""

from pathlib import Path
from typing import TYPE_CHECKING

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Say, silent

if TYPE_CHECKING:
    from gyrostat.microvibration.result import WaterfallFit
    from gyrostat.microvibration.sight import LineOfSight
    from gyrostat.microvibration.waterfall import Waterfall

MOST_SPEEDS = 1_000_000


def waterfall(
    record: "Waterfall | str | Path",
    out: "str | Path | None" = None,
    *,
    quantity: str = "density",
    window: str = "hann",
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.waterfall",
) -> "WaterfallFit":
    """Find the harmonics, structural modes and noise of a wheel in a measured waterfall.

    Args:
        record: Path of the file, .csv, .h5 or .uff; or a waterfall.
        out: Folder for disturbance.json, disturbance.toml (for `jitter`) and waterfall.html; None
            writes no file.
        quantity: What the numbers of the file are: "density" (one-sided), "amplitude" or "rms".
        window: Window of the spectra, a name of `scipy.signal.get_window`.
        force: Whether to replace files that gyrostat did not write.
        say: Function that receives each message for the user.
        command: Text that the page names as its origin.

    Returns:
        Estimates with sigma and 95 % intervals; `valid` and `reasons` say whether they can be used.

    Raises:
        InputError: The file cannot be read or used, or existing files would be replaced.
    """
    from gyrostat.core.outputs import check_outputs
    from gyrostat.microvibration.fit import fit_waterfall
    from gyrostat.microvibration.waterfall_file import read_waterfall
    from gyrostat.reports.microvibration import WATERFALL_FILES, write_waterfall

    if out is not None:
        check_outputs(Path(out), WATERFALL_FILES, by="waterfall", force=force)
    data = read_waterfall(record, quantity, window) if isinstance(record, str | Path) else record
    result = fit_waterfall(data)
    for line in result.lines():
        say(line)
    if out is not None:
        write_waterfall(result, Path(out), command=command, say=say, force=force)
    return result


def jitter(
    structure: "str | Path",
    out: "str | Path | None" = None,
    *,
    count: int = 10_000,
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.jitter",
) -> "LineOfSight":
    """Compute smear and jitter of the line of sight over wheel speed, and the speeds to avoid.

    Args:
        structure: File of wheels on a structure: loads of the wheels, transfer to the line of
            sight, exposure, limit and speeds.
        out: Folder for jitter.json, bands.toml (sections of a scenario) and jitter.html; None
            writes no file.
        count: Number of speeds.
        force: Whether to replace files that gyrostat did not write.
        say: Function that receives each message for the user.
        command: Text that the page names as its origin.

    Returns:
        Motion of the line of sight; `rms()`, `bands()` and `mtf()` evaluate it.

    Raises:
        InputError: A file cannot be read or used, or existing files would be replaced.
    """
    import numpy as np

    from gyrostat.core.outputs import check_outputs
    from gyrostat.microvibration.disturbance_file import read_structure
    from gyrostat.microvibration.sight import line_of_sight
    from gyrostat.microvibration.sight_text import text_lines
    from gyrostat.reports.microvibration import SIGHT_FILES, write_sight

    if out is not None:
        check_outputs(Path(out), SIGHT_FILES, by="jitter", force=force)
    if not 2 <= count <= MOST_SPEEDS:
        raise InputError(f"--count: found {count}, expected 2 to {MOST_SPEEDS}")
    given = read_structure(Path(structure))
    speed = np.linspace(*given.speeds, count)
    result = line_of_sight(given.wheels, given.transfer, speed, given.exposure, given.limit)
    for line in text_lines(result, given.detail):
        say(line)
    if out is not None:
        write_sight(result, given.detail, Path(out), command=command, say=say, force=force)
    return result
