"""Fit a friction curve to points of speed and torque at steady speed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.identification.fit.friction_torques import friction_torques
from gyrostat.identification.fit.least_squares import Prior, Solution, minimise
from gyrostat.identification.fit.loss import Quadratic
from gyrostat.identification.read.plateaus import MIN_SAMPLES, Plateau
from gyrostat.identification.uncertainty.observability import judge
from gyrostat.identification.uncertainty.sigmas import square_root
from gyrostat.wheel.friction import Friction

CLEAR_SUPPORT = 10.0
"""Difference of the BIC that is very strong evidence (Kass and Raftery 1995)."""
COMMON_SCATTER = 2 * MIN_SAMPLES
"""Weight of the common scatter of all plateaus in that of each one, as a number of samples. The
scatter of a short plateau is uncertain and would otherwise give it a random weight."""
FINEST = 1e-6
"""Smallest standard deviation of a torque, relative to the largest torque."""
WEAK = 10.0
"""A-priori sigma, as a multiple of the plateaus' range; keeps unobservable parameters finite."""
LOW_SPEEDS = 0.5
"""Largest Stribeck speed, relative to the fastest plateau: above it the bend is not a decrease from
the static level."""
NEAR_ENOUGH = 1.5
"""Largest speed of the slowest plateau, in Stribeck speeds, that determines the static level."""
STARTS = 6
"""Number of start values of an estimated Stribeck speed."""


@dataclass(frozen=True)
class FrictionCurve:
    """Friction curve fitted to points.

    Attributes:
        model: Friction model.
        names: Estimated parameters.
        values: Name -> value of all parameters of the model, SI.
        solution: Solution for the estimated parameters, whitened by `sigma`.
        sigma: Standard deviations of the torques, (k,), N·m.
        freedom: Degrees of freedom: points minus estimated parameters.
    """

    model: type[Friction]
    names: tuple[str, ...]
    values: Mapping[str, float]
    solution: Solution
    sigma: Vector
    freedom: int

    @property
    def misfit(self) -> float:
        """Sum of the squared whitened residuals."""
        return float(self.solution.residual @ self.solution.residual)

    @property
    def excess(self) -> float:
        """Scatter of the points about the curve relative to their own uncertainty, at least 1."""
        return max(1.0, np.sqrt(self.misfit / self.freedom)) if self.freedom > 0 else 1.0


def plateau_torques(plateaus: Sequence[Plateau], held: Mapping[str, float]) -> Vector:
    """Friction torque at each plateau, (k,), N·m: motor torque minus the torque of the drift.

    Args:
        plateaus: Plateaus, k of them.
        held: Name -> value, SI, with motor_constant; without inertia the drift is neglected.
    """
    current, drift = np.array([[p.current, p.drift] for p in plateaus]).T
    return held["motor_constant"] * current - held.get("inertia", 0.0) * drift


def _sigmas(plateaus: Sequence[Plateau], held: Mapping[str, float]) -> tuple[Vector, Vector]:
    """Standard deviations of speeds, rad/s, and torques, N·m, from the scatter of the plateaus."""
    count = np.array([p.count for p in plateaus], dtype=float)

    def shrink(values: Vector) -> Vector:
        variance = values**2 * count
        common = float(np.average(variance, weights=count))
        return np.sqrt(
            (count * variance + COMMON_SCATTER * common) / (count + COMMON_SCATTER) / count
        )

    return (
        shrink(np.array([p.speed_sigma for p in plateaus])),
        np.hypot(
            held["motor_constant"] * shrink(np.array([p.current_sigma for p in plateaus])),
            held.get("inertia", 0.0) * np.array([p.drift_sigma for p in plateaus]),
        ),
    )


def _starts(
    model: type[Friction], held: Mapping[str, float], speed: Vector, torque: Vector, sigma: Vector
) -> list[dict[str, float]]:
    """Start values of all parameters, SI: a straight line, and a range of Stribeck speeds."""
    rows = np.column_stack([np.abs(speed), np.ones(len(speed))]) / sigma[:, None]
    viscous, coulomb = np.linalg.lstsq(rows, np.sign(speed) * torque / sigma, rcond=1e-8)[0]
    first = model.start_values(viscous, coulomb)
    first |= {n: v for n, v in held.items() if n in first}
    scales = bend_speeds(model, held)
    if not scales:
        return [first]
    size = np.abs(speed)
    reach = np.geomspace(0.5 * size.min(), 0.5 * size.max(), STARTS)
    return [first | dict.fromkeys(scales, float(scale)) for scale in reach]


def _fit(
    model: type[Friction], held: Mapping[str, float], plateaus: Sequence[Plateau]
) -> FrictionCurve | None:
    """Fit a friction curve to the plateaus; None if no start succeeds."""
    speed = np.array([p.speed for p in plateaus])
    torque = plateau_torques(plateaus, held)
    speed_sigma, torque_sigma = _sigmas(plateaus, held)
    dimensions = model.dimensions()
    names = tuple(n for n in dimensions if n not in held)
    index = [list(dimensions).index(n) for n in names]
    top, reach = float(np.max(np.abs(torque))), float(np.max(np.abs(speed)))
    span = {name: top / reach**power for name, power in model.coefficients().items()}
    span |= dict.fromkeys(model.scales(), reach)
    least = FINEST * top
    sigma = np.maximum(torque_sigma, least)

    def run(start: Mapping[str, float], sigma: Vector) -> Solution | None:
        first = np.array([start[n] for n in names])
        prior = Prior(first, np.array([WEAK * span.get(n, abs(start[n]) or 1.0) for n in names]))

        def evaluate(x: Vector):
            values = dict(start) | dict(zip(names, x.tolist(), strict=True))
            if any(values[n] <= 0.0 for n in model.scales()):
                return None
            curve, _, by_theta, _ = friction_torques(model, values, speed)
            return (torque - curve) / sigma, by_theta[:, index] / sigma[:, None]

        return minimise(evaluate, first, prior, Quadratic())

    starts = _starts(model, held, speed, torque, sigma)
    fits = [(s, solution) for s in starts if (solution := run(s, sigma)) is not None]
    if not fits:
        return None
    start, solution = min(fits, key=lambda pair: pair[1].cost)
    # the uncertainty of the speed adds to that of the torque by the slope of the curve
    values = dict(start) | dict(zip(names, solution.x.tolist(), strict=True))
    steepness = friction_torques(model, values, speed).by_speed
    sigma = np.maximum(np.hypot(torque_sigma, steepness * speed_sigma), least)
    last = run(values, sigma)
    if last is None:
        return None
    values = values | dict(zip(names, last.x.tolist(), strict=True))
    return FrictionCurve(model, names, values, last, sigma, len(speed) - len(names))


def bend_speeds(model: type[Friction], held: Mapping[str, float]) -> dict[str, float]:
    """Default values of characteristic speeds, such as the Stribeck speed, that are not held."""
    default = model.start_values(0.0, 0.0)
    return {n: default[n] for n in model.held_by_default if n not in held}


def _bends(curve: FrictionCurve, held: Mapping[str, float], plateaus: Sequence[Plateau]) -> bool:
    """Whether the friction clearly decreases from its static level, at low speeds."""
    size = np.abs([p.speed for p in plateaus])
    low = all(
        size.min() <= NEAR_ENOUGH * curve.values[n] and curve.values[n] <= LOW_SPEEDS * size.max()
        for n in bend_speeds(curve.model, held)
    )
    root = square_root(curve.excess**2 * curve.solution.covariance())
    observability = judge(curve.model, {**held, **curve.values}, curve.names, root, lambda *_: "")
    falls = [
        observability[n].observable and observability[n].significance > 0.0
        for n in curve.model.vanishing_at
        if n in curve.names
    ]
    return low and curve.freedom > 0 and curve.solution.converged and any(falls)


def fit_curve(
    model: type[Friction], held: Mapping[str, float], plateaus: Sequence[Plateau]
) -> tuple[FrictionCurve | None, dict[str, float]]:
    """Fit a friction curve; characteristic speeds that are not observable are held at defaults.

    Returns:
        The curve, or None if no start succeeds; and the values held in the end.
    """
    default = bend_speeds(model, held)
    if default and len(plateaus) > len(set(model.dimensions()) - set(held)):
        curve = _fit(model, held, plateaus)
        if curve is not None and _bends(curve, held, plateaus):
            return curve, {}
    return _fit(model, {**held, **default}, plateaus), default


def preferred(line: FrictionCurve, other: FrictionCurve, count: int) -> bool:
    """Whether a curve with more parameters is very clearly better by the BIC."""
    gain = (line.misfit - other.misfit) / other.excess**2
    extra_parameters = len(other.names) - len(line.names)
    return bool(gain - extra_parameters * np.log(count) > CLEAR_SUPPORT)
