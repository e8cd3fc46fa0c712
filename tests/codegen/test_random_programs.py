"""Random programs: brackets, order, carried values and branches, bit by bit."""

import numpy as np
import pytest

from gyrostat.codegen.flight import Entry, emit
from gyrostat.core.jax64 import jax, jnp

PROGRAMS, OPERATIONS, LANES = 3, 30, 300


def random_program(seed):
    """A function of three numbers, made of arithmetic, choices, a branch and a loop."""
    random = np.random.default_rng(seed)
    plan = [
        (int(random.integers(12)), *map(int, random.integers(0, 99, 3))) for _ in range(OPERATIONS)
    ]
    order = random.permutation(3)

    def once(values):
        values = list(values)
        for kind, i, j, k in plan:
            a, b, c = (values[n % len(values)] for n in (i, j, k))
            # all on few lines, so that C has them in few statements
            made = [a + b, a - b, a * b, a - (b - c), a / (b * c), -(a - b), a * -b, (a + b) * c]
            made += [jnp.where((a < b) | (b < c) & ~(c == a), b, c), jnp.maximum(a, b - c)]
            made += [jnp.minimum(a * b, c) - a, 1.0 - (a if k % 2 else 0.5 - jnp.sign(b))]
            values.append(made[kind])
        return values

    def program(x, y, z):
        first = once((x, y, z))[-3:]

        def turn(carry, k):
            # each carried value becomes another one
            return (carry[order[0]], carry[order[1]], carry[order[2]] + k), carry[0]

        (a, b, c), seen = jax.lax.scan(turn, tuple(first), jnp.arange(4.0))
        d = jax.lax.cond(a < b, lambda p: p[0] - (p[1] - p[2]), lambda p: p[2] / p[0], (a, b, c))
        return tuple(once((d, seen[1], seen[3] - a))[-2:])

    return program


@pytest.fixture(scope="module")
def programs():
    return [random_program(seed) for seed in range(PROGRAMS)]


def test_random_programs_are_the_interpreter_bit_by_bit(programs, tools, tmp_path):
    given = {"x": 0.0, "y": 0.0, "z": 0.0}
    entries = [Entry(f"p{k}", p, given, ("u", "v")) for k, p in enumerate(programs)]
    compiled = tools.Compiled(emit("random_programs", entries), tmp_path)
    random = np.random.default_rng(1)
    values = random.choice([0.0, -0.0, 1.0, np.inf, np.nan], (3, LANES))
    values = np.where(random.random((3, LANES)) < 0.8, random.standard_normal((3, LANES)), values)
    finite = 0
    for k, program in enumerate(programs):
        _, found = compiled(f"p{k}", dict(zip("xyz", values, strict=True)))
        expected = tools.interpret(jax.make_jaxpr(program)(0.0, 0.0, 0.0), list(values))
        for ours, theirs in zip((found["u"][0], found["v"][0]), expected, strict=True):
            np.testing.assert_array_equal(ours, theirs)
            numbers = ~np.isnan(ours)
            np.testing.assert_array_equal(np.signbit(ours[numbers]), np.signbit(theirs[numbers]))
            finite += np.isfinite(ours).sum()
    assert finite > 0.3 * 2 * PROGRAMS * LANES
