"""Random slews around keep-out cones: violations, share solved, time over the lower bound.

Each case draws a spacecraft (inertia, three or four working wheels, momentum of body and wheels,
and in half of the cases a rate limit), one to three boresights with angles of their own to the Sun,
in half of the cases angles of the same boresights to a second body, and two random attitudes
outside of all cones. Angles along the slews and loads of the wheels are computed apart from the
planner, in NumPy: an angle between two samples is at least the mean of both less half of what the
body turns meanwhile, and samples are added until that bound decides.

Run with: python benchmarks/keep_out_slews.py --cases 100000 --seed 1
"""

import argparse
import time as clock
from typing import Any, NamedTuple

import numpy as np

import gyrostat as gs
from gyrostat.control.guidance import KeepOutCones, SlewLimits, WheelEnvelope, reference_at
from gyrostat.control.guidance.keep_out_slew import SlewCase
from gyrostat.control.guidance.slew_bound import shortest_time
from gyrostat.control.guidance.wheel_envelope import WheelRoom
from gyrostat.core import rotations
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel import pyramid_axes, read_wheel_sheet

CHUNK, BLOCK = 2000, 128
CONES = 6
SAMPLES, DIVISIONS = 257, 14
"""Samples of a path at first, and how often an interval between two of them may be divided."""


class Cases(NamedTuple):
    """Random cases, leading axis (cases,)."""

    start: Any
    end: Any
    cones: KeepOutCones
    rate_limit: Any
    room: WheelRoom


def unit(rng: np.random.Generator, *shape: int) -> np.ndarray:
    """Random directions."""
    vectors = rng.normal(size=shape)
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def to_inertial(quaternion: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Components of a body vector in inertial axes."""
    scalar, part = quaternion[..., :1], quaternion[..., 1:]
    across = 2.0 * np.cross(part, vector)
    return vector + scalar * across + np.cross(part, across)


def draw(rng: np.random.Generator, count: int) -> Cases:
    """Random cases of which some have ends inside a cone."""
    wheels = read_wheel_sheet("bct-rwp015").array(pyramid_axes(4))
    craft = gs.Spacecraft(inertia=np.diag([0.1, 0.1, 0.1]), wheels=wheels)
    axes, spin = np.asarray(wheels.axes), np.asarray(wheels.inertia)
    working = np.array([[1, 1, 1, 1], [0, 1, 1, 1]], bool)
    shares = np.asarray(WheelEnvelope.of(craft, working).share)[rng.integers(0, 2, count)]
    works = np.any(shares != 0.0, axis=2)
    # principal moments from 0.05 to 0.15, with each below the sum of the others
    spread = rng.uniform(0.025, 0.075, (count, 3))
    moments = spread[:, [1, 2, 0]] + spread[:, [2, 0, 1]]
    inertia = moments[:, :, None] * np.eye(3)
    # what the body carries without the spin of the rotors, as `Spacecraft.inertia_locked` adds it
    locked = inertia + np.einsum("iw,w,jw->ij", axes, spin, axes)
    null = 4e-3 * rng.uniform(-1.0, 1.0, (count, 1)) * np.array([1.0, -1.0, 1.0, -1.0])
    null = null * np.all(works, axis=1, keepdims=True)
    total = 3e-3 * rng.uniform(0.0, 1.0, (count, 1)) * unit(rng, count, 3)
    torque, momentum = (
        np.broadcast_to(share * np.asarray(each), (count, 4))
        for share, each in ((0.8, wheels.torque_limit), (0.9, wheels.momentum_limit))
    )
    room = WheelRoom(shares, inertia, locked, torque, momentum, null, total)
    number = rng.integers(1, 4, count)[:, None] > np.arange(3)
    from_sun = np.radians(rng.uniform(15.0, 60.0, (count, 3))) * number
    second = (
        np.radians(rng.uniform(5.0, 30.0, (count, 3))) * number * rng.integers(0, 2, (count, 1))
    )
    boresights = np.tile(unit(rng, count, 3, 3), (1, 2, 1))
    bodies = np.repeat(unit(rng, count, 2, 3), 3, axis=1)
    cones = KeepOutCones(boresights, bodies, np.concatenate([from_sun, second], axis=1))
    rate_limit = np.where(rng.integers(0, 2, count) == 1, np.radians(1.0), np.inf)
    return Cases(unit(rng, count, 4), unit(rng, count, 4), cones, rate_limit, room)


def feasible(rng: np.random.Generator, count: int) -> Cases:
    """Random cases with both ends outside of all cones."""
    drawn = draw(rng, 6 * count)
    clear = np.ones(6 * count, bool)
    for attitude in (drawn.start, drawn.end):
        pointed = to_inertial(attitude[:, None], drawn.cones.boresights)
        angle = np.arccos(np.clip(np.sum(pointed * drawn.cones.directions, -1), -1.0, 1.0))
        clear &= np.all((angle > drawn.cones.angles) | (drawn.cones.angles == 0.0), axis=1)
    rows = np.flatnonzero(clear)[:count]
    assert len(rows) == count
    return jax.tree.map(lambda each: each[rows], drawn)


def case_of(case: Cases) -> SlewCase:
    """Slew to plan."""
    return SlewCase(case.start, case.end, case.cones, SlewLimits(case.rate_limit, 1e9), case.room)


@jax.jit
def straight(cases: Cases) -> Any:
    """Eigenaxis slews and lower bounds."""

    def plan(case: Cases) -> Any:
        slew = case_of(case)
        bound = shortest_time(slew.turn, slew.limits, slew.room)
        return slew.eigenaxis(), bound

    return jax.vmap(plan)(cases)


@jax.jit
def around(cases: Cases) -> Any:
    """Slews around the cones."""
    return jax.lax.map(lambda case: case_of(case).bowed(), cases, batch_size=16)


def attitudes(path: Any, progress: np.ndarray) -> np.ndarray:
    """Attitudes along paths, (cases, samples, 4), apart from the planner."""
    s = progress[..., None]
    turn, bow, twist = (np.asarray(each)[:, None] for each in path[1:])
    vector = (s - 0.5) * turn + 4 * s * (1 - s) * bow + 10 * s * (1 - s) * (1 - 2 * s) * twist
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    part = vector * 0.5 * np.sinc(0.5 * angle / np.pi)
    scalar = np.cos(0.5 * angle)
    first = np.asarray(path.middle)[:, None]
    q, p = first[..., :1], first[..., 1:]
    dot = np.sum(p * part, axis=-1, keepdims=True)
    return np.concatenate([q * scalar - dot, q * part + scalar * p + np.cross(p, part)], axis=-1)


def clearances(path: Any, cones: KeepOutCones, progress: np.ndarray) -> np.ndarray:
    """Least angle from the edge of a cone, (cases, samples), rad."""
    attitude = attitudes(path, progress)
    least = np.full(attitude.shape[:2], np.inf)
    for k in range(CONES):
        boresight, body, limit = (np.asarray(each)[:, k] for each in cones)
        pointed = to_inertial(attitude, boresight[:, None])
        cross = np.linalg.norm(np.cross(pointed, body[:, None]), axis=-1)
        angle = np.arctan2(cross, np.sum(pointed * body[:, None], axis=-1)) - limit[:, None]
        least = np.minimum(least, np.where(limit[:, None] > 0.0, angle, np.inf))
    return least


def decided(path: Any, cones: KeepOutCones) -> tuple[np.ndarray, np.ndarray]:
    """Least angle at samples, rad, and whether each path is proven to be clear between them.

    Intervals that are not proven are divided until they are, or until a sample is in a cone.
    """
    progress = np.linspace(0.0, 1.0, SAMPLES)
    angle = clearances(path, cones, progress[None])
    turn, bow, twist = (np.linalg.norm(np.asarray(each), axis=-1) for each in path[1:])
    # the body turns at most by what the rotation vector moves
    fastest = turn + 4.0 * bow + 10.0 * twist
    least, is_proven = np.min(angle, axis=1), np.zeros(len(angle), bool)
    for row in range(len(angle)):
        alone = jax.tree.map(lambda each, row=row: np.asarray(each)[row : row + 1], (path, cones))
        starts, step = progress[:-1], progress[1]
        ends = angle[row, :-1], angle[row, 1:]
        for _ in range(DIVISIONS):
            is_open = 0.5 * (ends[0] + ends[1] - fastest[row] * step) < 0.0
            is_proven[row] = not np.any(is_open)
            if is_proven[row] or least[row] <= 0.0:
                break
            step /= 4.0
            starts = (starts[is_open, None] + step * np.arange(4)).ravel()
            ends = tuple(clearances(*alone, (starts + k * step)[None])[0] for k in (0, 1))
            least[row] = min(least[row], np.min(ends))
    return least, is_proven


@jax.jit
def loads(slews: Any, cases: Cases) -> Any:
    """Largest torque, momentum and rate over their limits, at 200 times."""

    def load(slew: Any, case: Cases) -> Any:
        times = slew.duration * (jnp.arange(200) + 0.5) / 200
        attitude, rate, change = jax.vmap(lambda time: reference_at(slew, time))(times)
        room = case.room
        total = jax.vmap(lambda q: rotations.to_body(q, room.total))(attitude)
        torque = room.rows @ (-jnp.cross(rate, total) - change @ room.inertia).T
        momentum = room.null[:, None] + room.rows @ (total - rate @ room.locked).T
        size = jnp.sqrt(jnp.max(jnp.sum(rate**2, axis=1)))
        return (
            jnp.max(jnp.abs(torque) / room.torque[:, None]),
            jnp.max(jnp.abs(momentum) / room.momentum[:, None]),
            size / case.rate_limit,
        )

    return jax.vmap(load)(slews, cases)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=np.inf, help="stop after this time")
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    found: dict[str, list[np.ndarray]] = {}
    begin = clock.perf_counter()
    for _ in range(-(-options.cases // CHUNK)):
        for name, rows in chunk(feasible(rng, CHUNK)).items():
            found.setdefault(name, []).append(rows)
        if clock.perf_counter() - begin > 60.0 * options.minutes:
            break
    spent = clock.perf_counter() - begin
    rows = {name: np.concatenate(each) for name, each in found.items()}
    solved, blocked = rows["is_solved"], rows["is_blocked"]
    print(f"seed {options.seed}: {len(solved)} cases, {spent:.0f} s")
    print(f"eigenaxis slew enters a cone: {100 * np.mean(blocked):.2f} %")
    print(f"solved: {100 * np.mean(solved):.3f} %, of these {100 * np.mean(solved[blocked]):.3f} %")
    print(f"violations: {np.sum(solved & ~rows['is_proven'])} (bound between samples)")
    print(f"least angle from a cone: {np.degrees(np.min(rows['clearance'][solved])):.2e} deg")
    for name in ("torque", "momentum", "rate"):
        print(f"largest {name} over its limit: {np.max(rows[name][solved]):.4f}")
    for name, chosen in {
        "all, over the lower bound": (solved, "bound"),
        "around a cone, over the lower bound": (solved & blocked, "bound"),
        "around a cone, over the eigenaxis slew": (solved & blocked, "straight"),
    }.items():
        ratio = (rows["duration"] / rows[chosen[1]])[chosen[0]]
        quantiles = np.percentile(ratio, [50, 90, 99, 100])
        print(f"time, {name}: " + ", ".join(f"{each:.3f}" for each in quantiles))


def chunk(cases: Cases) -> dict[str, np.ndarray]:
    """Results of some cases."""
    slews, bound = jax.tree.map(np.array, straight(cases))
    blocked = np.flatnonzero(~slews.is_clear)
    direct = np.array(slews.duration)
    for first in range(0, len(blocked), BLOCK):
        rows = blocked[first : first + BLOCK]
        # one shape for the compiled program
        padded = np.resize(rows, BLOCK)
        part = jax.tree.map(lambda each, rows=padded: np.asarray(each)[rows], cases)
        bowed = around(part)
        for whole, new in zip(jax.tree.leaves(slews), jax.tree.leaves(bowed), strict=True):
            whole[rows] = np.asarray(new)[: len(rows)]
    clearance, is_proven = decided(slews.path, cases.cones)
    torque, momentum, rate = (np.asarray(each) for each in loads(slews, cases))
    is_blocked = np.zeros(len(bound), bool)
    is_blocked[blocked] = True
    return {
        "is_solved": slews.is_clear & slews.has_room,
        "is_blocked": is_blocked,
        "is_proven": is_proven,
        "clearance": clearance,
        "torque": torque,
        "momentum": momentum,
        "rate": rate,
        "bound": bound,
        "straight": direct,
        "duration": np.asarray(slews.duration),
    }


if __name__ == "__main__":
    main()
