"""Times in which instruments do not keep their angles to Sun, Earth and Moon."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.text import shortened
from gyrostat.runs.build_parts import named_parts
from gyrostat.runs.reference_path import ReferencePath, flown_path, reference_path
from gyrostat.scenario.component import Context
from gyrostat.scenario.kinds.orbits import nominal_orbit, orbit_of, planned_orbit
from gyrostat.scenario.scenario import KEEP_OUT, Scenario
from gyrostat.scenario.structure import structure_of
from gyrostat.spacecraft.sensors.keep_out import BODIES
from gyrostat.telemetry.signals import runs

MOST_LISTED = 6
"""Largest number of intervals in a line."""


class Violation(NamedTuple):
    """Interval in which a body is too near to a boresight.

    Attributes:
        instrument: Name of the [[keep_out]].
        body: "sun", "earth" or "moon".
        begin: First sample, s.
        end: Sample after the last one, or end of the run, s.
    """

    instrument: str
    body: str
    begin: float
    end: float


def violations(
    scenario: Scenario, path: ReferencePath, drawn: Mapping[str, float] | None = None
) -> list[Violation]:
    """Intervals in which a body is too near, by instrument, body and time.

    Args:
        scenario: Scenario.
        path: Attitude over time.
        drawn: Values of the run that are not the nominal ones, SI, by key; None: a nominal run.
    """
    if drawn is None:
        values, orbit = scenario.values, nominal_orbit(scenario)
    else:
        values = {**scenario.values, **drawn}
        orbit = orbit_of(scenario, values, planned_orbit(scenario))
    parts = named_parts(structure_of(scenario), values, KEEP_OUT, Context(orbit=orbit))
    found = []
    for name, keep_out in parts.items():
        near = jax.jit(jax.vmap(keep_out.violated))(jnp.asarray(path.attitude), path.time)
        for body, rows in near._asdict().items():
            found += [
                Violation(name, body, first * path.step, min(last * path.step, scenario.duration))
                for first, last in runs(np.asarray(rows))
            ]
    return found


def reference_violations(scenario: Scenario) -> list[str]:
    """Line on each instrument and body that is too near along the reference."""
    if not _instruments(scenario):
        return []
    return _lines(violations(scenario, reference_path(scenario)), "along the reference")


def flown_violations(
    scenario: Scenario, history: Mapping[str, Any], drawn: Mapping[str, float] | None = None
) -> list[str]:
    """Line on each instrument and body that is too near in a simulated run.

    Args:
        scenario: Scenario.
        history: Signals of the run, as of `gyrostat.runs.reference_path.flown_path`.
        drawn: See `violations`.
    """
    if not _instruments(scenario):
        return []
    return _lines(violations(scenario, flown_path(scenario, history), drawn), "in the run")


def _instruments(scenario: Scenario) -> list[str]:
    return [part.name for part in scenario.parts if part.section == KEEP_OUT]


def _lines(found: list[Violation], where: str) -> list[str]:
    lines = []
    for key in dict.fromkeys((each.instrument, each.body) for each in found):
        own = [each for each in found if (each.instrument, each.body) == key]
        texts = [f"{each.begin:.1f} s to {each.end:.1f} s" for each in own]
        lines.append(
            f"warning: keep_out {key[0]}: found {BODIES[key[1]]} too near to its boresight "
            f"{where}, {shortened(texts, MOST_LISTED)}; expected never"
        )
    return lines
