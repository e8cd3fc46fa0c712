"""Common instruction sets: what is refused, and that a process limited to one says so."""

import json
import os
import subprocess
import sys

import pytest

from gyrostat.core import instructions
from gyrostat.core.errors import InputError

SPREAD = """
[[dispersion]]
key = "wheel.a.inertia"
distribution = "normal"
sigma = "1 %"
"""
V3 = "x86-64-v3"


@pytest.fixture
def processor(monkeypatch):
    """Sets the features of the processor and of NumPy, and limits the process."""

    def has(features, of_numpy=(), limited=True):
        monkeypatch.setattr(instructions, "_features", lambda: set(features))
        monkeypatch.setattr(instructions, "_of_numpy", lambda: list(of_numpy))
        for key, value in instructions.environment(V3).items():
            monkeypatch.setenv(key, value)
        if not limited:
            monkeypatch.delenv(instructions.NAME)

    return has


def test_processors_with_a_common_set_have_the_same_fingerprint(processor):
    needed = instructions.COMMON[V3].needed
    for more in ((), ("avx512f", "amx")):
        processor({*needed, *more})
        assert instructions.instructions() == V3
        processor({*needed, *more}, limited=False)
        assert ("avx512f" in instructions.instructions()) == bool(more)


def test_a_processor_that_lacks_some_of_it_is_refused(processor):
    processor(instructions.COMMON[V3].needed - {"fma"})
    with pytest.raises(InputError, match=f"without fma, expected {V3}"):
        instructions.instructions()


@pytest.mark.parametrize("key", [*instructions.environment(V3)][1:])
def test_a_process_that_was_started_otherwise_is_refused(processor, monkeypatch, key):
    processor(instructions.COMMON[V3].needed)
    monkeypatch.setenv(key, "")
    with pytest.raises(InputError, match="before Python starts"):
        instructions.instructions()


@pytest.mark.parametrize("feature", ["X86_V4", "AVX512_SKX"])
def test_a_numpy_that_uses_more_is_refused(processor, feature):
    processor(instructions.COMMON[V3].needed, of_numpy=[feature])
    with pytest.raises(InputError, match="before Python starts"):
        instructions.check_instructions(V3)


def test_other_names_are_refused(processor):
    processor(instructions.COMMON[V3].needed)
    for name in ("avx2", "x86-64-v4"):
        with pytest.raises(InputError, match=f"found.*{name}"):
            instructions.check_instructions(name)


def test_the_variables_limit_numpy_and_xla(tmp_path):
    """In a new process, since the libraries choose when they are loaded."""
    if not instructions.COMMON[V3].needed <= instructions._features():
        pytest.skip(f"processor without {V3}")
    program = (
        "import numpy as np, json, jax; "
        "from gyrostat.core.instructions import check_instructions; "
        f"check_instructions({V3!r}); jax.jit(abs)(1.0); "
        "print(json.dumps(np.show_config(mode='dicts')['SIMD Extensions']['found']))"
    )
    limited = {**os.environ, **instructions.environment(V3)}
    words = [sys.executable, "-c", program]
    done = subprocess.run(words, env=limited, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert not any(each.startswith(("AVX512", "X86_V4")) for each in json.loads(done.stdout))
    bare = {k: v for k, v in os.environ.items() if k not in instructions.environment(V3)}
    done = subprocess.run(words, env=bare, capture_output=True, text=True, cwd=tmp_path)
    assert "expected GYROSTAT_INSTRUCTIONS='x86-64-v3'" in done.stderr


def test_a_campaign_with_a_common_set_is_replayed_with_it(short, tmp_path, run, monkeypatch):
    """In new processes, which it limits itself; one that has loaded NumPy does not go on."""
    if not instructions.COMMON[V3].needed <= instructions._features():
        pytest.skip(f"processor without {V3}")
    scenario = short('kind = "three_axis"', SPREAD)
    start = ["campaign", str(scenario), "--runs", "4", "--worst", "0", "--out", "runs"]

    def done(*command):
        program = f"import sys; from gyrostat.cli import main; sys.argv[1:] = {command}; main()"
        words = [sys.executable, "-c", program]
        found = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path)
        return found.returncode, found.stderr

    code, said = done(*start, "--instructions", V3)
    assert code == 0, said
    engine = json.loads((tmp_path / "runs" / "campaign.json").read_text())["engine"]
    assert engine["instructions"] == V3
    code, said = done("replay", "runs", "2")
    assert code == 0, said
    assert "bit for bit" in said
    monkeypatch.chdir(tmp_path)
    code, _, said = run(*start)
    assert code == 2
    assert f"expected {V3} (--instructions {V3}, or " in said
