"""Two-wheel pointing with wrong rotors, tilted wheels, gyro bias and an external torque.

    python benchmarks/two_wheels.py [--runs 1000] [--seed 1] [--gyroless]
        [--arcsec 10] [--periods 1]

As the dispersed cases of Endo, Sekiguchi and Nonaka (`gyrostat.papers`), with larger errors of the
model: rotors 5 %, moments of inertia 10 %, wheel axes 1 deg, gyro bias 10 deg/h about each axis and
a constant external torque of 1e-5 N·m. In time: error below 0.05 deg for good within 1.10 T + 40 s,
with the duration T of the fastest rotation by the torque limit, 0.1 N·m. Seeds below 1000 served
development; proof uses others. With `--gyroless`, attitude and rate come from a star tracker, with
this noise about each axis and this number of control periods of 0.1 s between samples, and from the
tachometers (`gyrostat.estimation.MomentumAttitudeFilter`), in the same cases.
"""

import argparse
import sys
from dataclasses import replace
from itertools import pairwise

import equinox as eqx
import numpy as np

from gyrostat.control import OutputFeedback, TwoWheelPointing
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.estimation import MomentumAttitudeFilter
from gyrostat.papers.endo_sekiguchi_nonaka import setup
from gyrostat.papers.endo_sekiguchi_nonaka.controllers import Candidate, Outcome, evaluate
from gyrostat.papers.endo_sekiguchi_nonaka.dispersion import (
    AS_KNOWN,
    FARTHEST,
    FREQUENCIES,
    LARGEST_MOMENTUM,
    NEAREST,
    TACHOMETER,
    TORQUE,
    WHEEL_SPEEDS,
    Case,
    axes_of,
    case_of,
    inertia_of,
)
from gyrostat.spacecraft import (
    Gyrostat,
    SinusoidalMomentum,
    SpacecraftSensor,
    StarTracker,
    TrackerGyroSensors,
)

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


def without_gyro(case: Case, sigma: float, periods: int) -> Case:
    """The case with a star tracker of this noise, rad, and these periods, and without a gyro."""
    plant = Gyrostat(case.plant.spacecraft)
    truth = SpacecraftSensor(plant, wheel_sigma=setup.ROTOR * TACHOMETER)
    return replace(case, sensor=TrackerGyroSensors(truth, StarTracker(sigma, float(periods))))


def flown(cases: list[Case], given: argparse.Namespace) -> Outcome:
    """Outcome of the cases with the sensors that were asked for."""
    controller = TwoWheelPointing(AS_KNOWN)
    if given.gyroless:
        sigma = np.deg2rad(given.arcsec / 3600.0)
        cases = [without_gyro(case, sigma, given.periods) for case in cases]
        filter = MomentumAttitudeFilter(AS_KNOWN, sigma, float(given.periods), TACHOMETER)
        controller = OutputFeedback(filter, controller)
    name = "two-wheel pointing"
    candidate = Candidate(name, name, lambda: controller, DURATION, JUDGED)
    return evaluate(
        candidate, cases, seed=given.seed, say=lambda text: print(text, file=sys.stderr)
    )


def allowed(cases: list[Case]) -> np.ndarray:
    """Time in which each case must be settled, s."""
    return 1.10 * np.array([case.quickest for case in cases]) + 40.0


def arguments(text: str, **numbers: int) -> argparse.Namespace:
    """Arguments of the command line: those of the sensors, and whole numbers with defaults."""
    parser = argparse.ArgumentParser(description=text.split("\n")[0])
    for name, default in numbers.items():
        parser.add_argument(f"--{name}", type=int, default=default)
    parser.add_argument("--gyroless", action="store_true")
    parser.add_argument("--arcsec", type=float, default=10.0)
    parser.add_argument("--periods", type=int, default=1)
    return parser.parse_args()


def main() -> None:
    """Print the table."""
    given = arguments(__doc__, runs=1000, seed=1)
    random = np.random.default_rng(given.seed)
    cases = [drawn(random) for _ in range(given.runs)]
    found = flown(cases, given)
    angle = np.degrees([case.angle for case in cases])
    print(
        f"{given.runs} cases, seed {given.seed}: {np.sum(found.settled <= allowed(cases))} in time"
    )
    print(f"held below 0.05 deg at the end: {np.sum(found.holds)}")
    print(f"largest torque demand {found.demand.max():.4f} N·m of {TORQUE} N·m")
    print(f"error at the end: mean {found.last.mean():.4f}, largest {found.last.max():.4f} deg")
    for low, high in pairwise(EDGES):
        inside = (low < angle) & (angle <= high)
        late = (found.settled - allowed(cases))[inside]
        print(
            f"{low:g} to {high:g} deg: {np.sum(inside)} cases, {np.sum(late > 0.0)} late, "
            f"latest by {late.max():.1f} s, demand {found.demand[inside].max():.4f} N·m"
        )


if __name__ == "__main__":
    main()
