"""What is known of the parameters of wheels in general: priors of trend, slope and scatter."""

from collections.abc import Sequence
from dataclasses import dataclass

from gyrostat.core.units import si_unit
from gyrostat.identification.pool.laws import Law, Polynomial, viscous_laws
from gyrostat.identification.pool.oil import Oil


@dataclass(frozen=True)
class Usual:
    """Usual sizes, relative to the parameter.

    Attributes:
        slope: Standard deviation of the change with temperature, 1/°C.
        trend: Standard deviation of the change with time, 1/year.
        scatter: Largest usual scatter between records.
    """

    slope: float
    trend: float
    scatter: float


FRICTION = Usual(slope=0.01, trend=0.2, scatter=0.3)
DRIVE = Usual(slope=0.001, trend=0.01, scatter=0.015)
"""Motor constant and inertia."""
POLYNOMIAL = (0.05, 0.002)
"""Prior standard deviations of the coefficients of a polynomial for viscous friction."""


def usual(name: str) -> Usual:
    """Usual sizes of a parameter."""
    return DRIVE if name in ("motor_constant", "inertia") else FRICTION


def is_viscous(unit: str) -> bool:
    """Whether a parameter with this unit is a coefficient of viscous friction."""
    return unit == si_unit("viscous")


def laws_over_temperature(
    name: str, unit: str, reference: float | None, oil: Oil | None
) -> Sequence[Law]:
    """Equally likely laws of a parameter; without a reference, it is constant.

    Args:
        name: Name of the parameter.
        unit: SI unit.
        reference: Reference temperature, °C; None if temperatures are unknown.
        oil: Oil; None if it is unknown.
    """
    if reference is None:
        return (Polynomial(0.0, ()),)
    if is_viscous(unit):
        return viscous_laws(reference, oil)
    return (Polynomial(reference, (usual(name).slope,)),)
