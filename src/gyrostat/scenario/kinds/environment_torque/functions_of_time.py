"""Torques that are given as functions of time."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.component import Context, Kind
from gyrostat.scenario.schema import positive, vector
from gyrostat.spacecraft import HarmonicTorque


@dataclass(frozen=True, eq=False)
class Constant(Kind):
    """Constant torque in body axes."""

    name = "constant"
    torque: Annotated[Vector3, vector("torque", "Torque, in body axes.", source="torque")]

    def make(self, context: Context) -> HarmonicTorque:
        """Torque."""
        return HarmonicTorque(0.0, constant=self.torque)


@dataclass(frozen=True, eq=False)
class Harmonic(Kind):
    """Torque of one frequency in body axes (`gyrostat.spacecraft.HarmonicTorque`)."""

    name = "harmonic"
    rate: Annotated[
        Scalar, positive("speed", None, "Angular frequency, such as that of the orbit.")
    ]
    cosine: Annotated[
        Vector3, vector("torque", "Amplitude of cos(rate × time), in body axes.", source="torque")
    ]
    sine: Annotated[
        Vector3, vector("torque", "Amplitude of sin(rate × time), in body axes.", source="torque")
    ]

    def make(self, context: Context) -> HarmonicTorque:
        """Torque."""
        return HarmonicTorque(self.rate, cosine=self.cosine[None], sine=self.sine[None])
