"""Pointing requirements as text."""

import math

from gyrostat.campaigns.pointing.verdicts import runs_needed
from gyrostat.core.text import plain
from gyrostat.scenario.requirement import Requirement
from gyrostat.scenario.scenario import Scenario

ARCSECOND = math.pi / 648_000.0
SMALL = math.radians(0.1) * (1.0 - 1e-9)
"""Required angle below which angles are in arcseconds; less the rounding of a value in degrees."""


def angle_text(value: float | None, like: float, digits: int = 4) -> str:
    """Angle in degrees, or in arcseconds if the required angle `like` is below 0.1 deg."""
    if value is None or not math.isfinite(value):
        return "none"
    if like < SMALL:
        return f"{plain(value / ARCSECOND, digits)} arcsec"
    return f"{plain(math.degrees(value), digits)} deg"


def requirement_text(each: Requirement) -> str:
    """Requirement as a sentence."""
    parts = [f"{each.index} at most {angle_text(each.value, each.value, 6)}"]
    where = {"half_cone": "half cone of the boresight", "about": "about the boresight"}
    where["full"] = "full attitude error"
    parts.append(where.get(each.axis, f"axis {each.axis}"))
    if each.window > 0.0:
        parts.append(f"window {each.window:g} s")
    if each.operation == "relative":
        instants = {"any": "anywhere in", "end": "at the end of", "centre": "in the middle of"}
        parts.append(f"t {instants[each.instant]} the window")
    if each.stability > 0.0:
        parts.append(f"stability time {each.stability:g} s")
    if each.during:
        parts.append(f"during {', '.join(each.during)}")
    level = f"{100.0 * each.level:.12g} %"
    of_runs = f"{100.0 * each.share:.12g} % of the runs"
    interpretations = {
        "temporal": f"{level} of the time in {of_runs} (temporal)",
        "ensemble": f"at all times in {level} of the runs (ensemble)",
        "mixed": f"{level} of time and runs together (mixed)",
    }
    return "; ".join([*parts, interpretations[each.interpretation]])


def is_of_error(each: Requirement, scenario: Scenario) -> bool:
    """Whether the index of a requirement is the pointing error of the whole run."""
    axis = "full" if scenario.boresight is None else "half_cone"
    matches = each.boresight == scenario.boresight and not each.during
    return each.index == "APE" and each.axis == axis and matches


def requirement_lines(scenario: Scenario, runs: int | None = None) -> list[str]:
    """Requirements of a scenario as lines, with the number of runs that each needs.

    Args:
        scenario: Scenario.
        runs: Number of runs; only requirements that need more are listed. None: all.
    """
    lines = []
    for each in scenario.requirements:
        needed = runs_needed(each)
        if runs is None:
            text = requirement_text(each)
            lines.append(f"requirement {each.name}: {text}; needs {needed} runs or more")
        elif runs < needed:
            lines.append(
                f"requirement {each.name}: {runs} runs cannot show it, {needed} are needed"
            )
    return lines
