"""Harmonic of the wheel speed."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.component import Context, Kind
from gyrostat.scenario.schema import Key, positive, size
from gyrostat.spacecraft import WheelHarmonics


@dataclass(frozen=True, eq=False)
class Harmonic(Kind):
    """Forces and torque of every wheel at a multiple of the wheel speed.

    See `gyrostat.spacecraft.WheelHarmonics`.
    """

    name = "harmonic"
    number: Annotated[
        Scalar, positive("1", None, "Multiple of the wheel speed; any positive number.")
    ]
    force: Annotated[
        Scalar,
        size("imbalance", 0.0, "Radial force over the squared wheel speed.", source="harmonic"),
    ]
    torque: Annotated[
        Scalar,
        size(
            "inertia",
            0.0,
            "Torque across the axis over the squared wheel speed.",
            source="harmonic",
        ),
    ]
    axial: Annotated[
        Scalar,
        size("imbalance", 0.0, "Axial force over the squared wheel speed.", source="harmonic"),
    ]
    phase: Annotated[Scalar, Key("angle", 0.0, "Phase at the rotor angle 0.")]

    def make(self, context: Context) -> WheelHarmonics:
        """Harmonic of all wheels."""
        assert context.spacecraft is not None
        return WheelHarmonics.single(wheels=context.spacecraft.wheels.count, **self.options())
