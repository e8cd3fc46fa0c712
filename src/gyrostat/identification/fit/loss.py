"""Loss functions of one whitened residual: quadratic and robust."""

import abc
from dataclasses import dataclass

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector


class Loss(abc.ABC):
    """Loss function rho(r) with weight rho'(r)/r and curvature rho''(r)."""

    @abc.abstractmethod
    def value(self, residual: Vector) -> Vector:
        """Loss of each whitened residual, (m,)."""

    @abc.abstractmethod
    def weight(self, residual: Vector) -> Vector:
        """Weight of each row in the reweighted linear problem, (m,)."""

    @abc.abstractmethod
    def curvature(self, residual: Vector) -> Vector:
        """Second derivative of rho, (m,), which determines the uncertainty."""


@dataclass(frozen=True)
class Quadratic(Loss):
    """Quadratic loss, rho = r^2 / 2, for normal noise."""

    def value(self, residual: Vector) -> Vector:
        """See `Loss.value`."""
        return 0.5 * residual**2

    def weight(self, residual: Vector) -> Vector:
        """See `Loss.weight`."""
        return np.ones_like(residual)

    def curvature(self, residual: Vector) -> Vector:
        """See `Loss.curvature`."""
        return np.ones_like(residual)


@dataclass(frozen=True)
class Huber(Loss):
    """Huber loss: quadratic up to `knee` standard deviations, linear beyond (Huber 1964)."""

    knee: float = 1.345

    def value(self, residual: Vector) -> Vector:
        """See `Loss.value`."""
        size = np.abs(residual)
        return np.where(size <= self.knee, 0.5 * residual**2, self.knee * (size - 0.5 * self.knee))

    def weight(self, residual: Vector) -> Vector:
        """See `Loss.weight`."""
        return self.knee / np.maximum(np.abs(residual), self.knee)

    def curvature(self, residual: Vector) -> Vector:
        """See `Loss.curvature`."""
        return (np.abs(residual) <= self.knee).astype(float)


@dataclass(frozen=True)
class Student(Loss):
    """Loss of Student's t with `freedom` degrees (Lange, Little and Taylor 1989)."""

    freedom: float = 4.0

    def value(self, residual: Vector) -> Vector:
        """See `Loss.value`."""
        return 0.5 * (self.freedom + 1.0) * np.log1p(residual**2 / self.freedom)

    def weight(self, residual: Vector) -> Vector:
        """See `Loss.weight`."""
        return (self.freedom + 1.0) / (self.freedom + residual**2)

    def curvature(self, residual: Vector) -> Vector:
        """See `Loss.curvature`."""
        square = residual**2
        return (self.freedom + 1.0) * (self.freedom - square) / (self.freedom + square) ** 2


LOSSES: dict[str, Loss] = {"quadratic": Quadratic(), "huber": Huber(), "student": Student()}
"""Losses by name."""


def loss_named(name: str) -> Loss:
    """Loss with a given name.

    Raises:
        InputError: No loss has this name.
    """
    if name not in LOSSES:
        raise InputError(f"loss: found {name!r}, expected one of {', '.join(LOSSES)}")
    return LOSSES[name]
