"""Passes over ground stations and eclipses of the nominal run."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from gyrostat.control.guidance import Sunlight
from gyrostat.core.jax64 import jax
from gyrostat.core.text import plain, shortened
from gyrostat.core.types import Vector
from gyrostat.runs.build_parts import named_parts
from gyrostat.scenario.component import Context
from gyrostat.scenario.kinds.orbits import nominal_orbit
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.structure import structure_of
from gyrostat.telemetry.signals import runs

STEP = 10.0
"""Time between the samples from which passes are found, s; shorter ones can be missed."""
MOST_LISTED = 8
"""Largest number of passes or eclipses in a line."""
HALVINGS = 24
"""Halvings of an interval of `STEP` that contains a begin or an end."""


class Pass(NamedTuple):
    """Pass over a ground station, or an eclipse.

    Attributes:
        name: Name of the station, or "eclipse".
        begin: Begin, or start of the run, s.
        end: End, or end of the run, s.
        highest: Highest elevation, rad; None for an eclipse.
    """

    name: str
    begin: float
    end: float
    highest: float | None = None


def passes_of(scenario: Scenario) -> list[Pass]:
    """Passes over the stations and eclipses of the nominal run, by name and in order of time.

    Args:
        scenario: Scenario; without an orbit there are none.
    """
    orbit = nominal_orbit(scenario)
    if orbit is None:
        return []
    time = np.linspace(0.0, scenario.duration, int(np.ceil(scenario.duration / STEP)) + 2)
    context = Context(orbit=orbit)
    stations = named_parts(structure_of(scenario), scenario.values, "station", context)
    found = []
    for name, view in stations.items():
        elevation = jax.jit(jax.vmap(view.elevation))
        for begin, end in _intervals(jax.jit(jax.vmap(view)), time):
            highest = np.max(elevation(np.linspace(begin, end, 200)))
            found.append(Pass(name, begin, end, float(highest)))
    sun = Sunlight(orbit)
    dark = _intervals(jax.jit(jax.vmap(lambda time: -sun(time))), time)
    return [*found, *(Pass("eclipse", *interval) for interval in dark)]


def pass_lines(scenario: Scenario, found: list[Pass]) -> list[str]:
    """Line on the passes over each station, and on the eclipses.

    Args:
        scenario: Scenario.
        found: Result of `passes_of`.
    """
    lines = []
    for part in (part for part in scenario.parts if part.section == "station"):
        least = np.degrees(scenario.values[f"station.{part.name}.least_elevation"])
        own = [each for each in found if each.name == part.name]
        lines.append(f"station {part.name}, above {plain(float(least), 3)} deg: {_listed(own)}")
    if scenario.orbit != "none":
        lines.append(f"eclipse: {_listed([each for each in found if each.name == 'eclipse'])}")
    return lines


def _listed(found: list[Pass]) -> str:
    parts = []
    for each in found:
        text = f"{each.begin:.1f} s to {each.end:.1f} s"
        if each.highest is not None:
            text += f" (highest {np.degrees(each.highest):.1f} deg)"
        parts.append(text)
    return shortened(parts, MOST_LISTED) or "none"


def _intervals(view: Callable[[Vector], Vector], time: Vector) -> list[tuple[float, float]]:
    """Intervals in which a view is above 0, to the ends of the times."""
    lasts = np.asarray(view(time)) > 0.0
    return [
        (
            0.0 if first == 0 else _change(view, time[first - 1], time[first]),
            float(time[-1]) if last == len(time) else _change(view, time[last - 1], time[last]),
        )
        for first, last in runs(lasts)
    ]


def _change(view: Callable[[Vector], Vector], low: float, high: float) -> float:
    """Time at which a view changes its sign, by bisection, s."""
    is_low = bool(view(np.array([low]))[0] > 0.0)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if bool(view(np.array([middle]))[0] > 0.0) == is_low:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
