"""Two-wheel pointing with wrong rotors, tilted wheels, gyro bias and an external torque.

    python benchmarks/two_wheels.py [--runs 1000] [--seed 1]

As the dispersed cases of Endo, Sekiguchi and Nonaka (`gyrostat.papers`), with larger errors of the
model: rotors 5 %, moments of inertia 10 %, wheel axes 1 deg, gyro bias 10 deg/h about each axis and
a constant external torque of 1e-5 N·m. In time: error below 0.05 deg for good within 1.10 T + 40 s,
with the duration T of the fastest rotation by the torque limit, 0.1 N·m. Seeds below 1000 served
development; proof uses others.
"""

import argparse
import sys
from itertools import pairwise

import equinox as eqx
import numpy as np

from gyrostat.control import TwoWheelPointing
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.papers.endo_sekiguchi_nonaka import setup
from gyrostat.papers.endo_sekiguchi_nonaka.controllers import Candidate, evaluate
from gyrostat.papers.endo_sekiguchi_nonaka.dispersion import (
    AS_KNOWN,
    FARTHEST,
    FREQUENCIES,
    LARGEST_MOMENTUM,
    NEAREST,
    TORQUE,
    WHEEL_SPEEDS,
    Case,
    axes_of,
    case_of,
    inertia_of,
)
from gyrostat.spacecraft import SinusoidalMomentum

ROTOR_ERROR, INERTIA_ERROR, TILT = 0.05, 0.1, np.deg2rad(1.0)
BIAS, EXTERNAL = np.deg2rad(10.0 / 3600.0), 1e-5
DURATION, JUDGED = 2000.0, 1000.0
"""Duration of a run, and of its last part in which the error is judged, s."""
EDGES = (0.0, 15.0, 60.0, 150.0)


class DriftingMomentum(eqx.Module):
    """Total momentum that an external torque in inertial axes adds to."""

    base: SinusoidalMomentum
    torque: Vector3

    def __call__(self, time: Scalar) -> Vector3:
        """Total momentum, inertial axes, (3,), N·m·s."""
        return self.base(time) + time * self.torque


def unit(random: np.random.Generator) -> np.ndarray:
    """Random unit vector."""
    vector = random.normal(size=3)
    return vector / np.linalg.norm(vector)


def drawn(random: np.random.Generator) -> Case:
    """One case."""
    total, axes = inertia_of(random, INERTIA_ERROR), axes_of(random, TILT)
    rotors = setup.ROTOR * (1.0 + random.uniform(-ROTOR_ERROR, ROTOR_ERROR, 2))
    momentum = DriftingMomentum(
        SinusoidalMomentum(
            amplitude=jnp.asarray(random.uniform(0.0, LARGEST_MOMENTUM) * unit(random)),
            frequency=float(random.choice(FREQUENCIES)),
            phase=jnp.asarray(random.uniform(0.0, 2.0 * np.pi, 3)),
        ),
        jnp.asarray(EXTERNAL * unit(random)),
    )
    angle = np.deg2rad(random.uniform(NEAREST, FARTHEST))
    azimuth = random.uniform(0.0, 2.0 * np.pi)
    axis = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    quaternion = np.append(np.cos(0.5 * angle), np.sin(0.5 * angle) * axis)
    bias = BIAS * random.choice((-1.0, 1.0), 3)
    return case_of(total, axes, momentum, quaternion, random.choice(WHEEL_SPEEDS, 2), bias, rotors)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    random = np.random.default_rng(given.seed)
    cases = [drawn(random) for _ in range(given.runs)]
    name = "two-wheel pointing"
    candidate = Candidate(name, name, lambda: TwoWheelPointing(AS_KNOWN), DURATION, JUDGED)
    found = evaluate(
        candidate, cases, seed=given.seed, say=lambda text: print(text, file=sys.stderr)
    )
    allowed = 1.10 * np.array([case.quickest for case in cases]) + 40.0
    angle = np.degrees([case.angle for case in cases])
    print(f"{given.runs} cases, seed {given.seed}: {np.sum(found.settled <= allowed)} in time")
    print(f"held below 0.05 deg at the end: {np.sum(found.holds)}")
    print(f"largest torque demand {found.demand.max():.4f} N·m of {TORQUE} N·m")
    print(f"largest error at the end {found.last.max():.4f} deg")
    for low, high in pairwise(EDGES):
        inside = (low < angle) & (angle <= high)
        late = (found.settled - allowed)[inside]
        print(
            f"{low:g} to {high:g} deg: {np.sum(inside)} cases, {np.sum(late > 0.0)} late, "
            f"latest by {late.max():.1f} s, demand {found.demand[inside].max():.4f} N·m"
        )


if __name__ == "__main__":
    main()
