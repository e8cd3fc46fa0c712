"""Random programs of arrays: flight C, SIMD lanes and NumPy compute what JAX does.

Each program is a chain of operations on matrices that are larger than what is written out: moves,
parts at computed indices, products, reductions, loops that carry matrices, branches that return
them. What loops, tables and shared memory could get wrong shows as another number.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from gyrostat.codegen.evaluation import evaluated
from gyrostat.codegen.simd import compiler
from gyrostat.codegen.simd.batch import lanes
from gyrostat.codegen.simd.batch_scope import BATCH
from gyrostat.core.jax64 import jax, jnp

RUNS, SIZE = 5, 9
SEEDS = range(5)
SMALL_PARTS = replace(BATCH, few=8, written=64)
MASK = np.tri(SIZE, dtype=bool)


def bounded(a):
    """Numbers of moderate size: chains of products neither overflow nor vanish."""
    return jnp.sin(a) + 0.1 * a / (1.0 + jnp.abs(a))


def carried(a, b, k):
    def step(number, carry):
        first, second, total = carry
        changed = second.at[number % SIZE, k].set(total) + 0.1 * first.T
        return second, bounded(changed @ first), total + first[number % SIZE, 0]

    first, second, total = jax.lax.fori_loop(0, 4, step, (a, b, 0.5))
    return first + 0.1 * second + total


def scanned(a, b, k):
    def step(carry, row):
        carry = bounded(carry + jnp.outer(row, carry[k]))
        return carry, carry[0] * row

    last, rows = jax.lax.scan(step, a, b)
    return last + rows


def until(a, b, k):
    def step(state):
        number, matrix = state
        return number + 1, bounded(matrix @ b + matrix)

    count = jnp.where(a[0, 0] > 0.0, 1, 3)
    return jax.lax.while_loop(lambda s: (s[0] < count) & (s[0] < 5), step, (0, a))[1]


def branched(a, b, k):
    swapped = jax.lax.cond(a[k, 1] > b[1, k], lambda a, b: (b, a.T), lambda a, b: (a, b), a, b)
    return swapped[0] - 0.3 * swapped[1]


def placed(a, b, k):
    part = jax.lax.dynamic_slice(a, (k, 1), (2, 3))
    return jax.lax.dynamic_update_slice(b, part, (1, k)).at[:, k].add(a[k])


def gathered(a, b, k):
    order = (jnp.arange(SIZE) * 2 + k) % SIZE
    return a[order] + b[:, order] * a[order, order]


def joseph(a, b, k):
    """Update of a covariance: of the factor, six columns are those of the unit matrix."""
    rest = jnp.eye(SIZE) - jnp.zeros((SIZE, SIZE)).at[:, 2:5].set(a[:, :3])
    return rest @ b @ rest.T


def mixed(a, b, k):
    """Factors with known zeros and ones, which loops leave out or not."""
    wide = jnp.zeros((SIZE, SIZE)).at[:, 1:4].set(a[:, 2:5]).at[7, 6].set(a[0, 0])
    shifted = wide.at[0, 5].set(1.0).at[3, 5].set(2.0).at[8, 8].set(1.0) - jnp.eye(SIZE)
    return b.T @ shifted.T + (wide + jnp.diag(b[0])) @ a[:, ::-1] - shifted[::-1] @ b


STEPS = {
    "add": lambda a, b, k: a + b,
    "branched": branched,
    "carried": carried,
    "choose": lambda a, b, k: jnp.where(a > b, a.T, b),
    "diagonal": lambda a, b, k: a + jnp.diag(b[0]) - 0.5 * jnp.eye(SIZE),
    "gathered": gathered,
    "joseph": joseph,
    "long": lambda a, b, k: jnp.concatenate([a, b], 1) @ jnp.concatenate([b, a.T], 0),
    "masked": lambda a, b, k: jnp.where(MASK, a, b.T),
    "mirrored": lambda a, b, k: jnp.concatenate([a[::-1, 1:], b[:, :1]], axis=1),
    "mixed": mixed,
    "outer": lambda a, b, k: jnp.outer(a[0], b[:, 1]) - a,
    "placed": placed,
    "product": lambda a, b, k: a @ b.T,
    "reduced": lambda a, b, k: a - jnp.max(b, axis=0) + jnp.sum(a, axis=1)[:, None],
    "rolled": lambda a, b, k: jnp.roll(a, (1, -2), (0, 1)) * b,
    "row": lambda a, b, k: a.at[2].set(b[k] * a[1]),
    "scanned": scanned,
    "solved": lambda a, b, k: jnp.linalg.solve(a + 9.0 * jnp.eye(SIZE), b),
    "sparse": lambda a, b, k: jnp.diag(b[1]).at[0, 3].set(2.0) @ a,
    "triangles": lambda a, b, k: jnp.tril(a) @ jnp.triu(b, 1),
    "until": until,
}


def program(seed):
    """Function of two matrices and an index: some steps, each of matrices so far."""
    random = np.random.default_rng(seed)
    steps = [STEPS[name] for name in random.choice([*STEPS], 7)]
    picks = random.integers(0, 3, (len(steps), 2))

    def run(a, b, k):
        matrices = [a, b]
        for step, pick in zip(steps, picks, strict=True):
            operands = (matrices[-1 - int(n) % len(matrices)] for n in pick)
            matrices.append(bounded(step(*operands, k)))
        return tuple(matrices[2:])

    run.__name__ = f"program_{seed}"
    return run


@pytest.fixture(scope="module")
def arguments():
    random = np.random.default_rng(7)
    matrices = random.standard_normal((2, RUNS, SIZE, SIZE))
    return {"a": matrices[0], "b": matrices[1], "start": np.arange(RUNS)}


@pytest.fixture(scope="module")
def expected(arguments):
    return [jax.jit(jax.vmap(program(seed)))(*arguments.values()) for seed in SEEDS]


def compare(found, expected):
    for seed, (ours, jaxs) in enumerate(zip(found, expected, strict=True)):
        for number, pair in enumerate(zip(ours, jaxs, strict=True)):
            np.testing.assert_allclose(*pair, 1e-8, 1e-10, err_msg=f"program {seed}, {number}")


def test_flight_c_computes_what_jax_does(arguments, expected, module_at, tmp_path):
    results_of = module_at(Path(__file__).with_name("compiled.py")).results_of
    programs = [program(seed) for seed in SEEDS]
    results = results_of("programs", programs, arguments, tmp_path)
    compare([results[each][1] for each in programs], expected)


def test_lanes_compute_what_jax_does(arguments, expected, monkeypatch):
    if compiler() is None:
        pytest.skip("needs a C compiler")
    # matrices of this size are scalars in lanes otherwise
    monkeypatch.setattr("gyrostat.codegen.simd.batch.BATCH", SMALL_PARTS)
    programs = [program(seed) for seed in SEEDS]
    compiled = lanes(partial(every, programs), (True,) * 3, [*arguments.values()])
    compare(compiled(*arguments.values()), expected)


def test_numpy_computes_what_jax_does(arguments, expected):
    programs = [evaluated(program(seed)) for seed in SEEDS]
    rows = [[run(a, b, k) for a, b, k in zip(*arguments.values(), strict=True)] for run in programs]
    compare([[*map(np.array, zip(*each, strict=True))] for each in rows], expected)


def every(programs, a, b, k):
    return [run(a, b, k) for run in programs]
