"""Data for the 3D replay of a run."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrostat.reports.replay_world import world_data
from gyrostat.runs.designs import phase_starts, phases_of
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.structure import structure_of

if TYPE_CHECKING:
    from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment

MOST_FRAMES = 900
"""Largest number of samples in the page."""


def replay_data(
    scenario: Scenario,
    values: Mapping[str, Any],
    history: Mapping[Any, Any],
    orbit: "OrbitEnvironment | None",
    most: int = MOST_FRAMES,
) -> dict[str, Any] | None:
    """Motion of a run for the script of its page; None if the run ended at the start.

    Args:
        scenario: Scenario of the run.
        values: Row of the run in the table of runs.
        history: Histories of the run: name -> array, or what can be converted to one.
        orbit: Orbit of the scenario, as from `planned_orbit`; None without an orbit.
        most: Largest number of samples.
    """
    fine = np.flatnonzero(np.isfinite(np.asarray(history["error"])))
    if len(fine) < 2:
        return None
    frames = fine[:: max(1, -(-len(fine) // most))]
    run_values = {**scenario.values, **values}
    structure = structure_of(scenario)
    targets, slews = [scenario.target], {event.name: event.target for event in scenario.events}
    for event in phases_of(structure):
        targets.append(slews[event.name] or targets[-1])
    time = np.asarray(history["time"])[frames]
    starts = np.array(phase_starts(structure, run_values), dtype=float)
    phase = np.searchsorted(starts, time + 1e-9, side="right") - 1
    target = [targets[k] for k in phase]
    if scenario.reference != "fixed":
        target = np.round(np.asarray(history["target"])[frames], 6).tolist()
    window = next((w.boresight for w in scenario.windows if w.boresight), (0.0, 0.0, 1.0))
    xx, yy, zz = (run_values[f"body.inertia.{end}"] for end in ("xx", "yy", "zz"))
    # sides of the cuboid of uniform density with these moments of inertia
    sides = np.sqrt(np.maximum([yy + zz - xx, zz + xx - yy, xx + yy - zz], 1e-3 * (xx + yy + zz)))
    return {
        "time": np.round(time, 6).tolist(),
        "attitude": np.round(np.asarray(history["attitude"])[frames], 6).tolist(),
        "error": [float(f"{v:.4g}") for v in np.degrees(np.asarray(history["error"])[frames])],
        "speed": np.round(np.asarray(history["wheel_speed"])[frames], 3).tolist(),
        "target": target,
        "sides": (sides / np.max(sides)).tolist(),
        "axes": scenario.axes,
        "wheels": scenario.wheels,
        "boresight": scenario.boresight or window,
        "field_of_view": scenario.field_of_view,
        "world": world_data(scenario, run_values, history, frames, orbit),
    }
