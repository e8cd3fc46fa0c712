"""Inputs of the verbs on failed wheels in words, as they were understood, and what to do next."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.core.text import plain, triple
from gyrostat.core.types import Vector
from gyrostat.core.units import RPM
from gyrostat.failures import Telemetry, attitude_text, euler_angles
from gyrostat.failures.steps import NextStep
from gyrostat.reports.page_units import told

Row = tuple[str, str]
THRUSTER_TORQUE = 1e-3
"""Torque for which the time of unloading is stated, N·m."""
ROD_DIPOLE, FIELD = 1.0, 30e-6
"""Dipole of torque rods, A·m², and Earth's field in low orbit, T, for the same."""


@dataclass(frozen=True)
class Inputs:
    """Inputs of a verb on failures, as they were understood.

    Attributes:
        wheel_names: Names of the wheels.
        failed: Name of each failed wheel -> its failure in words.
        target: Target attitude, (4,), or None.
        pointing: Boresight in body axes and inertial direction to point it at, (3,) each, or None.
        telemetry: Motion at the failure, or None if only the momentum is given.
        warnings: Inputs that may be meant otherwise.
    """

    wheel_names: Sequence[str]
    failed: Mapping[str, str]
    target: Vector | None
    pointing: tuple[Vector, Vector] | None
    telemetry: Telemetry | None
    warnings: Sequence[str] = ()

    def rows(self) -> list[Row]:
        """Pairs of name and entry."""
        rows: list[Row] = []
        if self.target is not None:
            rows.append(("target", attitude_text(self.target)))
        if self.pointing is not None:
            body, towards = self.pointing
            aim = f"body direction {triple(body)} towards inertial {triple(towards)}"
            rows.append(("target", f"{aim}, roll free"))
        failures = "; ".join(f"{name} {how}" for name, how in self.failed.items())
        rows.append(("failed", failures or "none"))
        if self.telemetry is not None:
            state, rate = self.telemetry, triple(np.degrees(self.telemetry.rate))
            speeds = zip(self.wheel_names, state.wheel_speed / RPM, strict=True)
            rows += [
                ("attitude at the failure", attitude_text(state.attitude)),
                ("body rate at the failure", f"{rate} deg/s, body"),
                ("wheels at the failure", ", ".join(f"{n} {plain(v, 6)} rpm" for n, v in speeds)),
            ]
        return rows

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers in SI units, lists and texts."""
        state = self.telemetry
        speeds = None if state is None else state.wheel_speed.tolist()
        return {
            "target": None if self.target is None else _attitude(self.target),
            "failed": dict(self.failed),
            "attitude": None if state is None else _attitude(state.attitude),
            "rate": None if state is None else state.rate.tolist(),
            "wheel_speed": speeds and dict(zip(self.wheel_names, speeds, strict=True)),
            "warnings": [*self.warnings],
        }


def _attitude(quaternion: Vector) -> dict[str, Any]:
    return {
        "quaternion": quaternion.tolist(),
        "euler": euler_angles(quaternion).tolist(),
        "text": attitude_text(quaternion),
    }


def unloading_rows(unload: Vector | None) -> list[Row]:
    """What unloading a momentum takes.

    The torque of thrusters acts along the momentum. Torque rods give at most the product of dipole
    and field, none of it along the field, so that their time is a lower bound.

    Args:
        unload: Momentum to remove, inertial axes, (3,), N·m·s; None for no rows.
    """
    if unload is None:
        return []
    size = float(np.linalg.norm(unload))
    rods = size / (ROD_DIPOLE * FIELD)
    return [
        (
            "momentum to unload to hold the target",
            f"{plain(size)} N·m·s of the total: {triple(unload)}, inertial",
        ),
        (
            "time to unload it",
            f"{_time(size / THRUSTER_TORQUE)} with a thruster torque of "
            f"{told(THRUSTER_TORQUE, 'N·m')}; at least {_time(rods)} with torque rods of "
            f"{ROD_DIPOLE:g} A·m² in a field of {FIELD * 1e6:g} µT; inversely proportional to each",
        ),
    ]


def _time(seconds: float) -> str:
    if seconds < 600.0:
        return f"{plain(seconds, 3)} s"
    minutes = seconds / 60.0
    return f"{plain(minutes, 3)} min" if minutes < 120.0 else f"{plain(minutes / 60.0, 3)} h"


def say_rows(rows: Sequence[Row], say: Callable[[str], None]) -> None:
    """Print pairs of name and entry."""
    for name, entry in rows:
        say(f"  {name}: {entry}")


def say_steps(steps: Sequence[NextStep], say: Callable[[str], None]) -> None:
    """Print what to do next."""
    for step in steps:
        say(f"next: {step.why}{step.command and ':'}")
        if step.command:
            say(f"  {step.command}")


def steps_content(steps: Sequence[NextStep]) -> list[dict[str, str]]:
    """What to do next, for a JSON file."""
    return [{"why": step.why, "command": step.command} for step in steps]
