"""What every static friction model provides."""

import abc
import dataclasses
from collections.abc import Mapping
from typing import Any, ClassVar, Self

import equinox as eqx

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.units import SI_UNIT
from gyrostat.core.validation import require


def parameter(dimension: str) -> Any:
    """Declare a model parameter as a dataclass field.

    Args:
        dimension: key of `gyrostat.core.units.SI_UNIT` that gives the unit of the parameter.
    """
    return eqx.field(metadata={"dimension": dimension})


class Friction(Checked):
    """A static friction curve: torque that opposes the rotation of a wheel.

    A model is one final subclass in a file of its own in this package: fields declared with
    `parameter`, each a size of 0 or more, and the methods below. It is then known to the command
    line, to the model file and to identification under its `name`.
    """

    name: ClassVar[str]
    """Name in model files and on the command line."""
    title: ClassVar[str]
    """Name in tables and figures."""
    held_by_default: ClassVar[tuple[str, ...]] = ()
    """Parameters that a bench record rarely shows; identification holds them unless asked."""
    vanishing_at: ClassVar[Mapping[str, str]] = {}
    """Parameter -> the parameter whose value makes its effect vanish (static -> coulomb).
    A parameter that is not named here has no effect at zero."""

    @abc.abstractmethod
    def torque(self, speed: Scalar, direction: Scalar) -> Scalar:
        """Friction torque on the rotor with its sign turned: subtract it from the motor torque.

        Args:
            speed: wheel speed, rad/s, scalar.
            direction: frozen sense of rotation, +1 or -1. For that sense the curve is smooth in
                speed, also slightly past zero, which is what lets a crossing be located.

        Returns:
            Torque, N·m, scalar.
        """

    def viscous_torque(self, speed: Scalar, direction: Scalar) -> Scalar:
        """The part of `torque` that bristles have no share in, N·m: none unless a model says so."""
        return 0.0 * speed

    @abc.abstractmethod
    def speed_scale(self) -> Scalar:
        """Smallest speed over which the curve bends, rad/s; infinite for a straight line."""

    @classmethod
    @abc.abstractmethod
    def from_coulomb(cls, viscous: float, coulomb: float) -> Self:
        """Build the member of this model that equals viscous plus Coulomb friction.

        Args:
            viscous: N·m·s/rad.
            coulomb: N·m.
        """

    def check_own(self) -> None:
        """Validate parameters.

        Raises:
            InputError: One is negative or not finite, or a speed is zero.
        """
        for name, dimension in self.dimensions().items():
            value, unit = getattr(self, name), SI_UNIT[dimension]
            require(name, value, unit, positive=dimension == "speed")

    def breakaway_torque(self, direction: Scalar) -> Scalar:
        """Largest torque, N·m, that the wheel at rest withstands in sense `direction` (±1)."""
        return direction * self.torque(0.0, direction)

    @classmethod
    def dimensions(cls) -> dict[str, str]:
        """Parameter names in order -> dimension (a key of `gyrostat.core.units.SI_UNIT`)."""
        return {f.name: f.metadata["dimension"] for f in dataclasses.fields(cls)}

    def parameters(self) -> dict[str, Scalar]:
        """Parameter names in order -> values, SI."""
        return {name: getattr(self, name) for name in self.dimensions()}
