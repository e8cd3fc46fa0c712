"""Momentum envelope of the working wheels at rest, and its intersection with a sphere."""

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector

RANK_TOLERANCE = 1e-6
"""Singular value below which a direction does not count, for axes given with few digits."""
TOLERANCE = 1e-9
"""Relative tolerance of lengths and momenta for rounding errors."""
SMALL = 1e-8
"""Relative weight of the solution's norm against its residual: square root of rounding error."""
MOST_WHEELS = 16
"""Largest number of working wheels whose set is computed."""


@dataclass(frozen=True)
class MomentumSet:
    """Set {frozen + axes h : |h_i| <= limits_i} in body axes, a zonotope of dimension 0 to 3.

    The normals below follow from the axes; use `of` to compute them.

    Attributes:
        axes: Unit axes of the working wheels, (3, N), projected on their span.
        frozen: Momentum of the failed wheels, (3,), N·m·s.
        limits: Momentum limit of each working wheel, (N,), N·m·s; may be infinite.
        rank: Dimension of the span of the axes, 0 to 3.
        normals: Orthonormal vectors orthogonal to every axis, (3 - rank, 3).
        facets: Unit normals of the pairs of opposite facets, in the span of the axes, (F, 3).
        supports: Largest `facets` @ axes h, (F,), N·m·s; may be infinite.
    """

    axes: Matrix
    frozen: Vector
    limits: Vector
    rank: int
    normals: Matrix
    facets: Matrix
    supports: Vector

    @staticmethod
    def of(axes: Matrix, limits: Vector, frozen: Vector) -> "MomentumSet":
        """Momentum envelope of wheels.

        Args:
            axes: Unit axes of the working wheels, (3, N); N may be 0.
            limits: Momentum limit of each working wheel, (N,), N·m·s.
            frozen: Momentum of the other wheels, (3,), N·m·s.

        Raises:
            InputError: There are more than `MOST_WHEELS` working wheels.
        """
        if axes.shape[1] > MOST_WHEELS:
            raise InputError(
                f"working wheels: found {axes.shape[1]}, expected at most {MOST_WHEELS}"
            )
        basis, values, _ = np.linalg.svd(axes, full_matrices=True)
        rank = int(np.sum(values > RANK_TOLERANCE)) if axes.size else 0
        span, normals = basis[:, :rank], basis[:, rank:].T
        axes = span @ (span.T @ axes)
        facets = _facets(axes, rank, normals)
        return MomentumSet(
            axes, frozen, limits, rank, normals, facets, _support(facets @ axes, limits)
        )

    def support(self, direction: Vector) -> float:
        """Largest component of the set along a direction (3,), N·m·s."""
        return float(direction @ self.frozen + _support(direction @ self.axes, self.limits))

    def supports_with(self, limits: NDArray[np.float64]) -> NDArray[np.float64]:
        """Field `supports` with other limits of the wheels, (..., N) -> (..., F), N·m·s."""
        return _support(self.facets @ self.axes, limits[..., None, :])

    def load(self, momentum: NDArray[np.float64]) -> NDArray[np.float64]:
        """Smallest possible load of the most loaded wheel, relative to its limit, for a momentum.

        This is the gauge function of the zonotope: the factor by which to scale it so that it
        contains the momentum.

        Args:
            momentum: Momentum in body axes, in the span of the set, (..., 3), N·m·s.

        Returns:
            Load, (...): 0 without limits, above 1 if the wheels cannot hold the momentum.
        """
        if not len(self.facets):
            return np.zeros(momentum.shape[:-1])
        return np.max(np.abs((momentum - self.frozen) @ self.facets.T) / self.supports, axis=-1)

    def holds(self, momentum: NDArray[np.float64], slack: float) -> NDArray[np.bool_]:
        """Whether momenta (..., 3) lie in the set, with a tolerance `slack`, N·m·s."""
        offset = momentum - self.frozen
        in_span = np.all(np.abs(offset @ self.normals.T) <= slack, axis=-1)
        return in_span & np.all(np.abs(offset @ self.facets.T) <= self.supports + slack, axis=-1)

    def wheel_momentum(self, momentum: Vector) -> Vector:
        """Momenta (N,) of the working wheels that hold `momentum` (3,) with the largest margin.

        If the axes are independent or no wheel has a limit, the solution of least norm; otherwise
        the solution of least relative load, from a small linear program.
        """
        offset, inverse = momentum - self.frozen, np.linalg.pinv(self.axes, rcond=RANK_TOLERANCE)
        count = len(self.limits)
        is_limited = np.isfinite(self.limits)
        if count == self.rank or not np.any(is_limited):
            return inverse @ offset
        from scipy.optimize import linprog  # slow to import

        span = np.linalg.svd(self.axes)[0][:, : self.rank].T
        share = np.where(is_limited, self.limits, 0.0)[is_limited]
        rows = np.eye(count)[is_limited]
        solution = linprog(
            np.r_[np.zeros(count), 1.0],
            A_ub=np.block([[rows, -share[:, None]], [-rows, -share[:, None]]]),
            b_ub=np.zeros(2 * len(rows)),
            A_eq=np.c_[span @ self.axes, np.zeros(self.rank)],
            b_eq=span @ offset,
            bounds=[(None, None)] * count + [(0.0, None)],
        )
        momenta = solution.x[:-1]
        # the program's error is up to 1e-7: correct it so that the sum is exact
        return momenta + inverse @ (offset - self.axes @ momenta)

    @cached_property
    def least(self) -> float:
        """Smallest magnitude in the set, N·m·s."""
        closest = box_least_squares(self.axes, -self.frozen, self.limits)
        return float(np.linalg.norm(self.frozen + self.axes @ closest))

    @cached_property
    def most(self) -> float:
        """Largest magnitude in the set, N·m·s, attained at a vertex."""
        return largest(self.axes, self.limits, self.frozen)

    def on_sphere(
        self,
        radius: float,
        objective: Vector,
        normals: Matrix | None = None,
        offsets: Vector | None = None,
    ) -> Matrix:
        """Candidates for the extrema of a linear function on the part of a sphere inside the set.

        The extrema of `objective` on the sphere, on each circle in which a bounding plane cuts the
        sphere, and the intersections of two such circles. On every connected part of the sphere
        inside the set, the largest and the smallest value are attained at one of these points.

        Args:
            radius: Radius of the sphere about zero, N·m·s, above 0.
            objective: Gradient of the linear function, (3,).
            normals: Normals of planes that must contain the points, (K, 3).
            offsets: Offsets of these planes, (K,).

        Returns:
            The points that lie in the set, (M, 3); none if the sphere misses the set.
        """
        if normals is None or offsets is None:
            normals, offsets = np.zeros((0, 3)), np.zeros(0)
        fixed = np.concatenate([self.normals, normals])
        levels = np.concatenate([self.normals @ self.frozen, offsets])
        dimension = 2 - (np.linalg.matrix_rank(fixed, tol=TOLERANCE) if len(fixed) else 0)
        middle = self.facets @ self.frozen
        # the other facets lie outside the sphere
        cuts = self.supports <= (radius + np.abs(middle)) * (1.0 + TOLERANCE)
        bounds = np.concatenate([self.facets[cuts]] * 2)
        edges = np.concatenate([middle[cuts] + self.supports[cuts], (middle - self.supports)[cuts]])
        parts = []
        for count in range(max(dimension, 0) + 1):
            subsets = list(combinations(range(len(bounds)), count))
            indices = np.array(subsets, dtype=int).reshape(len(subsets), count)
            planes = np.concatenate(
                [np.broadcast_to(fixed, (len(indices), *fixed.shape)), bounds[indices]], axis=1
            )
            heights = np.concatenate(
                [np.broadcast_to(levels, (len(indices), len(levels))), edges[indices]], axis=1
            )
            parts.append(_extremes(planes, heights, radius, objective))
        points = np.concatenate(parts)
        slack = TOLERANCE * (radius + float(np.linalg.norm(self.frozen)))
        return points[self.holds(points, slack)]


def largest(axes: Matrix, limits: Vector, start: Vector) -> float:
    """Largest length of start + axes s over all s within the limits; infinite without limits.

    Args:
        axes: Unit vectors, (3, N).
        limits: Limits of the size of s, (N,).
        start: Vector, (3,).
    """
    if not np.all(np.isfinite(limits)):
        return np.inf
    signs = np.array(list(product((-1.0, 1.0), repeat=len(limits))))
    return float(np.max(np.linalg.norm(start + signs @ (axes * limits).T, axis=1)))


def box_least_squares(
    matrix: Matrix, wanted: Vector, limits: Vector, size: float | None = None
) -> Vector:
    """Find h with |h_i| <= limits_i that minimises |matrix h - wanted|.

    A small penalty on |h| selects one solution if there are several, as with parallel wheels;
    otherwise rounding errors would select it. The penalty changes the residual by less than
    rounding. `size` is the norm of the matrix by which the penalty is scaled; by default it is
    computed.
    """
    count = matrix.shape[1]
    if not count:
        return np.zeros(0)
    rows = np.vstack([matrix, SMALL * (size or np.linalg.norm(matrix)) * np.eye(count)])
    aims = np.concatenate([wanted, np.zeros(count)])
    solution = np.asarray(np.linalg.lstsq(rows, aims, rcond=-1)[0], dtype=np.float64)
    if np.all(np.abs(solution) <= limits):
        return solution
    from scipy.optimize import lsq_linear  # slow to import

    return lsq_linear(rows, aims, (-limits, limits), method="bvls", tol=1e-14).x


def _facets(axes: Matrix, rank: int, normals: Matrix) -> Matrix:
    """Unit normals of the facets: in the span of the axes, orthogonal to rank - 1 of them."""
    columns = axes.T
    if rank == 3:
        pairs = np.array(list(combinations(range(len(columns)), 2)))
        facets = np.cross(columns[pairs[:, 0]], columns[pairs[:, 1]])
    elif rank == 2:
        facets = np.cross(normals[0], columns)
    elif rank == 1:
        facets = columns[:1]
    else:
        return np.zeros((0, 3))
    lengths = np.linalg.norm(facets, axis=1)
    valid = lengths > RANK_TOLERANCE
    return facets[valid] / lengths[valid, None]


def _support(components: NDArray[np.float64], limits: Vector) -> NDArray[np.float64]:
    """Sum of |components| limits over the last axis, with 0 for zero times an infinite limit."""
    across = np.abs(components)
    with np.errstate(invalid="ignore"):
        return np.sum(np.where(across > TOLERANCE, across * limits, 0.0), axis=-1)


def _extremes(
    planes: NDArray[np.float64], heights: Matrix, radius: float, objective: Vector
) -> Matrix:
    """Both extrema of a linear function on each of B circles planes @ b = heights, |b| = radius.

    Args:
        planes: Normals, (B, K, 3).
        heights: Offsets of the planes, (B, K).
        radius: Radius of the sphere.
        objective: Gradient of the linear function, (3,).

    Returns:
        Two points for each circle that exists, (M, 3); two opposite points if all values are equal.
    """
    inverse = np.linalg.pinv(planes, rcond=TOLERANCE)
    centre = (inverse @ heights[..., None])[..., 0]
    consistent = np.abs((planes @ centre[..., None])[..., 0] - heights) <= TOLERANCE * radius
    projector = np.eye(3) - inverse @ planes
    along = projector @ (objective / np.linalg.norm(objective))
    alike = np.linalg.norm(along, axis=-1) <= TOLERANCE
    columns = np.linalg.norm(projector, axis=-2)
    any_column = np.take_along_axis(projector, np.argmax(columns, axis=-1)[:, None, None], axis=2)
    along = np.where(alike[:, None], any_column[..., 0], along)
    length = np.linalg.norm(along, axis=-1, keepdims=True)
    # three planes meet in a point, without any direction left: the point itself or nothing
    along = np.where(length > TOLERANCE, along / np.maximum(length, TOLERANCE), 0.0)
    squared = radius**2 - np.sum(centre**2, axis=-1)
    reach = np.sqrt(np.maximum(squared, 0.0))[:, None] * along
    points = np.concatenate([centre + reach, centre - reach])
    exists = np.tile(np.all(consistent, axis=-1), 2)
    return points[exists & (np.abs(np.linalg.norm(points, axis=-1) - radius) <= TOLERANCE * radius)]
