"""Wheel speeds of a simulated run against science windows and bands."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.runs.reference_path import flown_path
from gyrostat.runs.sight_in_run import SightInRun
from gyrostat.runs.speed_plan.demand import Limits
from gyrostat.scenario.scenario import Scenario


class Flight(NamedTuple):
    """Wheel speeds of a run.

    Attributes:
        time: Times, (samples,), s.
        speed: Wheel speeds, (samples, wheels), rad/s.
        unloading: Torque of the external actuator in body axes, (samples, 3), N·m.
        inside: Whether each sample is in a science window, (samples,).
        crossings: "zero" and "band": crossings of zero and entries into bands in the windows.
        distance: Least distance of a wheel speed from zero, bands and limits in the windows, rad/s;
            negative in a band or beyond a limit.
        sight: Root mean square of the line of sight in the windows, rad; NaN if it is not known.
    """

    time: Vector
    speed: Matrix
    unloading: Matrix
    inside: Any
    crossings: dict[str, int]
    distance: float
    sight: float


def flight_of(
    scenario: Scenario,
    history: Mapping[str, Any],
    windows: Sequence[str],
    limits: Limits,
    sight: SightInRun | None = None,
    drawn: Mapping[str, float] | None = None,
) -> Flight:
    """Wheel speeds of a run.

    Args:
        scenario: Scenario.
        history: Signals of the run by name, NumPy arrays.
        windows: Names of the science windows.
        limits: Wheels.
        sight: Motion of the line of sight by the wheels; None: unknown.
        drawn: Values of a dispersed run; see `flown_path`.
    """
    path = flown_path(scenario, history, drawn)
    inside = np.any([path.windows[name] for name in windows], axis=0)
    speed = np.asarray(history["wheel_speed"], dtype=float)
    period = scenario.values["run.control_period"]
    return Flight(
        np.asarray(period * np.arange(len(speed)), dtype=np.float64),
        speed,
        np.nan_to_num(np.asarray(history.get("external_torque", np.zeros((len(speed), 3))))),
        inside,
        crossings(speed, inside, limits.bands),
        distance(speed[inside], limits),
        np.nan if sight is None else sight.rms(speed, inside),
    )


def distance(speed: Matrix, limits: Limits) -> float:
    """Least distance of wheel speeds from zero, bands and limits, rad/s.

    Args:
        speed: Wheel speeds, (samples, wheels), rad/s.
        limits: Wheels.
    """
    size = np.abs(speed)
    least = np.minimum(size, limits.momentum / limits.inertia - size)
    for low, high in limits.bands:
        least = np.minimum(least, np.maximum(low - size, size - high))
    return float(np.min(least, initial=np.inf))


def crossings(speed: Matrix, inside: Any, bands: Matrix) -> dict[str, int]:
    """Crossings of zero speed, and entries into bands, within science windows.

    A wheel that is in a band when a window begins has entered it.

    Args:
        speed: Wheel speeds, (samples, wheels), rad/s.
        inside: Whether each sample is in a science window, (samples,).
        bands: Bands of speeds of either sign, (bands, 2), rad/s.

    Returns:
        "zero" and "band": numbers of crossings and of entries.
    """
    inside = np.asarray(inside)
    together = inside[1:] & inside[:-1]
    sense = np.sign(speed)
    passed = (sense[1:] != sense[:-1]) & (sense[:-1] != 0.0)
    entered = 0
    for low, high in bands:
        within = (np.abs(speed) > low) & (np.abs(speed) < high) & inside[:, None]
        before = np.vstack([np.zeros((1, speed.shape[1]), bool), within[:-1]])
        entered += int(np.sum(within & ~before))
    return {"zero": int(np.sum(passed & together[:, None])), "band": entered}
