"""Motion of the line of sight as text, as JSON, and as sections of a scenario."""

from typing import Any

import numpy as np

from gyrostat.core.text import plain
from gyrostat.core.unit_table import RPM
from gyrostat.microvibration.sight import WEIGHTS, LineOfSight

ARCSEC = np.pi / 180.0 / 3600.0


def bands_text(result: LineOfSight) -> str:
    """Sections [[controller.band]] of a scenario with the speeds to avoid."""
    low, high = (plain(end / RPM) for end in result.speed[[0, -1]])
    above = "in a band" if result.most is not None else "in no band"
    lines = [
        "# Wheel speeds at which the line of sight moves by more than the limit.",
        f"# Computed for {low} to {high} rpm. Slower wheels count as at {low} rpm;",
        f"# nothing is known of faster ones, which are {above}.",
    ]
    for k, (low, high) in enumerate(result.bands(), 1):
        lines += ["", "[[controller.band]]", f'name = "jitter_{k}"']
        lines += [f'above = "{low / RPM:.6g} rpm"', f'below = "{high / RPM:.6g} rpm"']
    return "\n".join(lines) + "\n"


def text_lines(result: LineOfSight, detail: float | None = None) -> list[str]:
    """The result as lines for a terminal.

    Args:
        result: Motion of the line of sight.
        detail: Spatial frequency of the MTF, cycles/rad; None for no MTF.
    """
    rms = result.rms()
    lines = [f"exposure {plain(result.exposure)} s, smear and jitter of both axes, rms"]
    for wheel, row in zip(result.wheels, rms, strict=True):
        k = int(np.argmax(row))
        middle = float(np.median(row))
        lines.append(
            f"  {wheel.name}: at most {plain(row[k] / ARCSEC)} arcsec, at "
            f"{plain(result.speed[k] / RPM)} rpm; median {plain(middle / ARCSEC)} arcsec"
        )
        if wheel.outside.any():
            share = 100.0 * float(np.mean(wheel.outside))
            lines.append(
                f"    warning: {share:.0f} % of the lines are outside the frequencies of the "
                "transfer and count as none"
            )
    if detail is not None:
        value = plain(_worst_mtf(result, detail))
        lines.append(
            f"MTF at {plain(detail)} cycles/rad: {value}, each wheel at its worst speed and sense"
        )
    if result.limit is not None:
        bands = result.bands()
        word = "band" if len(bands) == 1 else "bands"
        limit = plain(result.limit / ARCSEC)
        lines.append(f"limit {limit} arcsec: {len(bands)} {word} to avoid")
        lines += [f"  {plain(low / RPM)} to {plain(high / RPM)} rpm" for low, high in bands]
    return lines


def _worst_mtf(result: LineOfSight, detail: float) -> float:
    """Smallest MTF about the two axes with each wheel at its worst speed and sense of rotation."""
    return min(float(result.mtf(np.array([detail]), result.worst(), axis)[0]) for axis in (0, 1))


def content(result: LineOfSight, detail: float | None = None) -> dict[str, Any]:
    """Content of jitter.json, SI units; see `text_lines`.

    Values of wheels are those of the sense of rotation in which they are larger.
    """
    return {
        "exposure": result.exposure,
        "limit": result.limit,
        "bands": [list(band) for band in result.bands()],
        "detail": detail,
        "mtf": None if detail is None else _worst_mtf(result, detail),
        "speed": result.speed.tolist(),
        "wheels": {
            wheel.name: {name: result.rms(name)[k].tolist() for name in WEIGHTS}
            for k, wheel in enumerate(result.wheels)
        },
    }
