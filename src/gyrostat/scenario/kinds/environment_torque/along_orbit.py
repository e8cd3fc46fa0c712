"""Torques that need the tables along an orbit."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.component import ORBIT, SURFACES, Context, Kind
from gyrostat.scenario.schema import positive, size, vector
from gyrostat.spacecraft import AerodynamicTorque, ResidualDipole, SolarPressureTorque


@dataclass(frozen=True, eq=False)
class ResidualDipoleKind(Kind):
    """Torque of the magnetic field of the Earth on a residual dipole moment.

    See `gyrostat.spacecraft.ResidualDipole`.
    """

    name = "residual_dipole"
    needs = frozenset({ORBIT})
    dipole: Annotated[
        Vector3, vector("magnetic_dipole", "Residual dipole moment, in body axes.", source="torque")
    ]

    def make(self, context: Context) -> ResidualDipole:
        """Torque."""
        assert context.orbit is not None
        return ResidualDipole(context.orbit, self.dipole)


@dataclass(frozen=True, eq=False)
class Aerodynamic(Kind):
    """Air drag on the surfaces of the spacecraft (`gyrostat.spacecraft.AerodynamicTorque`)."""

    name = "aerodynamic"
    needs = frozenset({ORBIT, SURFACES})
    drag_coefficient: Annotated[Scalar, positive("1", 2.2, "Drag coefficient of every facet.")]
    density_scale: Annotated[Scalar, size("1", 1.0, "Factor on the air density.", source="torque")]

    def make(self, context: Context) -> AerodynamicTorque:
        """Torque."""
        assert context.orbit is not None
        return AerodynamicTorque(context.orbit, **self.options())


@dataclass(frozen=True, eq=False)
class SolarPressure(Kind):
    """Solar radiation pressure on the surfaces of the spacecraft, with eclipses.

    See `gyrostat.spacecraft.SolarPressureTorque`.
    """

    name = "solar_pressure"
    needs = frozenset({ORBIT, SURFACES})
    scale: Annotated[Scalar, size("1", 1.0, "Factor on the pressure.", source="torque")]

    def make(self, context: Context) -> SolarPressureTorque:
        """Torque."""
        assert context.orbit is not None
        return SolarPressureTorque(context.orbit, **self.options())
