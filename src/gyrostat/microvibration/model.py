"""Loads of a turning wheel on its mount: harmonics, structural modes and broadband noise.

With the wheel speed W in rad/s, a harmonic of number h has the frequency h W and the amplitude
C W² before the structure of the wheel amplifies it. A rotor is symmetric about its axis, so that
the two loads of a pair across the axis (Fx, Fy and Tx, Ty) have common coefficients: one of the
part that whirls forward and one of the part that whirls backward. Their mean square is

    P = W⁴ / 2 (forward² |G(h W)|² + backward² |G(-h W)|²),

with the gain G of the mode (`gyrostat.spacecraft.wheel_modes`), whatever their phases are. Noise of
the bearings is amplified in both senses alike: its density is B (W / W_r)^p (|G(w)|² + |G(-w)|²)/2.
R. A. Masterson, D. W. Miller, R. L. Grogan, Journal of Sound and Vibration 249 (2002).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from gyrostat.core.pictured import Described
from gyrostat.core.types import Matrix, Vector
from gyrostat.spacecraft.wheel_modes import rocking_gain, rocking_power, translation_gain

TWO_PI = 2.0 * np.pi

LOADS = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")
"""Forces, N, and torques, N·m, in the axes of the wheel; z is its spin axis."""
KINDS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"force": ("Fx", "Fy"), "axial": ("Fz",), "torque": ("Tx", "Ty"), "torsion": ("Tz",)}
)
"""Kind of load -> its loads: radial force, axial force, torque across the axis and about it."""
DENSITY_UNITS = {"force": "N²/Hz", "axial": "N²/Hz", "torque": "(N·m)²/Hz", "torsion": "(N·m)²/Hz"}
"""Kind of load -> unit of a density."""
UNITS = {"force": "kg·m", "axial": "kg·m", "torque": "kg·m²", "torsion": "kg·m²"}
"""Kind of load -> unit of a coefficient C."""


@dataclass(frozen=True)
class Mode(Described):
    """Structural mode of a wheel for one kind of load.

    Attributes:
        frequency: Natural frequency at rest, rad/s.
        damping: Damping ratio at rest.
        inertia_ratio: Polar over transverse inertia of the rotor, of a rocking mode; 0 for others.
    """

    frequency: float
    damping: float
    inertia_ratio: float = 0.0

    def gain(self, frequency: Any, speed: Any) -> Any:
        """Complex gain of a load that turns with a signed angular frequency, rad/s."""
        if self.inertia_ratio == 0.0:
            real, imaginary = translation_gain(frequency, self.frequency, self.damping)
        else:
            real, imaginary = rocking_gain(
                frequency, speed, self.frequency, self.damping, self.inertia_ratio
            )
        return real + 1j * imaginary

    def power_gain(self, frequency: Any, speed: Any) -> Any:
        """Square of the size of the gain, real."""
        return rocking_power(frequency, speed, self.frequency, self.damping, self.inertia_ratio)


@dataclass(frozen=True)
class Harmonic(Described):
    """Harmonic of the wheel speed.

    Attributes:
        number: Multiple h of the wheel speed.
        forward: Kind of load -> amplitude over W² of its forward part, kg·m or kg·m².
        backward: The same of the part that turns against the wheel; of force and torque only.
    """

    number: float
    forward: Mapping[str, float] = field(default_factory=dict)
    backward: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Noise(Described):
    """Broadband noise of one kind of load at the input of its mode.

    Attributes:
        density: One-sided density at the reference speed, N²/Hz or (N·m)²/Hz.
        exponent: Power of the speed with which the density grows.
        reference: Reference speed, rad/s.
    """

    density: float
    exponent: float
    reference: float

    def at(self, speed: Any) -> Any:
        """Density at a wheel speed, rad/s."""
        return self.density * (np.abs(speed) / self.reference) ** self.exponent


@dataclass(frozen=True)
class WheelDisturbance(Described):
    """Loads of one wheel.

    Attributes:
        name: Name of the wheel.
        harmonics: Harmonics, by number.
        modes: Kind of load -> mode; a kind without one is transmitted as it is.
        noise: Kind of load -> broadband noise; a kind without one has none.
    """

    name: str
    harmonics: tuple[Harmonic, ...]
    modes: Mapping[str, Mode] = field(default_factory=dict)
    noise: Mapping[str, Noise] = field(default_factory=dict)

    def tone(self, kind: str, speed: Vector, sense: int) -> Matrix:
        """Complex amplitudes that reach the mount, (harmonics, speeds), N or N·m.

        Args:
            kind: Kind of load.
            speed: Wheel speeds, (speeds,), rad/s.
            sense: 1 for the forward part, -1 for the backward part.
        """
        part = [each.forward if sense > 0 else each.backward for each in self.harmonics]
        coefficient = np.array([values.get(kind, 0.0) for values in part])
        number = np.array([each.number for each in self.harmonics])
        size = np.abs(np.asarray(speed))
        frequency = sense * number[:, None] * size
        mode = self.modes.get(kind)
        gain = 1.0 if mode is None else mode.gain(frequency, size)
        return coefficient[:, None] * size**2 * gain
