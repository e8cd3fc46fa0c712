"""Momentum envelope of the working wheels at rest, and its intersection with a sphere."""

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog, lsq_linear

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector

RANK_TOLERANCE = 1e-6
"""Of the singular values of the axes: drawings round, and three axes of a plane are a plane."""
TOLERANCE = 1e-9
"""Of lengths and momenta, relative: what rounding leaves."""
SMALL = 1e-8
"""Weight of the size of a solution against its residual, relative: the root of rounding."""
MOST_WHEELS = 16


@dataclass(frozen=True)
class MomentumSet:
    """The set {frozen + axes h : |h_i| <= limits_i} in body axes: a zonotope in a plane or line.

    Every list of normals below follows from the axes; `of` makes them.

    Attributes:
        axes: (3, N) axes of the working wheels, unit length, as far as they lie in their span.
        frozen: (3,) momentum of the wheels that work no more, N·m·s.
        limits: (N,) largest momentum of each wheel, N·m·s, may be infinite.
        rank: how many directions the axes span, 0 to 3.
        normals: (3 - rank, 3) orthonormal, orthogonal to every axis.
        facets: (F, 3) unit normals of the pairs of opposite facets, in the span of the axes.
        supports: (F,) largest `facets` @ axes h, N·m·s, may be infinite.
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
        """The set of wheels.

        Args:
            axes: (3, N) unit axes of the working wheels; N may be 0.
            limits: (N,) largest momentum of each, N·m·s.
            frozen: (3,) momentum of the others, N·m·s.

        Raises:
            InputError: more wheels than any spacecraft has.
        """
        if axes.shape[1] > MOST_WHEELS:
            raise InputError(
                f"working wheels: found {axes.shape[1]}, expected at most {MOST_WHEELS}"
            )
        left, values, _ = np.linalg.svd(axes, full_matrices=True)
        rank = int(np.sum(values > RANK_TOLERANCE)) if axes.size else 0
        span, normals = left[:, :rank], left[:, rank:].T
        axes = span @ (span.T @ axes)
        facets = _facets(axes, rank, normals)
        return MomentumSet(
            axes, frozen, limits, rank, normals, facets, _support(facets @ axes, limits)
        )

    def support(self, direction: Vector) -> float:
        """Largest component of the set in a direction (3,), N·m·s."""
        return float(direction @ self.frozen + _support(direction @ self.axes, self.limits))

    def load(self, momentum: NDArray[np.float64]) -> NDArray[np.float64]:
        """Least share of its limit that the most loaded wheel needs to hold a momentum.

        The gauge of the zonotope: how much it must be stretched to reach the momentum.

        Args:
            momentum: (..., 3) in body axes, in the plane or line of the set, N·m·s.

        Returns:
            (...): 0 without limits, above 1 where the wheels cannot hold it.
        """
        if not len(self.facets):
            return np.zeros(momentum.shape[:-1])
        return np.max(np.abs((momentum - self.frozen) @ self.facets.T) / self.supports, axis=-1)

    def holds(self, momentum: NDArray[np.float64], slack: float) -> NDArray[np.bool_]:
        """Whether momenta (..., 3) lie in the set, but for `slack`, N·m·s."""
        beside = momentum - self.frozen
        held = np.all(np.abs(beside @ self.normals.T) <= slack, axis=-1)
        return held & np.all(np.abs(beside @ self.facets.T) <= self.supports + slack, axis=-1)

    def wheel_momentum(self, momentum: Vector) -> Vector:
        """Momenta (N,) of the working wheels that hold `momentum` (3,) with the most margin, N·m·s.

        Where the axes are independent, or nothing limits them, those of least norm; otherwise the
        largest share of a limit is the least possible, by a small linear program.
        """
        wanted, inverse = momentum - self.frozen, np.linalg.pinv(self.axes, rcond=RANK_TOLERANCE)
        count = len(self.limits)
        limited = np.isfinite(self.limits)
        if count == self.rank or not np.any(limited):
            return inverse @ wanted
        span = np.linalg.svd(self.axes)[0][:, : self.rank].T
        share = np.where(limited, self.limits, 0.0)[limited]
        rows = np.eye(count)[limited]
        solved = linprog(
            np.r_[np.zeros(count), 1.0],
            A_ub=np.block([[rows, -share[:, None]], [-rows, -share[:, None]]]),
            b_ub=np.zeros(2 * len(rows)),
            A_eq=np.c_[span @ self.axes, np.zeros(self.rank)],
            b_eq=span @ wanted,
            bounds=[(None, None)] * count + [(0.0, None)],
        )
        found = solved.x[:-1]
        # the program leaves 1e-7; what is held must be what is there
        return found + inverse @ (wanted - self.axes @ found)

    @cached_property
    def least(self) -> float:
        """Smallest magnitude in the set, N·m·s."""
        return float(np.linalg.norm(self.frozen + self.axes @ self._closest(-self.frozen)))

    @cached_property
    def most(self) -> float:
        """Largest magnitude in the set, N·m·s: at a corner."""
        if not np.all(np.isfinite(self.limits)):
            return np.inf
        return largest(self.axes * self.limits, self.frozen)

    def _closest(self, wanted: Vector) -> Vector:
        return box_least_squares(self.axes, wanted, self.limits)

    def on_sphere(
        self,
        radius: float,
        objective: Vector,
        normals: Matrix | None = None,
        offsets: Vector | None = None,
    ) -> Matrix:
        """Where a linear function can be extreme on the part of the set that lies on a sphere.

        The extreme points of `objective` on the sphere itself, on each circle in which a bounding
        plane cuts it, and the points where two such circles meet: on every part of the sphere's
        share of the set, the largest and the smallest value are attained at one of them.

        Args:
            radius: of the sphere about zero, N·m·s, above 0.
            objective: (3,) of the linear function.
            normals: (K, 3) of planes on which the points must lie as well.
            offsets: (K,) of these planes.

        Returns:
            (M, 3) those of the points that lie in the set; none where the sphere misses it.
        """
        if normals is None or offsets is None:
            normals, offsets = np.zeros((0, 3)), np.zeros(0)
        fixed = np.concatenate([self.normals, normals])
        levels = np.concatenate([self.normals @ self.frozen, offsets])
        free = 2 - (np.linalg.matrix_rank(fixed, tol=TOLERANCE) if len(fixed) else 0)
        middle = self.facets @ self.frozen
        # the others lie beyond the sphere
        near = self.supports <= (radius + np.abs(middle)) * (1.0 + TOLERANCE)
        bounds = np.concatenate([self.facets[near]] * 2)
        edges = np.concatenate([middle[near] + self.supports[near], (middle - self.supports)[near]])
        found = []
        for count in range(max(free, 0) + 1):
            subsets = list(combinations(range(len(bounds)), count))
            chosen = np.array(subsets, dtype=int).reshape(len(subsets), count)
            planes = np.concatenate(
                [np.broadcast_to(fixed, (len(chosen), *fixed.shape)), bounds[chosen]], axis=1
            )
            heights = np.concatenate(
                [np.broadcast_to(levels, (len(chosen), len(levels))), edges[chosen]], axis=1
            )
            found.append(_extremes(planes, heights, radius, objective))
        points = np.concatenate(found)
        slack = TOLERANCE * (radius + float(np.linalg.norm(self.frozen)))
        return points[self.holds(points, slack)]


def largest(edges: Matrix, start: Vector) -> float:
    """Largest length of start + edges s over signs s: edges (3, N), start (3,)."""
    signs = np.array(list(product((-1.0, 1.0), repeat=edges.shape[1])))
    return float(np.max(np.linalg.norm(start + signs @ edges.T, axis=1)))


def box_least_squares(
    matrix: Matrix, wanted: Vector, limits: Vector, size: float | None = None
) -> Vector:
    """The h with |h_i| <= limits_i that brings matrix h closest to `wanted`.

    Where many do, a small one: among parallel wheels rounding alone would choose, and badly. What
    this costs in the residual is below rounding. `size` is that of the matrix, if not its norm.
    """
    count = matrix.shape[1]
    if not count:
        return np.zeros(0)
    rows = np.vstack([matrix, SMALL * (size or np.linalg.norm(matrix)) * np.eye(count)])
    aims = np.concatenate([wanted, np.zeros(count)])
    return lsq_linear(rows, aims, (-limits, limits), method="bvls", tol=1e-14).x


def _facets(axes: Matrix, rank: int, normals: Matrix) -> Matrix:
    """Normals of the facets: in the span of the axes, orthogonal to rank - 1 of them."""
    columns = axes.T
    if rank == 3:
        pairs = np.array(list(combinations(range(len(columns)), 2)))
        found = np.cross(columns[pairs[:, 0]], columns[pairs[:, 1]])
    elif rank == 2:
        found = np.cross(normals[0], columns)
    elif rank == 1:
        found = columns[:1]
    else:
        return np.zeros((0, 3))
    lengths = np.linalg.norm(found, axis=1)
    kept = lengths > RANK_TOLERANCE
    return found[kept] / lengths[kept, None]


def _support(components: NDArray[np.float64], limits: Vector) -> NDArray[np.float64]:
    """Sum of |components| limits over the last axis, where no component times no limit is 0."""
    across = np.abs(components)
    with np.errstate(invalid="ignore"):
        return np.sum(np.where(across > TOLERANCE, across * limits, 0.0), axis=-1)


def _extremes(
    planes: NDArray[np.float64], heights: Matrix, radius: float, objective: Vector
) -> Matrix:
    """Both extremes of a linear function on each of B circles planes @ b = heights, |b| = radius.

    Args:
        planes: (B, K, 3) normals.
        heights: (B, K).
        radius: of the sphere.
        objective: (3,).

    Returns:
        (M, 3): two for each circle that exists; any two opposite ones where all are alike.
    """
    inverse = np.linalg.pinv(planes, rcond=TOLERANCE)
    centre = (inverse @ heights[..., None])[..., 0]
    consistent = np.abs((planes @ centre[..., None])[..., 0] - heights) <= TOLERANCE * radius
    remaining = np.eye(3) - inverse @ planes
    along = remaining @ (objective / np.linalg.norm(objective))
    alike = np.linalg.norm(along, axis=-1) <= TOLERANCE
    columns = np.linalg.norm(remaining, axis=-2)
    any_column = np.take_along_axis(remaining, np.argmax(columns, axis=-1)[:, None, None], axis=2)
    along = np.where(alike[:, None], any_column[..., 0], along)
    length = np.linalg.norm(along, axis=-1, keepdims=True)
    # nothing is left of space where three planes meet: the point itself or none
    along = np.where(length > TOLERANCE, along / np.maximum(length, TOLERANCE), 0.0)
    squared = radius**2 - np.sum(centre**2, axis=-1)
    reach = np.sqrt(np.maximum(squared, 0.0))[:, None] * along
    points = np.concatenate([centre + reach, centre - reach])
    exists = np.tile(np.all(consistent, axis=-1), 2)
    return points[exists & (np.abs(np.linalg.norm(points, axis=-1) - radius) <= TOLERANCE * radius)]
