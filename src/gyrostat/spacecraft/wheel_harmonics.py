"""Disturbances of wheels at multiples of the wheel speed, and structural modes of the wheels."""

from typing import Annotated, Any, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, finite, limit, positive, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.spacecraft.wheel_modes import Gain, rocking_gain, translation_gain
from gyrostat.wheel.array import listed

PerHarmonic = Float[Array, "harmonics wheels"]
"""One real number for each harmonic and wheel."""


class WheelHarmonics(Checked):
    """Forces and torques of wheels at multiples h of the wheel speed W, such as those of bearings.

    Each rotates with the phase h angle + phase and grows with the square of the speed: a radial
    force U W², an axial force A W² and a torque D W² across the axis. The coefficients are those of
    R. A. Masterson, D. W. Miller, R. L. Grogan, Journal of Sound and Vibration 249 (2002), equation
    1, for angular speeds: a coefficient in N/Hz² is divided by 4 π².

    Attributes:
        number: Multiple h of the wheel speed, (harmonics,); it need not be an integer.
        force: Radial force over W², (harmonics, wheels), kg·m.
        torque: Torque across the axis over W², (harmonics, wheels), kg·m².
        axial: Axial force over W², (harmonics, wheels), kg·m.
        phase: Phase at the rotor angle 0, (harmonics, wheels), rad.
    """

    number: Annotated[Float[Array, " harmonics"], positive("number of a harmonic")] = eqx.field(
        converter=listed
    )
    force: Annotated[PerHarmonic, size("force of a harmonic", "kg·m")] = eqx.field(converter=listed)
    torque: Annotated[PerHarmonic, size("torque of a harmonic", "kg·m²")] = eqx.field(
        converter=listed
    )
    axial: Annotated[PerHarmonic, size("axial force of a harmonic", "kg·m")] = eqx.field(
        converter=listed
    )
    phase: Annotated[PerHarmonic, finite("phase of a harmonic", "rad")] = eqx.field(
        converter=listed
    )

    @classmethod
    def single(cls, number: Scalar, wheels: int, **values: Any) -> Self:
        """One harmonic of all wheels.

        Args:
            number: Multiple of the wheel speed.
            wheels: Number of wheels.
            values: Other attributes, (wheels,), or one value for all; 0 by default.
        """
        names = ("force", "torque", "axial", "phase")
        coefficients = {name: jnp.zeros((1, wheels)) + values.get(name, 0.0) for name in names}
        return cls(jnp.reshape(jnp.asarray(number, dtype=float), 1), **coefficients)

    @classmethod
    def joined(cls, *parts: Self) -> Self:
        """Harmonics of several parts."""
        names = ("number", "force", "torque", "axial", "phase")
        return cls(*(jnp.concatenate([getattr(part, name) for part in parts]) for name in names))

    def check_wheels(self, count: int) -> None:
        """Validate shapes.

        Args:
            count: Number of wheels.

        Raises:
            InputError: A shape differs from those of the attributes.
        """
        shape = (*np.shape(self.number), count)
        for name in ("force", "torque", "axial", "phase"):
            found = np.shape(getattr(self, name))
            if found != shape:
                raise InputError(f"wheel harmonics {name}: found shape {found}, expected {shape}")


class WheelStructure(Checked):
    """Radial and rocking mode of a rotor in its elastic bearings.

    They amplify the radial forces and the torques of a wheel before these reach the spacecraft. At
    the frequency w of a forward rotating disturbance, the transmitted part is

        radial:  (1 + 2i z r) / (1 - r² + 2i z r),            r = w / w_radial;
        rocking: (1 + 2i z r) / (1 - r² + g W w / w_rocking² + 2i z r),  r = w / w_rocking,

    with the damping ratio z of the mode and the wheel speed W. Gyroscopic stiffness, with the ratio
    g of polar to transverse inertia of the rotor, splits the rocking mode: the forward mode, which
    harmonics of the rotor excite, rises with the speed. A balanced disc (g above 1) is therefore
    never in resonance with its own rotation. Masterson, Miller and Grogan (2002), section 3.

    Attributes:
        radial_frequency: Frequency of the radial mode, (wheels,), rad/s; infinite for a rigid one.
        radial_damping: Its damping ratio, (wheels,).
        rocking_frequency: Frequency of the rocking mode at rest, (wheels,), rad/s; likewise.
        rocking_damping: Its damping ratio at rest, (wheels,).
        inertia_ratio: Polar over transverse inertia of the rotor, (wheels,).
    """

    radial_frequency: Annotated[PerWheel, limit("frequency of the radial mode", "rad/s")] = (
        eqx.field(converter=listed)
    )
    radial_damping: Annotated[PerWheel, positive("damping of the radial mode")] = eqx.field(
        converter=listed
    )
    rocking_frequency: Annotated[PerWheel, limit("frequency of the rocking mode", "rad/s")] = (
        eqx.field(converter=listed)
    )
    rocking_damping: Annotated[PerWheel, positive("damping of the rocking mode")] = eqx.field(
        converter=listed
    )
    inertia_ratio: Annotated[PerWheel, size("inertia ratio of the rotor")] = eqx.field(
        converter=listed
    )

    def radial(self, frequency: Any) -> Gain:
        """Transmitted part of a radial force at angular frequencies, (harmonics, wheels), rad/s."""
        return translation_gain(frequency, self.radial_frequency, self.radial_damping)

    def rocking(self, frequency: Any, speed: PerWheel) -> Gain:
        """Transmitted part of a torque.

        Args:
            frequency: Angular frequencies, of the sign of the speed, (harmonics, wheels), rad/s.
            speed: Wheel speeds, (wheels,), rad/s.
        """
        return rocking_gain(
            frequency,
            speed,
            self.rocking_frequency,
            self.rocking_damping,
            self.inertia_ratio,
        )

    def check_wheels(self, count: int) -> None:
        """Validate shapes.

        Args:
            count: Number of wheels.

        Raises:
            InputError: An attribute has another number of wheels.
        """
        for name, value in vars(self).items():
            if np.shape(value)[-1:] != (count,):
                raise InputError(
                    f"wheel structure {name}: found shape {np.shape(value)}, expected ({count},)"
                )
