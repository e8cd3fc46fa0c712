"""Result of the fit of a waterfall."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gyrostat.core.pictured import Described, Pictured
from gyrostat.core.text import measured, plain
from gyrostat.core.unit_table import RPM
from gyrostat.microvibration.estimates import Estimate
from gyrostat.microvibration.kind_fit import KindFit
from gyrostat.microvibration.model import TWO_PI, Harmonic, Mode, Noise, WheelDisturbance
from gyrostat.microvibration.waterfall import Waterfall


@dataclass(frozen=True)
class Coefficient(Described):
    """Coefficient of a harmonic for one kind of load.

    Attributes:
        total: Size of both senses together.
        forward: Part that whirls with the wheel.
        backward: Part that whirls against it.
        splits: Whether a gyroscopic mode tells the senses apart; otherwise all is called forward.
        speeds: Number of speeds at which the line stands alone.
        loads: Coefficient of each measured load.
    """

    total: Estimate
    forward: Estimate
    backward: Estimate
    splits: bool
    speeds: int
    loads: Mapping[str, Estimate]


@dataclass(frozen=True)
class FittedHarmonic(Described):
    """Harmonic of a wheel.

    Attributes:
        number: Multiple of the wheel speed.
        coefficients: Kind of load -> coefficient.
    """

    number: Estimate
    coefficients: Mapping[str, Coefficient]


@dataclass(frozen=True, eq=False)
class FittedKind(Described):
    """Mode and noise of one kind of load.

    Attributes:
        fit: Fit with its data.
        mode: Parameter -> estimate; empty without a mode.
        noise: Parameter -> estimate: floor of the measurement, density and exponent of the wheel.
    """

    fit: KindFit
    mode: Mapping[str, Estimate]
    noise: Mapping[str, Estimate]


@dataclass(frozen=True, eq=False)
class WaterfallFit(Pictured):
    """Disturbance of a wheel, fitted from a waterfall.

    Attributes:
        waterfall: Measured waterfall.
        harmonics: Harmonics, by number.
        kinds: Kind of load -> mode and noise.
        reasons: Why the result is not valid; empty if it is.
        warnings: What limits a valid result.
    """

    waterfall: Waterfall
    harmonics: tuple[FittedHarmonic, ...]
    kinds: Mapping[str, FittedKind]
    reasons: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def valid(self) -> bool:
        """Whether the waterfall determines the disturbance."""
        return not self.reasons

    def disturbance(self) -> WheelDisturbance:
        """Loads of the wheel, of the parameters that are observable."""
        harmonics = []
        for each in self.harmonics:
            parts: list[dict[str, float]] = [{}, {}]
            for kind, value in each.coefficients.items():
                for part, estimate in zip(parts, (value.forward, value.backward), strict=True):
                    if value.total.observable and estimate.observable:
                        part[kind] = estimate.value
            if parts[0] or parts[1]:
                harmonics.append(Harmonic(each.number.value, *parts))
        reference = float(self.waterfall.speed[-1])
        modes, noise = {}, {}
        for kind, each in self.kinds.items():
            if each.mode:
                modes[kind] = Mode(**{name: x.value for name, x in each.mode.items()})
            if each.noise["density"].observable:
                exponent = float(each.fit.values[2])
                noise[kind] = Noise(each.noise["density"].value, exponent, reference)
        return WheelDisturbance(self.waterfall.name, tuple(harmonics), modes, noise)

    def lines(self) -> list[str]:
        """The result as lines for a terminal."""
        data = self.waterfall
        low, high = data.speed[[0, -1]] / RPM
        lines = [
            f"{data.name}: {len(data.speed)} speeds of {plain(low)} to {plain(high)} rpm, "
            f"steps of {plain(data.step)} Hz"
        ]
        for each in self.harmonics:
            seen = any(value.total.observable for value in each.coefficients.values())
            weak = "" if seen else ": no coefficient stands out, left out of the disturbance"
            lines.append(f"  h = {measured(each.number.value, each.number.sigma)}{weak}")
            for kind, value in each.coefficients.items():
                if value.total.observable:
                    size = measured(value.total.value, value.total.sigma)
                    sense = _sense(value)
                    lines.append(f"    {kind:8s} {size} {value.total.unit}{sense}")
        for kind, each in self.kinds.items():
            parts = []
            for name, x in each.mode.items():
                scale, unit = (TWO_PI, " Hz") if name == "frequency" else (1.0, "")
                parts.append(f"{name} {measured(x.value / scale, x.sigma / scale)}{unit}")
            lines.append(f"  {kind} mode: {', '.join(parts) or 'none'}")
        lines += [f"warning: {text}" for text in self.warnings]
        return lines + [f"not valid: {text}" for text in self.reasons]

    def __str__(self) -> str:
        """The lines for a terminal."""
        return "\n".join(self.lines())

    def content(self) -> dict[str, Any]:
        """Content of disturbance.json, SI units."""
        return {
            "waterfall": self.waterfall.name,
            "speeds": len(self.waterfall.speed),
            "step": self.waterfall.step,
            "valid": self.valid,
            "reasons": list(self.reasons),
            "warnings": list(self.warnings),
            "level": 0.95,
            "harmonics": [
                {
                    "number": each.number.as_json(),
                    **{kind: _content(value) for kind, value in each.coefficients.items()},
                }
                for each in self.harmonics
            ],
            "modes": {
                kind: {name: x.as_json() for name, x in each.mode.items()}
                for kind, each in self.kinds.items()
                if each.mode
            },
            "noise": {
                kind: {name: x.as_json() for name, x in each.noise.items()}
                for kind, each in self.kinds.items()
            },
        }


def _sense(value: Coefficient) -> str:
    """Sense of whirl where the waterfall determines it."""
    parts = [n for n in ("forward", "backward") if getattr(value, n).observable]
    if not value.splits:
        return ""
    return f", {' and '.join(parts) or 'sense not determined: left out of the disturbance'}"


def _content(value: Coefficient) -> dict[str, Any]:
    parts = {name: getattr(value, name).as_json() for name in ("total", "forward", "backward")}
    loads = {load: each.as_json() for load, each in value.loads.items()}
    return {**parts, "splits": value.splits, "speeds": value.speeds, "loads": loads}
