"""Emitted validation of measurements: hostile samples, and options that assume finite numbers."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from gyrostat.codegen.flight import Entry, emit
from gyrostat.core.jax64 import jnp

SOAK = Path(__file__).parents[2] / "benchmarks" / "soak_flight_code.py"


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_no_hostile_sample_leaves_a_trace(compiler, module_at):
    """A small version of the soak, strict and with -O3 -ffast-math."""
    if shutil.which(compiler) is None:
        pytest.skip(f"found no {compiler}")
    soak = module_at(SOAK)
    texts = soak.sources(rate_limit=True, on_bad="hold")
    for flags in (soak.STRICT, soak.FAST):
        samples, rejected, *bad = soak.attack(texts, compiler, flags, 500)
        assert bad == [0, 0, 0]
        assert 0.1 * samples < rejected < 0.9 * samples


def test_the_attack_sees_a_missing_test(module_at, tools):
    soak = module_at(SOAK)
    texts = soak.sources(rate_limit=False, on_bad="hold")
    test = r"const bool in_range = [^;]*;"
    source = re.sub(test, "const bool in_range = true;", texts["compensator.c"])
    assert source != texts["compensator.c"]
    texts["compensator.c"] = source
    *_, differ, _, _ = soak.attack(texts, tools.compiler(), soak.STRICT, 200)
    assert differ > 0


@pytest.mark.parametrize("precision", ["double", "float"])
def test_finiteness_is_read_from_the_bits(precision, tools, tmp_path):
    def test(x):
        return jnp.isfinite(x)

    module = emit("tested", [Entry("tested", test, {"x": np.zeros(6)}, ("y",))], precision)
    assert "= isfinite(" not in module.source
    compiled = tools.Compiled(module, tmp_path, precision=precision)
    given = np.array([[np.nan, np.inf, -np.inf, 1e-310, 3e38, -0.0]])
    _, found = compiled("tested", {"x": given})
    np.testing.assert_array_equal(found["y"][0], np.isfinite(given))
