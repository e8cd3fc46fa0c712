"""Error sources of annex C, tables C-1 and C-2, and the choices that it leaves open."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.special import ndtri

from gyrostat.core.types import Vector
from gyrostat.scenario.requirement import Requirement

ARCSEC = np.radians(1.0 / 3600.0)
AXES = ("x", "y", "z")
"""Body axes; x is the boresight of the payload."""
REQUIRED = {"APE": (60.0, 20.0, 20.0), "RPE": (30.0, 10.0, 10.0)}
"""Required values about the axes, arcsec, C.1."""
LEVEL, FACTOR = 0.95, 2.0
"""Probability of the requirements, and the multiple of sigma that the annex takes for it."""
WINDOW = 30.0
"""Window of RPE, s, C.1."""
PERIOD = 0.1
"""Period of the samples, s: random errors are uncorrelated between them."""
ORBIT, VIBRATION = 5700.0, 0.73
"""Periods of slow and of fast sinusoidal errors, s."""
SAMPLES = round(WINDOW / PERIOD) + 1
"""Samples of a member of the ensemble: one window at a random time of its orbit."""
PRIME = 43
"""Strata of each parameter and phase; the ensemble has its square of members."""


class Parameter(NamedTuple):
    """Ensemble parameter of an error, such as its amplitude: one value in each member.

    Attributes:
        mean: Mean, arcsec.
        sigma: Standard deviation, arcsec.
        shape: Quantile function of a distribution with mean 0 and standard deviation 1.
    """

    mean: float
    sigma: float
    shape: Callable[[Vector], Vector] = ndtri

    @classmethod
    def uniform(cls, low: float, high: float) -> "Parameter":
        """Parameter that lies anywhere between two bounds, arcsec."""
        return cls(0.5 * (low + high), (high - low) / np.sqrt(12.0), _unit_uniform)

    def drawn(self, shares: Vector) -> Vector:
        """Values at shares of the members from 0 to 1, arcsec."""
        return self.mean + self.sigma * self.shape(shares)


def _unit_uniform(shares: Vector) -> Vector:
    return np.sqrt(12.0) * (shares - 0.5)


class Source(NamedTuple):
    """Source of errors about the three axes.

    Attributes:
        label: Name for people.
        behaviour: "bias", "random", or the period of a sinusoid, s.
        parameters: Bias, standard deviation over time or amplitude about each axis.
    """

    label: str
    behaviour: str | float
    parameters: tuple[Parameter, Parameter, Parameter]

    def histories(
        self, shares: Float[np.ndarray, "members 6"], random: np.random.Generator
    ) -> Float[np.ndarray, "members samples 3"]:
        """Errors of all members over a window, rad.

        Args:
            shares: Shares of the members for the parameters and the phases of the three axes.
            random: Generator of random errors.
        """
        sizes = np.stack([p.drawn(s) for p, s in zip(self.parameters, shares.T, strict=False)], 1)
        sizes = ARCSEC * sizes[:, None]
        if self.behaviour == "bias":
            return np.repeat(sizes, SAMPLES, axis=1)
        if self.behaviour == "random":
            return sizes * random.standard_normal((len(shares), SAMPLES, 3))
        turns = PERIOD * np.arange(SAMPLES)[:, None] / float(self.behaviour)
        return sizes * np.sin(2.0 * np.pi * (turns + shares[:, None, 3:]))


def _equal(parameter: Parameter) -> tuple[Parameter, Parameter, Parameter]:
    return parameter, parameter, parameter


def _normal(x: float, y: float, z: float) -> tuple[Parameter, Parameter, Parameter]:
    return Parameter(0.0, x), Parameter(0.0, y), Parameter(0.0, z)


SOURCES: dict[str, Source] = {
    "star_tracker_noise": Source(
        "star tracker, random",
        "random",
        (Parameter(10.0, 0.0), Parameter(5.0, 0.0), Parameter(5.0, 0.0)),
    ),
    "star_tracker_bias": Source(
        "star tracker, bias", "bias", _normal(20.0 / 3.0, 10.0 / 3.0, 10.0 / 3.0)
    ),
    "controller": Source("controller, actuators", "random", _equal(Parameter(1.0, 3.0))),
    "thermoelastic": Source("thermoelastic", ORBIT, _equal(Parameter.uniform(0.0, 4.0))),
    "misalignment": Source("misalignment", "bias", _equal(Parameter.uniform(-5.0, 5.0))),
    "targeting": Source("targeting", ORBIT, _normal(5.0, 1.0, 5.0)),
    "flexible": Source("flexible modes, slosh", VIBRATION, _normal(3.0, 5.0, 3.0)),
}
"""Sources of table C-2; 6.67 and 3.33 arcsec are printed, 3 sigma of 20 and 10."""


def requirement(index: str) -> Requirement:
    """Requirement on the error vector for an index of `REQUIRED`; its value is not used."""
    window = WINDOW if index == "RPE" else 0.0
    return Requirement(index.lower(), index, ARCSEC, LEVEL, window=window)
