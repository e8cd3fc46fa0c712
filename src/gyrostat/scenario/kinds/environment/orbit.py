"""Circular Earth orbit."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.errors import InputError
from gyrostat.scenario.circular_orbit import HasOrbit
from gyrostat.scenario.environment_kind import EnvironmentKind
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.schema import size, vector
from gyrostat.spacecraft import GravityGradient, HarmonicTorque, TorqueModel


@dataclass(frozen=True, eq=False)
class CircularEnvironment(HasOrbit, EnvironmentKind):
    """Circular Earth orbit: gravity gradient, a constant torque and one with the orbital period.

    See `gyrostat.spacecraft.GravityGradient` and `gyrostat.spacecraft.HarmonicTorque`.
    """

    name = "orbit"
    torque_names = ("gravity_gradient", "harmonic")
    gravity_gradient: Annotated[
        Scalar, size("1", 1.0, "Factor on the gravity gradient torque.", source="gravity gradient")
    ]
    cosine_torque: Annotated[
        Vector3,
        vector(
            "torque",
            "Amplitude of the torque cos(orbital rate × time), in body axes.",
            source="torque of the orbital period",
        ),
    ]
    sine_torque: Annotated[
        Vector3,
        vector(
            "torque",
            "Amplitude of the torque sin(orbital rate × time), in body axes.",
            source="torque of the orbital period",
        ),
    ]

    @classmethod
    def check(cls, place: str, scenario: Scenario) -> None:
        """Check that there is no other orbit."""
        if scenario.orbit != "none":
            raise InputError(
                f"key {place}.kind: found {cls.name} beside [orbit], expected constant, with "
                "further torques such as gravity_gradient in [[environment.torque]]"
            )

    def torques(self) -> tuple[TorqueModel, ...]:
        """See `EnvironmentKind.torques`."""
        orbit = self.circular()
        harmonic = HarmonicTorque(
            orbit.rate, cosine=self.cosine_torque[None], sine=self.sine_torque[None]
        )
        return GravityGradient(orbit, self.gravity_gradient), harmonic
