"""Parameters that are large tables, as those of an orbit, are constants of the emitted C."""

import subprocess
from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
import pytest

from gyrostat.codegen.flight.measure import measure
from gyrostat.control import MeasurementGuard
from gyrostat.core.files import write_texts
from gyrostat.core.jax64 import jax, jnp
from gyrostat.exports import files
from gyrostat.exports.targets import flight_loop

ROWS = 600


class Measurement(NamedTuple):
    """Rate of a body, rad/s."""

    rate: Any


class Command(NamedTuple):
    """Motor torque, N·m."""

    torque: Any


class TableLaw(eqx.Module):
    """Torque by interpolation in two tables; the memory is the time, s."""

    gain: Any
    first: Any
    second: Any

    def start(self, period):
        return jnp.zeros(()) * period

    def __call__(self, memory, measurement):
        torque = -self.gain * measurement.rate
        for table in (self.first, self.second):
            place = jnp.clip(memory, 0.0, ROWS - 1.5)
            row = place.astype(int)
            pair = jax.lax.dynamic_slice(table, (row, 0), (2, 2))
            torque = torque + (pair[0] + (place - row) * (pair[1] - pair[0])).sum()
        return memory + 0.7, Command(torque)


@pytest.fixture(scope="module")
def law():
    """Law whose two tables, of 1200 numbers, are equal."""
    table = np.random.default_rng(1).standard_normal((ROWS, 2))
    return TableLaw(jnp.asarray(0.5), jnp.asarray(table), jnp.asarray(table.copy()))


@pytest.fixture(scope="module")
def texts(law):
    rate = jnp.asarray(np.random.default_rng(2).standard_normal(40)).at[7].set(jnp.nan)
    guard = MeasurementGuard.of(Measurement(0.0), None, "hold")
    target = flight_loop("tabled", "Law of two tables", law, 0.1, guard, Measurement(rate))
    return files(target, "double", "")


def test_equal_tables_are_one_constant_and_no_parameter(texts, law):
    source = texts["tabled.c"]
    assert source.count("static const double") == 1
    assert "constant_table[1200] = {" in source
    assert repr(law.first[0, 0].item()) in source
    assert "double gain;" in texts["tabled.h"]
    assert "double first" not in texts["tabled.h"]
    assert "constants of the code" in texts["tabled.h"]
    assert "found 1200 numbers" in texts["README.md"]


def test_the_code_with_tables_is_as_python_and_keeps_them_off_the_stack(texts, tools, tmp_path):
    write_texts(tmp_path, texts)
    tools.build(tmp_path, "tabled.c", "tabled_test.c", "-lm", "-o", "program")
    done = subprocess.run([tmp_path / "program"], capture_output=True, text=True)
    assert done.stdout == texts["expected.txt"]
    found = measure(texts, "tabled")
    assert found is not None
    assert max(found.stack.values(), default=0) < 512
