"""The runner: any loop, for one run or many, whole or in chunks, recorded or folded."""

import numpy as np
import pytest

from gyrostat.codegen.simd import compiler
from gyrostat.core.jax64 import jnp
from gyrostat.simulation import Loop, Runner, blocks

COUNT = 199
ENGINES = ["jax", *(["native"] if compiler() else [])]


def decaying(start, gain):
    """x' = gain x + k, recorded as (x, 2 x)."""
    return Loop(
        lambda: jnp.asarray(start),
        lambda x, k: (gain * x + k, (x, 2.0 * x)),
    )


def expected(start, gain=0.5):
    rows = [np.asarray(start, dtype=float)]
    for k in range(COUNT):
        rows.append(gain * rows[-1] + k)
    return np.stack(rows, axis=-1)


STARTS = np.linspace(-3.0, 3.0, 70)


def test_one_run():
    x, twice = Runner(decaying, (False, False), COUNT).records(1.5, 0.5)
    np.testing.assert_allclose(x, expected(1.5), rtol=1e-14)
    np.testing.assert_allclose(twice, 2.0 * x, rtol=0)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("longest", [None, 70])
def test_a_batch_in_blocks_and_chunks(engine, longest):
    done = []
    runner = Runner(decaying, (True, False), COUNT, engine=engine, longest=longest)
    assert len(runner.starts) == (1 if longest is None else 3)
    x, _ = runner.records(
        jnp.asarray(STARTS), 0.5, runs=70, on_progress=lambda *told: done.append(told)
    )
    np.testing.assert_allclose(x, expected(STARTS), rtol=1e-14)
    assert done[-1] == (70, 70)


@pytest.mark.parametrize("engine", ENGINES)
def test_records_on_demand_and_a_carry_that_is_known(engine):
    runner = Runner(
        decaying, (True, False), COUNT, engine=engine, longest=100, on_demand=(False, True)
    )
    rows = [row for _, row in runner.chunks(STARTS, 0.5, carry=STARTS + 1.0, asked=[2, 69])]
    x, twice = (np.concatenate(parts, axis=1) for parts in zip(*rows, strict=True))
    np.testing.assert_allclose(x, expected(STARTS + 1.0), rtol=1e-14)
    np.testing.assert_allclose(twice, 2.0 * x[[2, 69]], rtol=0)
    nothing = next(iter(runner.chunks(STARTS, 0.5)))[1][1]
    assert nothing.shape == (0, 100)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_folded_loop_records_what_the_fold_gives(engine):
    def make(start, gain):
        return decaying(start, gain).folded(
            lambda total, row, k: (total + row[0], None), jnp.zeros(())
        )

    runner = Runner(make, (True, False), COUNT, engine=engine, longest=70)
    *_, ((_, total), rows) = runner.chunks(STARTS, 0.5)
    assert rows is None
    # two chunks of 67 samples and one of 66, and one sample more
    whole = expected(STARTS)
    after = 0.5 * whole[:, -1] + COUNT
    np.testing.assert_allclose(total, whole.sum(axis=1) + after, rtol=1e-13)


def test_blocks_are_filled_up():
    found = [(rows.tolist(), kept) for rows, kept in blocks(5, 2)]
    assert found == [([0, 1], 2), ([2, 3], 2), ([4, 4], 1)]
