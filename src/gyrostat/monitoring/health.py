"""Health of wheels: window table, what was read, alarms; as text and JSON."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gyrostat.core.pictured import Pictured
from gyrostat.core.types import Matrix
from gyrostat.monitoring.change.assess import WheelHealth
from gyrostat.monitoring.change.detector import AlarmSettings
from gyrostat.monitoring.windows import PARAMETERS, REGRESSED, Windows


@dataclass(frozen=True, eq=False)
class Health(Pictured):
    """Result of monitoring.

    Attributes:
        windows: Window table.
        telemetry: What was read: files, rows, last time, drive, and what the clock did.
        notes: Remarks on the telemetry.
        conditions: Trend, changes and forecast of each wheel.
        settings: Settings of alarms and classes.
    """

    windows: Windows
    telemetry: Mapping[str, Any]
    notes: tuple[str, ...] = ()
    conditions: tuple[WheelHealth, ...] = ()
    settings: AlarmSettings = field(default_factory=AlarmSettings)

    @property
    def alarms(self) -> tuple[Mapping[str, Any], ...]:
        """Alarms that stand, one mapping each, with `wheel` and `text`."""
        return tuple({"wheel": c.wheel, "text": c.text} for c in self.conditions if c.alarm)

    @property
    def wheels(self) -> list[str]:
        """Names of the wheels."""
        return self.windows.wheels

    def latest(self, wheel: str) -> dict[str, Any] | None:
        """Last valid row of a wheel; None if it has none."""
        table = self.windows.wheel(wheel)
        valid = np.flatnonzero(table["valid"])
        if not valid.size:
            return None
        return {
            name: values[valid[-1]].item()
            if hasattr(values[valid[-1]], "item")
            else values[valid[-1]]
            for name, values in table.columns.items()
        }

    def to_dict(self) -> dict[str, Any]:
        """Content of health.json."""
        return {
            "telemetry": dict(self.telemetry),
            "wheels": {name: self._wheel(name) for name in self.wheels},
            "changes": {each.wheel: each.as_json() for each in self.conditions},
            "alarms": [dict(alarm) for alarm in self.alarms],
            "assumed": {
                "false_alarms_per_wheel_year": self.settings.false_alarms,
                "faults_per_wheel_year": dict(self.settings.rates),
            },
            "notes": list(self.notes),
        }

    def _wheel(self, name: str) -> dict[str, Any]:
        table = self.windows.wheel(name)
        row = self.latest(name)
        last = table["why"][-1] if len(table) else ""
        return {
            "windows": len(table),
            "valid": int(np.sum(table["valid"])),
            "last_window": {"valid": bool(table["valid"][-1]), "why": last},
            "latest": None if row is None else _parameters(row),
        }

    def __str__(self) -> str:
        """Text for the terminal."""
        return "\n".join(self.lines())

    def lines(self) -> list[str]:
        """Text for the terminal."""
        lines = []
        for name in self.wheels:
            table, row = self.windows.wheel(name), self.latest(name)
            lines.append(f"{name}: {int(np.sum(table['valid']))} of {len(table)} windows valid")
            if row is None:
                lines.append(f"  not valid: {table['why'][-1]}")
                continue
            if not table["valid"][-1]:
                lines.append(f"  the last window is not valid: {table['why'][-1]}")
            for parameter, unit in PARAMETERS.items():
                if row[f"{parameter}_observable"]:
                    value, sigma = row[parameter], row[f"{parameter}_sigma"]
                    lines.append(
                        f"  {parameter:<15} {value:.4g} ± {1.96 * sigma:.2g} {unit} (95 %)"
                    )
                else:
                    lines.append(f"  {parameter:<15} {unknown_text(row, parameter)}")
            if math.isfinite(row["speed_scale"]):
                value, half = row["speed_scale"], 1.96 * row["speed_scale_sigma"]
                lines.append(f"  speed_scale     {value:.4f} ± {half:.4f} (95 %)")
        lines += [f"note: {note}" for note in self.notes]
        lines += [f"ALARM: {alarm['wheel']}: {alarm['text']}" for alarm in self.alarms]
        return lines


NO_EXCHANGE = (
    "the exchange of momentum does not show it to 1 %, or rates, axes or inertia are missing"
)
"""Why a window has no scale of the measured speed."""


def unknown_text(row: Mapping[str, Any], parameter: str) -> str:
    """Why a window does not determine a parameter.

    Args:
        row: Row of the window table.
        parameter: One of `PARAMETERS` that is not observable.
    """
    reason = row[f"{parameter}_reason"]
    if parameter == "static":  # never estimated: samples of telemetry only bound it
        return f"not estimated: {reason}"
    return f"not observable, because {reason}"


def _parameters(row: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters of a row for JSON: value, interval and whether it is observable."""
    result: dict[str, Any] = {"start": row["start"], "end": row["end"]}
    for name, unit in {**PARAMETERS, "speed_scale": ""}.items():
        value, sigma = row[name], row[f"{name}_sigma"]
        present = math.isfinite(value) and math.isfinite(sigma)
        result[name] = {
            "value": value if present else None,
            "sigma": sigma if present else None,
            "interval": [value - 1.96 * sigma, value + 1.96 * sigma] if present else None,
            "unit": unit,
            "observable": bool(row.get(f"{name}_observable", present)),
            "reason": row.get(f"{name}_reason", "" if present else NO_EXCHANGE),
        }
    return result


def covariance(row: Mapping[str, Any], names: tuple[str, ...] = REGRESSED) -> Matrix:
    """Covariance of parameters of a row, (n, n).

    Args:
        row: Row of the window table.
        names: Parameters, in the order of `REGRESSED`.
    """
    matrix = np.diag([row[f"{name}_sigma"] ** 2 for name in names])
    for i, first in enumerate(names):
        for j in range(i + 1, len(names)):
            matrix[i, j] = matrix[j, i] = row[f"cov_{first}_{names[j]}"]
    return matrix
