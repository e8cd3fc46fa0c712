"""Parts of long functions: the same results, short functions, few parameters."""

import re

import numpy as np
import pytest

from gyrostat.codegen.flight import Entry, emit, outlining
from gyrostat.codegen.program_cost import cost_of
from gyrostat.core.jax64 import jax, jnp

LIMITS = {"LONGEST": 40, "PART": 40, "LEAST": 4, "MOST": 16, "WHOLE": 10}
LANES = 40
HEAD = re.compile(r"^(?:static )?\w+ (\w+)\((.*?)\)\n\{\n(.*?)^\}", re.MULTILINE | re.DOTALL)


def law(rates, count, gain, place, x):
    """Branches, a loop, tables of the function and of the caller, and a number by address."""

    def chosen():
        total = rates * gain
        for k in range(12):
            total = jnp.where(total > k, total - gain[k % 3], total * 0.5 + jnp.sin(total))
        square = jnp.outer(total, total) + 8.0 * jnp.eye(3)
        for k in range(3):
            square = square @ square / (1.0 + jnp.trace(square) ** 2) + k * jnp.eye(3)
        return square @ total

    def otherwise():
        def ahead(state):
            y, k = state
            for j in range(10):
                y = y * 0.5 + gain[j % 3] * jnp.cos(y)
            return y, k + 1

        start = (rates, 0)
        return jax.lax.while_loop(lambda s: (s[0][0] < x[3]) & (s[1] < 6), ahead, start)[0]

    later = jax.lax.cond(count > 3.0, chosen, otherwise)
    table = jnp.cumsum(x * x[place]) - x[::-1]
    for k in range(6):
        table = table * gain[k % 3] + jnp.roll(table, k) * jnp.sum(later)
    return later, count + table[place], x.at[place].set(later[0]) + table


def arguments():
    random = np.random.default_rng(2)
    rates, gain = random.normal(size=(2, LANES, 3))
    x = random.normal(size=(LANES, 20))
    count = random.uniform(0.0, 6.0, LANES)
    place = random.integers(0, 19, LANES)
    return {"rates": rates, "count": count, "gain": gain, "place": place, "x": x}


@pytest.fixture(scope="module")
def split():
    """The law as a module, with limits that small functions exceed."""
    example = {name: array[0] for name, array in arguments().items()}
    with pytest.MonkeyPatch.context() as patch:
        for name, value in LIMITS.items():
            patch.setattr(outlining, name, value)
        return emit("parts", [Entry("law", law, example, ("rates", "count", "x"))])


def test_parts_compute_what_the_function_computes(split, tools, tmp_path):
    _, found = tools.Compiled(split, tmp_path)("law", arguments())
    expected = jax.vmap(law)(*arguments().values())
    for name, values in zip(("rates", "count", "x"), expected, strict=True):
        np.testing.assert_allclose(found[name][0], values, rtol=1e-12, atol=1e-12)


def test_parts_are_short_have_few_parameters_and_are_called_once(split):
    *parts, (_, _, law_body) = HEAD.findall(split.source)
    assert len(parts) > 10
    for name, parameters, _ in parts:
        assert len(re.findall(rf"(?<!\w){name}\(", split.source)) == 2
        assert parameters.count(",") < LIMITS["MOST"] + 5  # with the arguments of the entry
    assert all(cost_of(function.body).size <= LIMITS["PART"] for function in split.functions[:-1])
    # a number that is passed by address is read where the address is
    assert "*count" not in "".join(body for _, _, body in parts)
    assert "*count" in law_body


def chain(x):
    for k in range(50):
        x = jnp.sin(x) + k
        x = x * x
    return x


def test_functions_up_to_the_limit_have_no_parts(monkeypatch):
    monkeypatch.setattr(outlining, "LEAST", LIMITS["LEAST"])

    def functions(limit):
        monkeypatch.setattr(outlining, "LONGEST", limit)
        monkeypatch.setattr(outlining, "PART", limit)
        return emit("chain", [Entry("chain", chain, {"x": np.zeros(())}, ("y",))]).functions

    (whole,) = functions(10**6)
    size = cost_of(whole.body).size
    assert len(functions(size)) == 1
    assert len(functions(size - 1)) > 1
