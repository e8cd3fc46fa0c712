"""Friction over temperature, from records taken at different temperatures."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat._types import Vector
from gyrostat.identify.batch import identify
from gyrostat.telemetry import Record
from gyrostat.units import SI_UNIT

DISTINCT = 2.0
"""°C that mean temperatures must span before a trend is worth asking for."""


@dataclass(frozen=True)
class TemperatureTrend:
    """One parameter at the mean temperature of each record.

    Attributes:
        name: of the parameter.
        unit: of the parameter.
        temperature: (records,) °C.
        value: (records,) SI.
        sigma: (records,) SI.
        slope: change per °C, weighted straight line through the values, SI/°C.
        slope_sigma: its standard deviation.
    """

    name: str
    unit: str
    temperature: Vector
    value: Vector
    sigma: Vector
    slope: float
    slope_sigma: float

    def to_dict(self) -> dict[str, object]:
        """A row of the temperature table in fit.json."""
        return {
            "parameter": self.name,
            "unit": self.unit,
            "temperature_degC": self.temperature.tolist(),
            "value": self.value.tolist(),
            "sigma": self.sigma.tolist(),
            "slope_per_degC": self.slope,
            "slope_sigma": self.slope_sigma,
        }


def temperature_trends(records: Sequence[Record], **options: Any) -> list[TemperatureTrend]:
    """Fit each record alone and compare the friction across their mean temperatures.

    Args:
        records: of one wheel.
        options: arguments of `identify`, the same for all.

    Returns:
        One trend for each estimated parameter of the wheel; empty where fewer than two records
        have a temperature or their means lie within `DISTINCT`.
    """
    with_temperature = [(r, r.temperature) for r in records if r.temperature is not None]
    temperature = np.array([float(np.mean(t)) for _, t in with_temperature])
    if len(temperature) < 2 or np.ptp(temperature) < DISTINCT:
        return []
    fits = [identify(r, **options) for r, _ in with_temperature]
    trends = []
    for name in fits[0].names:
        if name.startswith("initial_speed"):
            continue
        value = np.array([f.parameters[name] for f in fits])
        sigma = np.array([f.sigma[f.names.index(name)] for f in fits])
        weight = sigma**-2.0
        centred = temperature - np.average(temperature, weights=weight)
        power = float(np.sum(weight * centred**2))
        trends.append(
            TemperatureTrend(
                name=name,
                unit=SI_UNIT[fits[0].dimensions[name]],
                temperature=temperature,
                value=value,
                sigma=sigma,
                slope=float(np.sum(weight * centred * value) / power),
                slope_sigma=power**-0.5,
            )
        )
    return trends
