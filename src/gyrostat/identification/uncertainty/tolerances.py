"""Tolerances of the values given with a record: inertia, scales of current and speed, clock.

The record cannot distinguish these errors from the parameters. They are propagated by the
sensitivities of the fit and never estimated (consider parameters: Schmidt 1966; Tapley, Schutz and
Born 2004, "Statistical orbit determination", section 6.2).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.pictured import Described
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.units import SI_UNIT
from gyrostat.identification.fit.prediction import Linearisation, SpeedPrediction

TOLERANCES = ("inertia", "current_scale", "speed_scale", "clock")
"""Quantities with a tolerance. Each error is relative: true value over given value, minus one."""

LARGEST = 0.5
"""Largest relative tolerance, one sigma, for which linear propagation is valid."""


@dataclass(frozen=True)
class Propagated(Described):
    """Errors of the estimates caused by tolerances.

    Attributes:
        names: Names of the k tolerances.
        roots: True value minus estimate for an error of one sigma of each tolerance, (n, k), SI.
        sigmas: Relative tolerances, one sigma, (k,).
    """

    names: tuple[str, ...]
    roots: Matrix
    sigmas: tuple[float, ...]

    def covariance(self) -> Matrix:
        """Contribution to the covariance of the estimates, (n, n)."""
        return self.roots @ self.roots.T


def check_tolerances(tolerances: Mapping[str, float], free: Sequence[str] = ()) -> dict[str, float]:
    """Validate tolerances, and omit those of zero.

    Args:
        tolerances: Name -> relative tolerance, one sigma.
        free: Names of estimated parameters.

    Raises:
        InputError: A name is unknown, a value is out of range, or the inertia is estimated.
    """
    for name, sigma in tolerances.items():
        if name not in TOLERANCES:
            expected = ", ".join(TOLERANCES)
            raise InputError(f"tolerance: found {name!r}, expected one of {expected}")
        if not 0.0 <= sigma <= LARGEST:
            raise InputError(
                f"tolerance of {name}: found {sigma:g}, expected a fraction from 0 to {LARGEST:g}"
            )
    if tolerances.get("inertia") and "inertia" in free:
        raise InputError(
            "inertia: found a tolerance of a parameter that is estimated, expected one of the two "
            "(use a prior instead of the tolerance)"
        )
    return {name: sigma for name, sigma in tolerances.items() if sigma > 0.0}


def _column(
    name: str, prediction: SpeedPrediction, linear: Linearisation, values: Vector
) -> Vector:
    """Change of a modelled speed per relative error of a given quantity, (N,), rad/s."""
    places = {n: k for k, n in enumerate(prediction.names)}

    def scaled(parameter: str) -> Vector:
        return values[places[parameter]] * linear.jacobian[:, places[parameter]]

    if name == "inertia":
        return scaled("inertia")
    if name == "current_scale":
        # the scale applies to the recorded current, the bias is added afterwards
        return scaled("motor_constant") - scaled("current_bias")
    if name == "speed_scale":
        return -linear.speed
    # a longer interval has the effect of a smaller inertia
    return -scaled("inertia")


def propagate(
    tolerances: Mapping[str, float],
    prediction: SpeedPrediction,
    linear: Sequence[Linearisation],
    values: Vector,
    sigmas: Sequence[float],
    index: Sequence[int],
    information: Matrix,
) -> Propagated:
    """Propagate tolerances to the estimates of a least-squares fit.

    Args:
        tolerances: Name -> relative tolerance, one sigma.
        prediction: Records and friction model.
        linear: Linearisation of each record at the fit.
        values: All parameters of the prediction, (p,), SI.
        sigmas: Noise of the measured speed of each record, rad/s.
        index: Indices of the n estimated parameters.
        information: Information matrix of the a-priori knowledge, (n, n).
    """
    names = tuple(tolerances)
    rows, right = [], []
    for record, each, sigma in zip(prediction.records, linear, sigmas, strict=True):
        columns = [tolerances[n] * _column(n, prediction, each, values) for n in names]
        rows.append(each.jacobian[record.valid][:, index] / sigma)
        right.append(np.column_stack(columns)[record.valid] / sigma)
    jacobian = np.vstack(rows)
    size = np.sqrt(np.maximum(np.diag(jacobian.T @ jacobian + information), np.finfo(float).tiny))
    eigenvalues, vectors = np.linalg.eigh(information / np.outer(size, size))
    prior_rows = np.sqrt(np.maximum(eigenvalues, 0.0))[:, None] * vectors.T
    system = np.vstack([jacobian / size, prior_rows])
    # the true parameters compensate for the error of the given quantity
    target = -np.vstack([*right, np.zeros((len(size), len(names)))])
    roots = np.linalg.lstsq(system, target, rcond=1e-12)[0] / size[:, None]
    return Propagated(names, roots, tuple(tolerances.values()))


DEDICATED: dict[str, dict[str, dict[str, float]]] = {
    "steady": {
        "torque": {"current_scale": 1.0},
        "viscous": {"current_scale": 1.0, "speed_scale": -1.0},
        "speed": {"speed_scale": 1.0},
    },
    "coast": {
        "torque": {"inertia": 1.0, "speed_scale": 1.0, "clock": -1.0},
        "viscous": {"inertia": 1.0, "clock": -1.0},
    },
    "inverse at a known motor_constant": {
        "torque": {"current_scale": 1.0},
        "viscous": {"current_scale": 1.0, "speed_scale": -1.0},
        "inertia": {"current_scale": 1.0, "speed_scale": -1.0, "clock": 1.0},
        "current": {"current_scale": 1.0},
    },
    "inverse at a known inertia": {
        "torque": {"inertia": 1.0, "speed_scale": 1.0, "clock": -1.0},
        "viscous": {"inertia": 1.0, "clock": -1.0},
        "motor_constant": {
            "inertia": 1.0,
            "speed_scale": 1.0,
            "clock": -1.0,
            "current_scale": -1.0,
        },
        "current": {"current_scale": 1.0},
    },
    "torque-step": {
        "motor_constant": {"inertia": 1.0, "speed_scale": 1.0, "clock": -1.0, "current_scale": -1.0}
    },
}
"""Method -> dimension of an estimate -> its exponents as a power law of the given quantities."""


def propagate_dedicated(
    tolerances: Mapping[str, float], method: str, dimensions: Sequence[str], values: Vector
) -> Propagated:
    """Propagate tolerances to the estimates of a bench method, by its scaling law.

    Args:
        tolerances: Name -> relative tolerance, one sigma.
        method: Key of `DEDICATED`.
        dimensions: Dimensions of the n estimates.
        values: Estimates, (n,), SI.
    """
    law = DEDICATED[method]
    unknown = [dimension for dimension in dimensions if dimension not in SI_UNIT]
    if unknown:
        raise InputError(
            f"--method {method}: found a tolerance with a parameter in {unknown[0]}, expected no "
            "tolerance, or --method batch"
        )
    exponents = [[law.get(d, {}).get(name, 0.0) for name in tolerances] for d in dimensions]
    sigmas = np.array(list(tolerances.values()))
    roots = np.array(exponents).reshape(len(dimensions), len(sigmas)) * sigmas * values[:, None]
    return Propagated(tuple(tolerances), roots, tuple(tolerances.values()))
