"""Flight C is the same, byte by byte, from another process, processor and interpreter."""

import os
import shutil
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

SAME_C = Path(__file__).parents[2] / "benchmarks" / "same_c.py"
NAMES = ("compensator",)


@pytest.fixture(scope="module")
def same_c(module_at):
    if not SAME_C.is_file():
        pytest.skip("found no benchmarks/same_c.py, which a source distribution lacks")
    return module_at(SAME_C)


@pytest.fixture(scope="module")
def exported(same_c, tmp_path_factory):
    """Folder of what this process exports."""
    folder = tmp_path_factory.mktemp("here")
    same_c.export_all(folder, NAMES)
    return folder


def test_another_process_on_an_older_processor_writes_the_same(same_c, exported, tmp_path):
    environment = {**same_c.OLD_PROCESSOR, "PYTHONHASHSEED": "12345"}
    same_c.export_elsewhere(sys.executable, tmp_path, NAMES, **environment)
    assert same_c.differences(exported, tmp_path, NAMES) == dict.fromkeys(NAMES, 0.0)


def others():
    """Interpreters of other versions that have this version of JAX.

    Those of the path, and those that the variable GYROSTAT_PYTHONS lists.
    """
    listed = os.environ.get("GYROSTAT_PYTHONS", "").split(os.pathsep)
    names = [f"python3.{minor}" for minor in (11, 12, 13) if minor != sys.version_info.minor]
    for python in filter(None, (*listed, *map(shutil.which, names))):
        code = "import equinox, jax, typer; print(jax.__version__)"
        done = subprocess.run([python, "-c", code], capture_output=True, text=True)
        if done.stdout.strip() == version("jax"):
            yield python


def test_another_interpreter_writes_the_same(same_c, exported, tmp_path):
    pythons = list(others())
    if not pythons:
        pytest.skip(f"no other Python of 3.11 to 3.13 with JAX {version('jax')}")
    for number, python in enumerate(pythons):
        folder = tmp_path / str(number)
        folder.mkdir()
        same_c.export_elsewhere(python, folder, NAMES)
        assert same_c.differences(exported, folder, NAMES) == dict.fromkeys(NAMES, 0.0), python


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        ("x = 0.1;", "x = 0.1;", 0.0),
        ("x = 0.4330127018922193;", "x = 0.4330127018922194;", 2.3e-16),
        ("x = -2.0e-05f;", "x = -2.5e-05f;", 0.2),
        ("x = 1.0 * y2;", "x = 1.0 * y3;", None),
        ("x = 1.0;", "x = 1.0 + 2.0;", None),
    ],
)
def test_numbers_and_code_are_told_apart(same_c, one, other, expected):
    found = same_c.difference(one, other)
    assert found == (None if expected is None else pytest.approx(expected, rel=0.05))
