"""A small version of benchmarks/soak_files.py on the small campaign, as the verbs are typed."""

import random
import shutil
from collections import Counter
from pathlib import Path

import pytest

from gyrostat.campaigns import run_campaign

SOAK = Path(__file__).parents[2] / "benchmarks" / "soak_files.py"


@pytest.fixture(scope="module")
def attack(small, scenario, folder, module_at, tmp_path_factory):
    """The attack on a copy of the small campaign, beside another one."""
    soak, place = module_at(SOAK), tmp_path_factory.mktemp("attack")
    with pytest.MonkeyPatch.context() as patched:
        soak.fly_here(small.opener, patched.setattr)
        soak.work_once(patched.setattr)
        shutil.copytree(small.out, place / "work")
        words = ("campaign", folder / "scenario.toml", "--runs", small.runs, "--seed", small.seed)
        words += ("--keep", 5, "--worst", 1, "--out", place / "work")
        assert soak.verb(*words)[0] == 0
        (place / "work").rename(place / "pristine")
        run_campaign(
            scenario, place / "other", runs=small.runs, seed=1, opener=small.opener, worst=0
        )
        verbs = {"campaign": words, "report": ("report", place / "work")}
        yield soak.Attack(place / "pristine", place / "other", place / "work", verbs)


def test_damage_is_repaired_or_refused(attack):
    choice = random.Random(3)
    for _ in range(3):
        attack.flip(choice)
    for _ in range(4):
        attack.other_damage(choice)
    outcomes = Counter()
    for (_, _, outcome), count in attack.counts.items():
        outcomes[outcome] += count
    assert attack.faults == []
    assert outcomes["repaired"] > 0
    assert outcomes["repaired"] + outcomes["refused"] == 14


def test_what_is_passed_over_is_seen(attack):
    """The judge itself: an answer that leaves a flipped bit is silent."""
    shutil.rmtree(attack.work, ignore_errors=True)
    shutil.copytree(attack.pristine, attack.work)
    table = attack.work / "runs.parquet"
    table.write_bytes(table.read_bytes()[:-1])
    assert attack.judge("report", 0, "", {}) == "silent"
    assert attack.judge("report", 2, "error: no", {}) == "refused"
    assert attack.judge("report", 1, "Traceback", {}) == "traceback"
