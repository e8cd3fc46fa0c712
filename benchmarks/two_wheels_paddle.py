"""Two wheels with a driven paddle about the third axis against the sweeps of two wheels alone.

    python benchmarks/two_wheels_paddle.py [--runs 1000] [--seed 1] [--calm] [--worst]

A body of 12 kg·m² about each axis, two wheels of 0.3 N·m, and a paddle of 0.6 kg·m² about z with
±150 deg, 0.3 N·m and 0.1 rad/s. The body starts at rest off its target by up to 5 deg, or by 7 to
30 deg, about any axis. Dispersed: moments of inertia 5 %, products 2 %, inertia of the paddle 5 %,
total momentum up to 1 mN·m·s, Coulomb friction of the hinge up to 10 mN·m, start of the paddle
within 10 deg. Noise: 10 arcsec, 5e-6 rad/s, 1 mrad/s of the tachometers, 0.1 deg of the paddle. The
controllers know none of it. Both are simulated in the same cases; without the paddle, its rate loop
holds it. `--calm` leaves out total momentum and noise, where sweeps are at their best. Settled:
attitude error below 0.05 deg until the end at 300 s. `--worst` searches the smaller angles for the
case that settles last. Seeds below 1000 served development.
"""

import argparse

import numpy as np
from scipy.special import ndtri

from gyrostat.control import PaddleRecovery
from gyrostat.simulation import simulate, stack
from gyrostat.spacecraft import (
    AddedSensors,
    Gyrostat,
    PaddleAngle,
    PaddleGyrostat,
    Spacecraft,
    SpacecraftSensor,
)
from gyrostat.wheel import WheelArray
from gyrostat.wheel.friction import ViscousCoulomb

BODY, ROTOR, PADDLE = 12.0, 0.01, 0.6
LIMIT, FASTEST = np.deg2rad(150.0), 0.1
DURATION, PERIOD, REQUIRED = 300.0, 0.1, 0.05
NEAR, FAR = (0.0, 5.0), (7.0, 30.0)
DIMENSIONS = 17


def craft(inertia: np.ndarray, paddle: float, hinge: float) -> Spacecraft:
    """Body with two wheels and a paddle whose hinge has this Coulomb torque, N·m."""
    own = np.array([ROTOR, ROTOR, paddle])
    friction = ViscousCoulomb(viscous=np.zeros(3), coulomb=np.array([1e-3, 1e-3, hinge]))
    momentum = np.array([6.0, 6.0, PADDLE * FASTEST])
    return Spacecraft(inertia, WheelArray(np.eye(3), own, np.full(3, 0.3), momentum, friction))


KNOWN = craft(np.diag(np.full(3, BODY)), PADDLE, 0.0)


def case(point: np.ndarray, angles: tuple[float, float], calm: bool):
    """Plant, start and sensor of a point of the unit box, (17,)."""
    point = 2.0 * point - 1.0
    inertia = np.diag(BODY * (1.0 + 0.05 * point[:3]))
    for value, (i, j) in zip(point[3:6], ((0, 1), (0, 2), (1, 2)), strict=True):
        inertia[i, j] = inertia[j, i] = 0.02 * BODY * value
    body = craft(inertia, PADDLE * (1.0 + 0.05 * point[6]), 5e-3 * (1.0 + point[7]))
    plant = PaddleGyrostat(Gyrostat(body), np.array([np.inf, np.inf, LIMIT]))
    axis, along = (ndtri(0.5 + 0.499 * point[k : k + 3]) for k in (8, 11))
    share = 0.5 * (1.0 + point[14])
    half = 0.5 * np.deg2rad(angles[0] + share * (angles[1] - angles[0]))
    size = 0.0 if calm else 0.5e-3 * (1.0 + point[15])
    momentum = size * along / np.linalg.norm(along)
    quaternion = np.append(np.cos(half), np.sin(half) * axis / np.linalg.norm(axis))
    start = plant.start(
        attitude=quaternion,
        rate=np.linalg.solve(np.asarray(body.inertia_locked()), momentum),
        wheel_angle=[0.0, 0.0, np.deg2rad(10.0) * point[16]],
    )
    sigma = (0.0 if calm else 1.0) * np.array([np.deg2rad(10.0 / 3600.0), 5e-6, ROTOR * 1e-3])
    sensor = SpacecraftSensor(plant, *sigma)
    return plant, start, AddedSensors(sensor, {"paddle_angle": PaddleAngle(2, np.deg2rad(0.1))})


def flown(points, angles, with_paddle: bool, seed: int, calm: bool = False):
    """Settling times, s, largest errors about each axis, deg, and share of time by the paddle."""
    # a paddle without range is held
    limit = LIMIT if with_paddle else 1e-6
    law = PaddleRecovery.plan(KNOWN, paddle=2, angle_limit=limit, target=np.array([1.0, 0, 0, 0]))
    parts = [
        stack(list(part)) for part in zip(*(case(p, angles, calm) for p in points), strict=True)
    ]
    flight = simulate(
        parts[0],
        law,
        parts[2],
        start=parts[1],
        duration=DURATION,
        control_period=PERIOD,
        runs=len(points),
        seed=seed,
        engine="native",
    )
    q = flight.attitude.values
    error = np.degrees(2.0 * np.arcsin(np.minimum(np.linalg.norm(q[..., 1:], axis=-1), 1.0)))
    late = error > REQUIRED
    settled = np.where(late.any(1), PERIOD * (late.shape[1] - np.argmax(late[:, ::-1], 1)), 0.0)
    settled = np.where(late[:, -1] | (flight.status.values != 0), np.inf, settled)
    boresight = np.degrees(2.0 * np.arcsin(np.hypot(q[..., 1], q[..., 2])))
    return settled, boresight.max(1), error[:, -500:].max(1), flight.by_paddle.values.mean(1)


def table(runs: int, seed: int, calm: bool) -> None:
    """Print both controllers in the same cases."""
    points = np.random.default_rng(seed).uniform(size=(runs, DIMENSIONS))
    for angles in (NEAR, FAR):
        for with_paddle in (True, False):
            settled, swing, last, used = flown(points, angles, with_paddle, seed, calm)
            late = np.percentile(settled, 95, method="higher")
            print(
                f"{angles[0]:g} to {angles[1]:g} deg, paddle {'used' if with_paddle else 'held'}: "
                f"{np.isfinite(settled).sum()} of {runs} settled; median {np.median(settled):.1f}, "
                f"95 % {late:.1f}, largest {settled.max():.1f} s; boresight off by median "
                f"{np.median(swing):.1f}, largest {swing.max():.1f} deg; last 50 s "
                f"95 % {np.percentile(last, 95):.4f}, largest {last.max():.4f} deg; paddle in use "
                f"{100.0 * used.mean():.0f} % of the time",
                flush=True,
            )


def worst(runs: int, seed: int) -> None:
    """Search the case that settles last (current-to-best/1/bin)."""
    random = np.random.default_rng(seed)
    points = random.uniform(size=(runs, DIMENSIONS))
    points[::2] = np.round(points[::2])
    found = flown(points, NEAR, True, seed)[0]
    for _ in range(10):
        first, second = (points[random.permutation(runs)] for _ in range(2))
        mutant = points + 0.45 * (points[np.argmax(found)] - points) + 0.6 * (first - second)
        trial = np.clip(np.where(random.uniform(size=points.shape) < 0.8, mutant, points), 0.0, 1.0)
        tried = flown(trial, NEAR, True, seed)[0]
        points = np.where((tried > found)[:, None], trial, points)
        found = np.maximum(found, tried)
    print(f"worst found of {11 * runs} cases: settled after {found.max():.1f} s")


def main() -> None:
    """Print the table, or the worst case."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--calm", action="store_true")
    parser.add_argument("--worst", action="store_true")
    given = parser.parse_args()
    if given.worst:
        worst(given.runs, given.seed)
    else:
        table(given.runs, given.seed, given.calm)


if __name__ == "__main__":
    main()
