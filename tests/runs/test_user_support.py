"""What `check` says about the engine and the export of a user's part, against what happens."""

import json

import pytest

import gyrostat as gs
from gyrostat.campaigns.native import trace
from gyrostat.codegen.flight.c import emit
from gyrostat.core.errors import InputError
from gyrostat.exports import scenario_controller
from gyrostat.runs.plans import designs_of
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario_files.scenario_file import read_scenario

HEAD = """
from typing import NamedTuple
import equinox as eqx
import jax
import jax.numpy as jnp

class Command(NamedTuple):
    torque: jnp.ndarray
"""
PART = """
class {name}(eqx.Module):
    {field}

    def start(self, period):
        return {start}

    def __call__(self, memory, y):
        {line}
        return memory, {result}
"""
WHILE = "w = jax.lax.while_loop(lambda x: x > 1.0, lambda x: 0.5 * x, 3.0 + y.rate[0])"
GAMMA = "w = jax.scipy.special.gammaln(2.5 + y.rate[0])"
OF_TIME = "w = jax.scipy.special.gammaln(1.0 + time)"
NOISE = "w = jax.random.normal(jax.random.fold_in(jax.random.key(1), memory.astype(int)))"
RAW = "w = jax.random.normal(memory)"
CASES = {
    # memory, line, and what is refused by the native engine and in the export
    "arithmetic": ("0.0", "w = jnp.sort(y.rate)[0]", None, None),
    "loop without a bound": ("0.0", WHILE, None, "a loop without a bound (while)"),
    "gamma function": ("0.0", GAMMA, "(lgamma)", "(lgamma)"),
    "random numbers": ("0.0", NOISE, None, "random numbers"),
    "random key as numbers": ("jax.random.PRNGKey(3)", RAW, None, "random numbers"),
}


def source(start, line, name="P", field="kp: float = 1.0", result=None):
    result = result or "Command(1e-6 * w * jnp.ones(4))"
    return PART.format(name=name, field=field, start=start, line=line, result=result)


def refused(function):
    """Message of the refusal of a function; None if it refuses nothing."""
    try:
        function()
    except InputError as error:
        return str(error)
    return None


@pytest.mark.parametrize(("start", "line", "native", "export"), CASES.values(), ids=CASES)
def test_check_says_what_happens_and_because_of_which_line(
    folder, short, start, line, native, export
):
    text = HEAD + source(start, line)
    (folder / "own.py").write_text(text)
    said = []
    support = gs.check(short(), say=said.append).parts["controller"]
    scenario = read_scenario(folder / "own.toml")
    refusals = [refused(lambda: trace(structure_of(scenario), designs_of(scenario), 0))]
    if native != export or export is None:  # an export takes long
        refusals.append(refused(lambda: emit("c", scenario_controller(scenario, "hold").entries)))
    culprit = start if "PRNGKey" in start else line
    (number,) = [k for k, entry in enumerate(text.splitlines(), 1) if culprit in entry]
    for expected, obstacle, message in zip((native, export), support, refusals, strict=False):
        assert (obstacle is None) == (expected is None) == (message is None)
        if obstacle is not None:
            assert expected in obstacle.operation
            assert (obstacle.file, obstacle.line) == ("own.py", number)
            assert f"own.py line {number}, `" in said[1]
    assert said[1].startswith("  engine: " + ("JAX only" if native else "native or JAX"))
    assert f"export to C: {'no' if export else 'yes'}" in said[1]


def test_each_part_has_its_own_line(run, folder, short):
    """The controller and its wrapper are native, a torque is not."""
    compensator = '[compensator]\npython = "own.py:Wrapper"\n'
    torque = '[[environment.torque]]\npython = "own.py:drag"\n'
    wrapper = source(
        "self.controller.start(period)",
        "memory, command = self.controller(memory, y)",
        name="Wrapper",
        field="controller: object = None",
        result="command",
    )
    (folder / "own.py").write_text(
        HEAD
        + source("0.0", "w = y.rate[0]")
        + wrapper
        + f"\ndef drag(spacecraft, attitude, time):\n    {OF_TIME}\n"
        + "    return 1e-9 * w * jnp.ones(3)\n"
    )
    code, out, err = run("check", short(more=compensator + torque), "--json")
    assert code == 0, err
    parts = json.loads(out)["parts"]
    assert parts["controller"] == parts["compensator"]
    assert parts["controller"] == {"native": None, "export": None, "exported": True}
    torque = parts["environment.torque.drag"]
    assert torque["native"]["operation"] == "a primitive (lgamma)"
    assert torque["native"]["text"].startswith("w = jax.scipy.special.gammaln(")
    assert not torque["exported"]
    assert "export to C: not in flight code" in err


def test_a_random_key_in_the_memory_is_refused_in_one_line(folder, short):
    (folder / "own.py").write_text(HEAD + source("jax.random.key(3)", "w = 1.0"))
    with pytest.raises(InputError, match="found a random key of JAX as memory, expected numbers"):
        read_scenario(short())
