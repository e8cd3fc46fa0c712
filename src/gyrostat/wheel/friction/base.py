"""Interface of static friction models."""

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
    """Dataclass field for a model parameter.

    Args:
        dimension: Key of `gyrostat.core.units.SI_UNIT` that gives the unit of the parameter.
    """
    return eqx.field(metadata={"dimension": dimension})


class Friction(Checked):
    """Static friction curve: torque that opposes the rotation of a wheel.

    A model is one final subclass in its own file in this package, with fields declared by
    `parameter`, each of value 0 or more, and the methods below. It is then available in the command
    line, the model file and identification under its `name`.
    """

    name: ClassVar[str]
    """Name in model files and on the command line."""
    title: ClassVar[str]
    """Name in tables and figures."""
    held_by_default: ClassVar[tuple[str, ...]] = ()
    """Parameters that a bench record rarely determines; identification keeps them fixed by
    default."""
    vanishing_at: ClassVar[Mapping[str, str]] = {}
    """Parameter -> the parameter at whose value its effect vanishes (static -> coulomb). The effect
    of a parameter that is not listed vanishes at zero."""

    @abc.abstractmethod
    def torque(self, speed: Scalar, direction: Scalar) -> Scalar:
        """Friction torque on the rotor with opposite sign, to be subtracted from the motor torque.

        Args:
            speed: Wheel speed, rad/s, scalar.
            direction: Fixed direction of rotation, +1 or -1. For a fixed direction, the curve is
                smooth in speed, also slightly beyond zero, so that a crossing can be located.

        Returns:
            Torque, N·m, scalar.
        """

    def viscous_torque(self, speed: Scalar, direction: Scalar) -> Scalar:
        """Part of `torque` that does not act through bristles, N·m; zero by default."""
        return 0.0 * speed

    @abc.abstractmethod
    def speed_scale(self) -> Scalar:
        """Smallest speed range over which the curve bends, rad/s; infinite for a straight line."""

    @classmethod
    @abc.abstractmethod
    def from_coulomb(cls, viscous: float, coulomb: float) -> Self:
        """Model with the curve of viscous plus Coulomb friction.

        Args:
            viscous: Viscous coefficient, N·m·s/rad.
            coulomb: Coulomb torque, N·m.
        """

    def check_own(self) -> None:
        """Validate parameters.

        Raises:
            InputError: A parameter is negative or not finite, or a speed is zero.
        """
        for name, dimension in self.dimensions().items():
            value, unit = getattr(self, name), SI_UNIT[dimension]
            require(name, value, unit, positive=dimension == "speed")

    def breakaway_torque(self, direction: Scalar) -> Scalar:
        """Breakaway torque of the wheel at rest, N·m, in a direction of rotation (±1)."""
        return direction * self.torque(0.0, direction)

    @classmethod
    def dimensions(cls) -> dict[str, str]:
        """Parameter names in order -> dimension (a key of `gyrostat.core.units.SI_UNIT`)."""
        return {f.name: f.metadata["dimension"] for f in dataclasses.fields(cls)}

    @classmethod
    def of(cls, **values: Scalar) -> Self:
        """Model from the values of `parameters`."""
        return cls(**values)

    def parameters(self) -> dict[str, Scalar]:
        """Parameter names in order -> values in SI units."""
        return {name: getattr(self, name) for name in self.dimensions()}
