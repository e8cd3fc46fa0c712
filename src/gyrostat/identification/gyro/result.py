"""Result of `allan`: Allan deviations and noise parameters of a gyro."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.core.pictured import Pictured
from gyrostat.core.text import plain
from gyrostat.identification.gyro.fit import AxisNoise
from gyrostat.identification.gyro.parameters import PARAMETERS, Estimate

_DEGREES_PER_HOUR = np.degrees(3600.0)


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
            lines.append(f"  {each.axis}: mean {plain(each.mean * _DEGREES_PER_HOUR)} deg/h")
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

        A scenario has one value of each walk for all axes: the largest of the axes that determine
        it. A walk that no axis determines is 0, or the upper limit where the scenario needs one.
        """
        lines = [
            f"# gyro noise from {self.name}",
            "[sensors]",
            'kind = "star_tracker_gyro"',
            'attitude_sigma = "10 arcsec"  # replace by that of your star tracker',
            self._key("angle_walk", required=True),
            self._key("bias_walk"),
        ]
        return "\n".join([*lines, *self._not_modelled()]) + "\n"

    def _largest(self, name: str) -> Estimate | None:
        known = [each.parameters[name] for each in self.axes if each.parameters[name].observable]
        return max(known, key=lambda estimate: abs(estimate.value), default=None)

    def _bound(self, name: str) -> str:
        estimates = [each.parameters[name] for each in self.axes]
        return estimates[0].sheet(max(each.largest for each in estimates))

    def _key(self, name: str, *, required: bool = False) -> str:
        """Line of a key."""
        largest = self._largest(name)
        if largest is not None:
            return f'{name} = "{largest.sheet(largest.value)}"'
        if required:
            return f'{name} = "{self._bound(name)}"  # upper limit: not observable in the record'
        return f"# {name}: not observable in the record, at most {self._bound(name)}"

    def _not_modelled(self) -> list[str]:
        """Comments on what the section has no key for."""
        lines = []
        for name in ("bias_instability", "quantisation", "rate_ramp"):
            largest = self._largest(name)
            if largest is not None:
                title = PARAMETERS[name].title
                lines.append(f"# {title}, which has no key: {largest.sheet(largest.value)}")
        return lines
