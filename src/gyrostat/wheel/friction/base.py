"""Interface of static friction models."""

import abc
import contextlib
import dataclasses
from collections.abc import Iterator, Mapping
from contextvars import ContextVar
from functools import reduce
from typing import Any, ClassVar, Self

import equinox as eqx
import numpy as np
from jax.core import Tracer

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.si_dimensions import dimension_of, speed_power
from gyrostat.core.units import si_unit
from gyrostat.core.validation import require
from gyrostat.wheel.friction.contract import check_curve, check_law, check_signs
from gyrostat.wheel.friction.nearest_curve import nearest_to_coulomb

_TRIAL: ContextVar[bool] = ContextVar("trial values", default=False)
"""Whether parameters are trial values of a fit, which may be impossible for a wheel."""


@contextlib.contextmanager
def trial_values() -> Iterator[None]:
    """Make laws without validation of their parameters."""
    token = _TRIAL.set(True)
    try:
        yield
    finally:
        _TRIAL.reset(token)


def check_concrete(law: Any) -> None:
    """Validate the signs of a law's parameters, and the curve of a law that is not of this package.

    Traced parameters and trial values are not validated.

    Raises:
        InputError: See `gyrostat.wheel.friction.contract`.
    """
    if _TRIAL.get() or any(isinstance(leaf, Tracer) for leaf in jax.tree.leaves(law)):
        return
    check_signs(law)
    if not type(law).__module__.startswith("gyrostat."):
        check_law(type(law))
        check_curve(law)


def parameter(unit: str, *, start: float | None = None, signed: bool = False) -> Any:
    """Dataclass field for a model parameter.

    Args:
        unit: SI unit such as "N·m·s²/rad²", or a key of `gyrostat.core.units.SI_UNIT` such as
            "viscous", "torque" and "speed".
        start: Start value of a fit, SI. Coefficients of a torque need none.
        signed: Whether negative values are allowed. Otherwise they are refused.

    Raises:
        InputError: The unit is unknown.
    """
    dimension = dimension_of(unit, "parameter")
    return eqx.field(metadata={"dimension": dimension, "start": start, "signed": signed})


class Friction(Checked):
    """Static friction curve: torque that opposes the rotation of a wheel.

    A model is one final subclass with fields declared by `parameter` and the method `torque`. Those
    in this package are available by their `name`, others as a class or as "FILE.py:CLASS". Concrete
    parameters are validated at construction.
    """

    name: ClassVar[str]
    """Name in model files and on the command line; by default that of the class."""
    title: ClassVar[str]
    """Name in tables and figures; by default `name`."""
    held_by_default: ClassVar[tuple[str, ...]] = ()
    """Parameters that a bench record rarely determines; identification keeps them fixed by
    default."""
    bristles: ClassVar[None] = None
    """A static curve has none; see `gyrostat.wheel.friction.bristles`."""
    vanishing_at: ClassVar[Mapping[str, str]] = {}
    """Parameter -> the parameter at whose value its effect vanishes (static -> coulomb). The effect
    of a parameter that is not listed vanishes at zero."""
    odd: ClassVar[bool] = True
    """Whether the torque is the same in both directions of rotation, F(-w) = -F(w)."""
    speed_range: ClassVar[float] = 1000.0
    """Largest speed at which the curve is validated, rad/s."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        cls.name = vars(cls).get("name", cls.__name__)
        cls.title = vars(cls).get("title", cls.name)

    def __check_init__(self) -> None:
        check_concrete(self)

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

    def speed_scale(self) -> Scalar:
        """Smallest speed range over which the curve bends, rad/s; infinite for a straight line.

        By default the smallest parameter that is a speed.
        """
        speeds = [getattr(self, name) for name in self.scales()]
        return reduce(jnp.minimum, speeds) if speeds else float("inf")

    @classmethod
    def from_coulomb(cls, viscous: float, coulomb: float) -> Self:
        """Model with the curve of viscous plus Coulomb friction, or the nearest to it.

        By default the coefficients of a torque follow from the curve, and the other parameters are
        the start values of their fields.

        Args:
            viscous: Viscous coefficient, N·m·s/rad.
            coulomb: Coulomb torque, N·m.

        Raises:
            InputError: A parameter has no start value.
        """
        return cls.of(**nearest_to_coulomb(cls, viscous, coulomb))

    @classmethod
    def start_values(cls, viscous: float, coulomb: float) -> dict[str, float]:
        """Parameters of `from_coulomb`, SI, which are not validated."""
        with trial_values():
            law = cls.from_coulomb(viscous, coulomb)
        return {name: float(value) for name, value in law.parameters().items()}

    def check_own(self) -> None:
        """Validate parameters.

        Raises:
            InputError: A parameter is negative, not finite or not of a physical magnitude, or a
                speed is zero; or a law that is not of this package is no friction.
        """
        for name, dimension in self.dimensions().items():
            value = getattr(self, name)
            size = np.abs(value) if name in self.signed() else value
            require(name, size, si_unit(dimension), positive=dimension == "speed")
        check_concrete(self)

    def breakaway_torque(self, direction: Scalar) -> Scalar:
        """Breakaway torque of the wheel at rest, N·m, in a direction of rotation (±1)."""
        return direction * self.torque(0.0, direction)

    @classmethod
    def dimensions(cls) -> dict[str, str]:
        """Parameter names in order -> dimension ; see `gyrostat.core.units.si_unit`."""
        fields = [field for field in dataclasses.fields(cls) if "dimension" in field.metadata]
        return {field.name: field.metadata["dimension"] for field in fields}

    @classmethod
    def is_shipped(cls) -> bool:
        """Whether the law is of this package, whose tests validate its curve."""
        return cls.__module__.startswith("gyrostat.")

    @classmethod
    def signed(cls) -> tuple[str, ...]:
        """Names of the parameters that may be negative."""
        return tuple(f.name for f in dataclasses.fields(cls) if f.metadata.get("signed"))

    @classmethod
    def coefficients(cls) -> dict[str, float]:
        """Parameters that are coefficients of a torque -> power of the speed in their unit."""
        units = {name: si_unit(dimension) for name, dimension in cls.dimensions().items()}
        powers = {name: speed_power(unit) for name, unit in units.items()}
        return {name: power for name, power in powers.items() if power is not None}

    @classmethod
    def scales(cls) -> tuple[str, ...]:
        """Parameters that are speeds; they are above zero."""
        return tuple(name for name, dimension in cls.dimensions().items() if dimension == "speed")

    @classmethod
    def of(cls, **values: Scalar) -> Self:
        """Model from the values of `parameters`, which are not validated: trial values of a fit."""
        with trial_values():
            return cls(**values)

    @classmethod
    def possible(cls, values: Mapping[str, float]) -> list[float]:
        """Nearest parameters of the right sign, in order.

        Args:
            values: Name -> value, SI; other names are ignored.
        """
        parameters = {name: float(values[name]) for name in cls.dimensions()}
        return [v if name in cls.signed() else max(v, 0.0) for name, v in parameters.items()]

    def parameters(self) -> dict[str, Scalar]:
        """Parameter names in order -> values in SI units."""
        return {name: getattr(self, name) for name in self.dimensions()}
