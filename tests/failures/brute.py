"""Failures drawn at random, and what sampling and Euler's equations say of them."""

import numpy as np
from scipy.spatial.transform import Rotation

from gyrostat.spacecraft import Spacecraft
from gyrostat.wheel import WheelArray


def unit(random, *shape):
    drawn = random.normal(size=(*shape, 3))
    return drawn / np.linalg.norm(drawn, axis=-1, keepdims=True)


def spacecraft(axes, limit=3.0, inertia=None):
    """Wheels on axes (N, 3), given as rows."""
    axes = np.asarray(axes, dtype=float)
    return Spacecraft(
        inertia=np.diag([8.0, 12.0, 16.0]) if inertia is None else inertia,
        wheels=WheelArray(
            axes=axes.T,
            inertia=np.full(len(axes), 1e-3),
            torque_limit=0.1,
            momentum_limit=limit,
        ),
    )


class Drawn:
    """One failure: working axes of a wanted rank, at most one more wheel than that."""

    def __init__(self, seed):
        random = np.random.default_rng(seed)
        self.random = random
        self.rank = int(random.choice([3, 2, 2, 1, 0]))
        spare = int(self.rank > 0 and random.random() < 0.4)
        basis = unit(random, 3) if self.rank < 3 else np.eye(3)
        rows = random.normal(size=(self.rank + spare, self.rank)) @ basis[: self.rank]
        if self.rank == 3 and not spare:
            rows = unit(random, 3)
        self.axes = rows / np.linalg.norm(rows, axis=1, keepdims=True)
        self.lost = unit(random, int(random.integers(1, 3)))
        self.frozen_values = random.uniform(-1.5, 1.5, len(self.lost)) * random.integers(0, 2)
        self.limits = random.uniform(0.3, 2.0, len(self.axes))
        if random.random() < 0.4:
            self.limits[random.random(len(self.axes)) < 0.6] = np.inf
        self.frozen = self.frozen_values @ self.lost
        self.momentum = unit(random) * random.uniform(0.1, 3.5)
        if self.rank == 0 and np.any(self.frozen) and random.random() < 0.7:
            # what is frozen is all there is
            self.momentum *= np.linalg.norm(self.frozen) / np.linalg.norm(self.momentum)
        turn = Rotation.random(random_state=seed).as_matrix()
        self.inertia = turn @ np.diag(random.uniform(8.0, 15.0, 3)) @ turn.T
        self.target = Rotation.random(random_state=seed + 1).as_quat(scalar_first=True)
        self.failed = {len(self.axes) + k: float(v) for k, v in enumerate(self.frozen_values)}

    @property
    def body(self):
        limits = np.concatenate([self.limits, np.full(len(self.lost), 5.0)])
        return spacecraft(np.concatenate([self.axes, self.lost]), limits, self.inertia)

    def holds(self, momentum, slack=1e-7):
        """Whether wheels within their limits hold momenta (M, 3), without facets of any kind."""
        beside = momentum - self.frozen
        if not len(self.axes):
            return np.linalg.norm(beside, axis=1) <= slack
        least = beside @ np.linalg.pinv(self.axes, rcond=1e-9)
        fits = np.linalg.norm(beside - least @ self.axes, axis=1) <= slack
        # one wheel more than directions: the momenta may slide along one line
        low, high = np.full(len(momentum), -np.inf), np.full(len(momentum), np.inf)
        _, _, right = np.linalg.svd(self.axes.T)
        slide = right[-1] if len(self.axes) > self.rank else np.zeros(len(self.axes))
        for k, limit in enumerate(self.limits):
            if abs(slide[k]) > 1e-9:
                ends = np.stack([(s * limit - least[:, k]) / slide[k] for s in (-1.0, 1.0)])
                low, high = np.maximum(low, ends.min(0)), np.minimum(high, ends.max(0))
            else:
                fits &= np.abs(least[:, k]) <= limit + slack
        return fits & (low <= high + slack)

    def samples(self, count=20_000):
        """Many momenta of the right magnitude, on the plane or line of the wheels."""
        radius = np.linalg.norm(self.momentum)
        if self.rank == 3:
            k = np.arange(count) + 0.5
            height, around = 1.0 - 2.0 * k / count, np.pi * (1.0 + 5.0**0.5) * k
            across = np.sqrt(1.0 - height**2)
            directions = [across * np.cos(around), across * np.sin(around), height]
            return radius * np.stack(directions, axis=1)
        if self.rank == 0:
            return self.frozen[None]
        _, _, right = np.linalg.svd(self.axes)
        span = right[: self.rank]
        centre = self.frozen - span.T @ (span @ self.frozen)
        reach = radius**2 - centre @ centre
        if reach < 0.0:
            return np.zeros((0, 3))
        if self.rank == 1:
            return centre + np.sqrt(reach) * np.array([[1.0], [-1.0]]) * span
        around = np.arange(count) * 2.0 * np.pi / count
        circle = np.stack([np.cos(around), np.sin(around)], axis=1)
        return centre + np.sqrt(reach) * circle @ span


def rank_of_motion(inertia, axes, momentum):
    """Rank of the controllability matrix of Euler's equations with wheels, nothing eliminated.

    The state is turn, rate and wheel momenta about rest, J dw/dt = b x w + W u. The total momentum
    takes three dimensions away: 3 + N of its 6 + N are left where all that can change is reached.
    Time is counted so that the powers of the matrix are of one size.
    """
    count = len(axes)
    inverse = np.linalg.inv(inertia)
    gyroscopic = inverse @ np.cross(np.eye(3), momentum)
    pace = max(np.linalg.norm(gyroscopic, 2), 1e-3)
    system, entry = np.zeros((6 + count, 6 + count)), np.zeros((6 + count, count))
    system[:3, 3:6] = np.eye(3)
    system[3:6, 3:6] = gyroscopic / pace
    entry[3:6] = inverse @ axes.T * np.linalg.norm(inertia, 2)
    entry[6:] = -np.eye(count)
    blocks = [entry]
    for _ in range(5 + count):
        blocks.append(system @ blocks[-1])
    values = np.linalg.svd(np.hstack(blocks), compute_uv=False) if count else np.zeros(1)
    return int(np.sum(values > 1e-7 * max(values[0], 1e-30)))
