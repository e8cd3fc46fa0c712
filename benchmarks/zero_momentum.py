"""Recovery with two of three wheels and next to no momentum: how many cases settle, and how soon.

A case is a gyrostat with three orthogonal wheels (0.1 N·m, 3 N·m·s, rotors of 0.01 kg·m²), one of
them seized, and an inertia of 12 kg·m² (cube) or 8, 12, 16 kg·m² about random axes (tilted), in
turn. Attitude and wanted attitude are random; the target is the attitude nearest to the wanted one
where the wheels can hold the momentum. At the start the wheels hold what they can. Settled means
within 0.05 deg and below 1e-4 rad/s from then on, to the end of the run.

    python benchmarks/zero_momentum.py [--cases N] [--seed S]
"""

import argparse
import time
from typing import NamedTuple

import equinox as eqx
import numpy as np
from scipy.spatial.transform import Rotation

from gyrostat._jax import jax, jnp
from gyrostat.body import Gyrostat, Spacecraft, SpacecraftSensor, WheelFailures
from gyrostat.body.rotations import error_angle
from gyrostat.control import ZeroMomentumRecovery
from gyrostat.simulate.loop import run
from gyrostat.wheel import WheelArray

WHEELS = WheelArray(np.eye(3), np.full(3, 0.01), np.full(3, 0.1), np.full(3, 3.0))
PERIOD, BLOCK = 0.1, 60


class Goal(NamedTuple):
    """A set of cases.

    Attributes:
        name: of the set.
        least: momentum, N·m·s.
        most: momentum, N·m·s.
        error: of the inertia known to the controller, share of the largest.
        allowed: time to settle, s.
        duration: of a run, s.
        tumbling: whether the body turns at the start, at up to 0.05 rad/s.
    """

    name: str
    least: float
    most: float
    error: float
    allowed: float
    duration: float
    tumbling: bool = False


GOALS = (
    Goal("no momentum", 0.0, 0.0, 0.0, 105.0, 150.0),
    Goal("no momentum, inertia 1 % wrong", 0.0, 0.0, 0.01, 150.0, 200.0),
    Goal("no momentum, tumbling", 0.0, 0.0, 0.0, 150.0, 200.0, tumbling=True),
    Goal("up to 0.01", 0.0, 0.01, 0.0, 200.0, 800.0),
    Goal("up to 0.01, inertia 1 % wrong", 0.0, 0.01, 0.01, 200.0, 800.0),
    Goal("0.01 to 0.1", 0.01, 0.1, 0.0, 200.0, 800.0),
    Goal("0.01 to 0.1, inertia 1 % wrong", 0.01, 0.1, 0.01, 200.0, 800.0),
)


def nearest_rest(wanted, momentum, normal):
    """Attitude nearest to a wanted one at which the momentum has no part along the normal."""
    body = wanted.inv().apply(momentum)
    across = body - normal * (normal @ body)
    axis = np.cross(across, body)
    if np.linalg.norm(axis) < 1e-15:
        return wanted
    angle = np.arctan2(np.linalg.norm(axis), across @ body)
    return wanted * Rotation.from_rotvec(axis / np.linalg.norm(axis) * angle)


def draw(random, goal, tilted):
    """Plant, controller and start of one case."""
    turn = Rotation.random(rng=random).as_matrix() if tilted else np.eye(3)
    inertia = turn @ np.diag((8.0, 12.0, 16.0) if tilted else (12.0,) * 3) @ turn.T
    inertia = 0.5 * (inertia + inertia.T)
    wrong = random.normal(size=(3, 3))
    wrong = (wrong + wrong.T) / np.linalg.norm(wrong + wrong.T, 2)
    known = inertia + goal.error * np.linalg.norm(inertia, 2) * wrong
    failed = int(random.integers(3))
    normal, working = np.eye(3)[failed], np.arange(3) != failed
    attitude, wanted = Rotation.random(2, rng=random)
    momentum = random.normal(size=3)
    momentum *= random.uniform(goal.least, goal.most) / np.linalg.norm(momentum)
    target = nearest_rest(wanted, momentum, normal)
    body = attitude.inv().apply(momentum)
    locked = inertia + np.diag(WHEELS.inertia)
    drift = locked @ normal
    rate = drift * (normal @ body) / (drift @ drift)
    if goal.tumbling:
        across = random.normal(size=3)
        across -= drift * (drift @ across) / (drift @ drift)
        rate = rate + across * random.uniform(0.0, 0.05) / np.linalg.norm(across)
    plant = Gyrostat(
        Spacecraft(inertia, WHEELS), failures=WheelFailures.none(3).seizes(failed, 0.0)
    )
    start = plant.start(
        attitude=np.roll(attitude.as_quat(), 1),
        rate=rate,
        wheel_speed=np.where(working, body - locked @ rate, 0.0) / WHEELS.inertia,
    )
    controller = ZeroMomentumRecovery.plan(
        Spacecraft(known, WHEELS), working, target=np.roll(target.as_quat(), 1)
    )
    return plant, controller, start


@eqx.filter_jit
def settled(plants, controllers, starts, count):
    """Settling time, s, infinite where there is none; sweeps; change of the momentum, N·m·s."""

    def single(plant, controller, start):
        sensor, key = SpacecraftSensor(plant), jax.random.key(0)
        found = run(plant, controller, sensor, start, key, PERIOD, count=count)
        angle = jax.vmap(error_angle, in_axes=(0, None))(found.state.attitude, controller.target)
        rate = jnp.linalg.norm(found.record.rate, axis=1)
        out = ~((angle < np.radians(0.05)) & (rate < 1e-4)) | (found.status != 0)
        last = jnp.where(jnp.any(out), count + 1 - jnp.argmax(out[::-1]), 0)
        change = found.state.momentum - start.momentum
        time = jnp.where(out[-1], jnp.inf, last * PERIOD)
        return time, jnp.sum(found.command.started), jnp.max(jnp.abs(change))

    return eqx.filter_vmap(single, in_axes=eqx.if_array(0))(plants, controllers, starts)


def reached(goal, cases, seed):
    """What `settled` returns, for all cases of a goal."""
    random = np.random.default_rng(seed)
    drawn = [draw(random, goal, tilted=k % 2 == 1) for k in range(cases)]
    blocks = []
    for first in range(0, cases, BLOCK):
        rows = np.minimum(np.arange(first, first + BLOCK), cases - 1)
        items = jax.tree.map(lambda *x: jnp.stack(x), *(drawn[row] for row in rows))
        block = settled(*items, round(goal.duration / PERIOD))
        blocks.append([np.asarray(x)[: cases - first] for x in block])
    return [np.concatenate(parts) for parts in zip(*blocks, strict=True)]


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--goal", default="", help="only goals whose name holds this")
    options = parser.parse_args()
    print(f"{'goal':34}{'in time':>9}{'allowed':>9}{'worst':>8}{'median':>8}{'sweeps':>8}{'s':>6}")
    for goal in (goal for goal in GOALS if options.goal in goal.name):
        begun = time.perf_counter()
        found, sweeps, change = reached(goal, options.cases, options.seed)
        print(
            f"{goal.name:34}{np.sum(found <= goal.allowed):5d}/{len(found):<3d}"
            f"{goal.allowed:9.0f}{found.max():8.1f}{np.median(found):8.1f}{sweeps.max():8.0f}"
            f"{time.perf_counter() - begun:6.0f}  momentum changes by {change.max():.0e}",
            flush=True,
        )


if __name__ == "__main__":
    main()
