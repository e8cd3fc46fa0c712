"""Result of `allan`: Allan deviations and noise parameters of a gyro."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.core.pictured import Pictured
from gyrostat.core.text import plain
from gyrostat.identification.gyro.fit import AxisNoise
from gyrostat.identification.gyro.parameters import PARAMETERS, Estimate

DEGREES_PER_HOUR = float(np.degrees(3600.0))
"""Degrees an hour of a radian a second."""


@dataclass(frozen=True, eq=False)
class GyroNoise(Pictured):
    """Noise of the axes of a gyro.

    Attributes:
        name: Name of the record.
        interval: Time from sample to sample, s.
        samples: Number of samples.
        axes: Noise of each axis.
        shortest: Shortest averaging time of the fit, s.
    """

    name: str
    interval: float
    samples: int
    axes: tuple[AxisNoise, ...]
    shortest: float

    def __getitem__(self, axis: str) -> AxisNoise:
        """Noise of an axis by its name."""
        return next(each for each in self.axes if each.axis == axis)

    def lines(self) -> list[str]:
        """The result as lines for a terminal."""
        hours = self.samples * self.interval / 3600.0
        lines = [f"{self.name}: {hours:.3g} h of {plain(1.0 / self.interval)} Hz"]
        width = max(len(kind.title) for kind in PARAMETERS.values())
        for each in self.axes:
            lines.append(f"  {each.axis}: mean {plain(each.mean * DEGREES_PER_HOUR)} deg/h")
            for name, kind in PARAMETERS.items():
                lines.append(
                    f"    {kind.letter} {kind.title.ljust(width)}  {each.parameters[name].text()}"
                )
            lines += [f"    warning: {text}" for text in each.warnings]
        return lines

    def __str__(self) -> str:
        """The lines for a terminal."""
        return "\n".join(self.lines())

    def content(self) -> dict[str, Any]:
        """Content of allan.json, SI units."""
        return {
            "record": self.name,
            "interval": self.interval,
            "samples": self.samples,
            "shortest": self.shortest,
            "level": 0.95,
            "axes": {
                each.axis: {
                    "mean": each.mean,
                    "time": each.time.tolist(),
                    "deviation": each.deviation.tolist(),
                    "low": each.low.tolist(),
                    "high": each.high.tolist(),
                    "parameters": {n: p.as_json() for n, p in each.parameters.items()},
                    "warnings": list(each.warnings),
                }
                for each in self.axes
            },
        }

    def sensors(self) -> str:
        """Section [sensors] of a scenario with a gyro of this noise.

        A scenario has one value for all axes: the largest of the axes that determine it. What no
        axis determines is left out, but the angle random walk, which the scenario needs, is then
        its upper limit.
        """
        lines = [
            f"# gyro noise from {self.name}",
            "[sensors]",
            'kind = "star_tracker_data_sheet_gyro"',
            'attitude_sigma = "10 arcsec"  # replace by that of your star tracker',
            self._key("angle_walk", "angle_walk", required=True),
            self._key("bias_walk", "bias_walk"),
            self._key("bias_instability", "bias_instability"),
            self._key("angle_resolution", "quantisation", factor=np.sqrt(12.0)),
        ]
        ramp = self._largest("rate_ramp")
        if ramp is not None:
            lines.append(f"# rate ramp, which has no key: {ramp.sheet(ramp.value)}")
        return "\n".join(lines) + "\n"

    def _largest(self, name: str) -> Estimate | None:
        known = [each.parameters[name] for each in self.axes if each.parameters[name].observable]
        return max(known, key=lambda estimate: abs(estimate.value), default=None)

    def _key(self, key: str, name: str, *, required: bool = False, factor: float = 1.0) -> str:
        """Line of a key of the section, from a parameter and a factor on it."""
        largest = self._largest(name)
        if largest is not None:
            return f'{key} = "{largest.sheet(factor * largest.value)}"'
        estimates = [each.parameters[name] for each in self.axes]
        bound = estimates[0].sheet(factor * max(each.largest for each in estimates))
        if required:
            return f'{key} = "{bound}"  # upper limit: not observable in the record'
        return f"# {key}: not observable in the record, at most {bound}"
