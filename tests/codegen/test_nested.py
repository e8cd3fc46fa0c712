"""Random loops and branches inside each other, of what differs between runs and what does not."""

import random

import numpy as np
import pytest

from gyrostat.codegen.simd.batch import lanes
from gyrostat.core.jax64 import jax, jnp

RUNS = 11
RANDOM = np.random.default_rng(0)


def some_program(seed):
    """A function of a real, an integer, a shared real, a shared integer and a shared table."""
    choices = random.Random(seed)

    def block(depth):
        kinds = ["real", "integer", "shared", "swap", "table"]
        if depth:
            kinds += ["cond", "switch", "while", "scan", "fori"]
        steps = [step(choices.choice(kinds), depth) for _ in range(2)]
        return lambda state: steps[1](steps[0](state))

    def step(kind, depth):
        number = choices.randrange(4)
        inner = [block(depth - 1) for _ in range(3)] if depth else []

        def real(state):
            x, k, y, m, t = state
            return (x - 0.7 * y, jnp.sin(x) + t[k], t[m] * x, jnp.where(x > y, x, -k * y))[number]

        def integer(state):
            x, k, _, m, t = state
            made = (k + 1, m - k, jnp.argmax(t) + k, (3.0 * jnp.clip(x, -2.0, 2.0)).astype(int))
            return jnp.clip(made[number], -4, 4)

        def test(state):
            x, k, y, m, _ = state
            return (x > y, k < m, m > 1, y > 0.2)[number]

        def turned(state):
            x, k, y, m, t = state
            return x, k, jnp.tanh(1.3 * y), jnp.clip(m + 1 - 2 * (number % 2), -3, 4), t

        def looped(state):
            def goes_on(carry):
                (_, k, _, m, _), count = carry
                return (count < (k, m, 3, 4)[number]) & (test(carry[0]) | (count < 2))

            after, count = jax.lax.while_loop(
                goes_on, lambda carry: (inner[0](carry[0]), carry[1] + 1), (state, 0)
            )
            return after[0], jnp.clip(after[1] + count, -4, 4), *after[2:]

        def scanned(state):
            def one(carry, row):
                after = inner[0]((carry[0] + row, *carry[1:]))
                return after, (after[0], after[1])

            after, rows = jax.lax.scan(one, state, state[4], reverse=number % 2 == 0)
            return jnp.tanh(rows[0][0]), rows[1][1], *after[2:]

        return {
            "real": lambda state: (real(state), *state[1:]),
            "integer": lambda state: (state[0], integer(state), *state[2:]),
            "shared": turned,
            "swap": lambda state: (state[2], state[3], state[0], state[1], state[4]),
            "table": lambda state: (*state[:4], jnp.stack([state[4][1], state[0], state[4][0]])),
            "cond": lambda state: jax.lax.cond(test(state), inner[0], inner[1], state),
            "switch": lambda state: jax.lax.switch(integer(state), inner, state),
            "while": looped,
            "scan": scanned,
            "fori": lambda state: jax.lax.fori_loop(0, number + 1, lambda _, s: inner[0](s), state),
        }[kind]

    program, repeated = block(3), block(1)

    def function(*state):
        def one(carry, _):
            after = repeated(carry)
            after = (jnp.tanh(after[0]), *after[1:])
            return after, after[:2]

        return jax.lax.scan(one, program(state), length=70, reverse=seed % 2 == 0)

    return function


@pytest.mark.parametrize("seed", range(12))
def test_loops_and_branches_in_each_other(seed):
    own = (True, True, False, False, False)
    state = (
        *(RANDOM.standard_normal(RUNS), RANDOM.integers(-4, 5, RUNS)),
        *(np.float64(0.3), np.int64(seed % 4), np.array([0.1, -0.4, 0.7])),
    )
    function = some_program(seed)
    expected = jax.jit(jax.vmap(function, [0 if each else None for each in own]))(*state)
    found = lanes(function, own, state)(*state)
    for ours, theirs in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-10, atol=1e-10)
