"""Trend of one parameter over temperature."""

from dataclasses import dataclass

from gyrostat.core.pictured import Listed
from gyrostat.core.types import Vector


@dataclass(frozen=True)
class TemperatureTrend(Listed):
    """Values of one parameter over the mean temperatures of the records.

    Attributes:
        name: Name of the parameter.
        unit: Unit of the parameter.
        temperature: Mean temperature of each record, (records,), °C.
        value: Value from each record, (records,), SI.
        sigma: Standard deviation of each value, (records,), SI.
        slope: Change per °C, from a weighted straight line through the values, SI/°C.
        slope_sigma: Standard deviation of the slope, scaled up if the values scatter about the line
            by more than their own standard deviations.
    """

    name: str
    unit: str
    temperature: Vector
    value: Vector
    sigma: Vector
    slope: float
    slope_sigma: float

    def to_dict(self) -> dict[str, object]:
        """Convert to a row of the temperature table in fit.json."""
        return {
            "parameter": self.name,
            "unit": self.unit,
            "temperature_degC": self.temperature.tolist(),
            "value": self.value.tolist(),
            "sigma": self.sigma.tolist(),
            "slope_per_degC": self.slope,
            "slope_sigma": self.slope_sigma,
        }
