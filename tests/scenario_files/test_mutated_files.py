"""A share of benchmarks/soak_mutated_files.py: files are read, or refused in one line."""

import importlib.util
import time
from pathlib import Path

import pytest

SOAK = Path(__file__).parents[2] / "benchmarks" / "soak_mutated_files.py"


@pytest.fixture(scope="module")
def soak():
    if not SOAK.is_file():
        pytest.skip("found no benchmarks/soak_mutated_files.py, which a source distribution lacks")
    spec = importlib.util.spec_from_file_location("soak_mutated_files", SOAK)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.filterwarnings("ignore")
def test_mutated_files_are_read_or_refused_in_one_line(soak):
    counts, faults = soak.soak(2, 320, [*soak.KINDS])
    assert faults == []
    for kind in soak.KINDS:
        assert 0 < counts[kind, "read"] < counts[kind, "refused"] + 20


def no_refusal(path):
    raise ValueError("no")


def endless(path):
    time.sleep(10.0)


@pytest.mark.parametrize(
    ("read", "expected"), [(no_refusal, "ValueError: no"), (endless, "not read in 1 s")]
)
def test_faults_are_found(soak, monkeypatch, read, expected):
    monkeypatch.setattr(soak, "LONGEST", 1)
    monkeypatch.setitem(soak.KINDS, "model", (soak.KINDS["model"][0], read))
    counts, faults = soak.soak(1, 2, ["model"])
    assert counts["model", "fault"] == 2
    assert all(expected in fault for fault in faults)
