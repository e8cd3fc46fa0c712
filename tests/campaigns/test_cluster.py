"""Workers of a Dask scheduler that share no disk with the campaign, nor always its software."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time

import pytest

from gyrostat.core.instructions import environment, instructions
from tests.campaigns.dask_processes import SOURCE, processes
from tests.campaigns.test_faults import FAKE, begun, ended
from tests.campaigns.test_faults import RUNS as FAKE_RUNS

pytest.importorskip("distributed", reason="distributed is not installed")
RUNS = 70
GYROSTAT = "from gyrostat.cli import main; main()"


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """Scheduler with one worker that has no compiler."""
    with processes(tmp_path_factory.mktemp("dask")) as started:
        started.worker(PATH="/nonexistent")
        started.wait()
        yield started


def start(out, *words):
    """The fake campaign as a process of its own, at the head of its group."""
    return subprocess.Popen(
        [sys.executable, str(FAKE), str(out), str(FAKE_RUNS), "0.0", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def command(folder, out, *options):
    """Result of a campaign as a command."""
    words = ["campaign", str(folder / "scenario.toml"), "--runs", str(RUNS), "--out", str(out)]
    return subprocess.run(
        [sys.executable, "-c", GYROSTAT, *words, *options],
        capture_output=True,
        text=True,
        timeout=300,
        env={**os.environ, "PYTHONPATH": str(SOURCE)},
    )


@pytest.fixture(scope="module")
def local(folder, tmp_path_factory):
    """Table of a campaign without a cluster."""
    out = tmp_path_factory.mktemp("local")
    if shutil.which("cc") is None:
        pytest.skip("there is no C compiler (cc)")
    assert command(folder, out).returncode == 0
    return (out / "runs.parquet").read_bytes()


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """Table of a fake campaign without a cluster."""
    out = tmp_path_factory.mktemp("undisturbed")
    assert ended(start(out)) == (0, "")
    return (out / "runs.parquet").read_bytes()


def test_workers_without_compiler_or_common_disk_give_the_same_bytes(
    cluster, folder, local, tmp_path
):
    result = command(folder, tmp_path, "--scheduler", cluster.address)
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "runs.parquet").read_bytes() == local
    assert not [*(cluster.folder / "1" / "cache").glob("lanes-program-*")]


def other_package(folder, *, empty):
    """PYTHONPATH of another gyrostat: another version, or one without any of its modules."""
    package = folder / "gyrostat"
    if empty:
        package.mkdir(parents=True)
        (package / "__init__.py").write_text("")
    else:
        shutil.copytree(SOURCE / "gyrostat", package, ignore=shutil.ignore_patterns("*.pyc"))
        changed = package / "campaigns" / "draws.py"
        changed.write_text(changed.read_text() + "\n# another version\n")
    return str(folder)


def test_workers_that_may_differ_are_refused_with_a_line_each(folder, local, tmp_path):
    with processes(tmp_path / "dask") as cluster:
        cluster.worker(PYTHONPATH=other_package(tmp_path / "changed", empty=False))
        cluster.worker(PYTHONPATH=other_package(tmp_path / "empty", empty=True))
        refused = 2
        if "avx512f" in instructions() and os.environ.get("GYROSTAT_INSTRUCTIONS") is None:
            cluster.worker(**environment("x86-64-v3"))
            refused = 3
        cluster.wait()
        alone = command(folder, tmp_path / "out", "--scheduler", cluster.address)
        assert alone.returncode == 2, alone.stderr
        assert "all of them refused" in alone.stderr
        assert "Traceback" not in alone.stderr
        cluster.worker()
        cluster.wait()
        result = command(folder, tmp_path / "out", "--scheduler", cluster.address)
    assert result.returncode == 0, result.stderr
    assert "the worker is not used" in result.stderr
    lines = [line for line in alone.stderr.splitlines() if "the worker is not used" in line]
    assert len(lines) == refused
    assert all(": found " in line and ", expected " in line for line in lines)
    assert sum("found gyrostat " in line for line in lines) == 1
    assert sum("No module named 'gyrostat." in line for line in lines) == 1
    assert sum("found instructions x86-64-v3" in line for line in lines) == refused - 2
    assert (tmp_path / "out" / "runs.parquet").read_bytes() == local


def test_a_slow_worker_and_a_killed_one_change_nothing(tmp_path, undisturbed):
    with processes(tmp_path / "dask") as cluster:
        cluster.worker(FAKE_PAUSE="60")  # its jobs are given to others too
        lost = cluster.worker(FAKE_PAUSE="0.3")
        cluster.worker(FAKE_PAUSE="0.05")
        cluster.wait()
        process = start(tmp_path / "out", cluster.address)
        begun(process, tmp_path / "out")
        lost.kill()
        began = time.monotonic()
        code, messages = ended(process)
        assert (code, messages) == (0, "")
        assert time.monotonic() - began < 50.0, "it waited for the slow worker"
    assert (tmp_path / "out" / "runs.parquet").read_bytes() == undisturbed


def test_a_job_that_ends_its_workers_ends_the_campaign(tmp_path):
    with processes(tmp_path / "dask") as cluster:
        for _ in range(4):
            cluster.worker(FAKE_DIES_AT="0")
        cluster.wait()
        code, messages = ended(start(tmp_path / "out", cluster.address))
    assert code == 1
    (line,) = messages.splitlines()
    assert "found 3 workers that ended during one job" in line


def test_a_lost_scheduler_ends_the_campaign_and_another_goes_on(tmp_path, undisturbed):
    out = tmp_path / "out"
    with processes(tmp_path / "first") as cluster:
        cluster.worker(FAKE_PAUSE="0.4")
        cluster.wait()
        process = start(out, cluster.address)
        begun(process, out)
        cluster.scheduler.kill()
        code, messages = ended(process)
    assert code == 1
    (line,) = messages.splitlines()
    assert "found no answer from tcp://" in line
    assert "repeat the command" in line
    with processes(tmp_path / "second") as cluster:
        cluster.worker()
        cluster.wait()
        code, messages = ended(start(out, cluster.address))
    assert code == 0
    assert f"of {FAKE_RUNS} runs are already complete" in messages
    assert (out / "runs.parquet").read_bytes() == undisturbed


def numbers(folder):
    """Bytes of the tables, and the report without its own folder."""
    report = json.loads((folder / "report.json").read_text())
    tables = {each.name: each.read_bytes() for each in sorted(folder.rglob("*.parquet"))}
    return tables, {name: each for name, each in report.items() if name != "out"}


@pytest.mark.parametrize(
    "words",
    [
        ("campaign", "--rare", "error_max > 2 deg", "--runs", "4100"),
        ("campaign", "--worst-case", "error_rms", "--runs", "700"),
        ("tune", "--free", "controller.turn_gain", "--minimise", "error_rms", "--runs", "5760"),
        ("budget", "--runs", "16"),
    ],
    ids=["rare", "worst case", "tune", "budget"],
)
def test_searches_give_the_same_bytes(cluster, folder, local, tmp_path, words):
    verb, *options = words
    scenario = folder / "search.toml"
    scenario.write_text((folder / "scenario.toml").read_text().partition("[[requirement]]")[0])
    command = [sys.executable, "-c", GYROSTAT, verb, str(scenario), *options]
    for out, more in (("here", ()), ("there", ("--scheduler", cluster.address))):
        result = subprocess.run(
            [*command, "--out", str(tmp_path / out), *more], capture_output=True, text=True
        )
        assert "Traceback" not in result.stderr
        assert result.returncode in (0, 1), result.stderr
    here, there = (numbers(tmp_path / out) for out in ("here", "there"))
    assert here == there
    assert here[1]


def test_experiments_of_a_paper_give_the_same_claims(tmp_path):
    words = [sys.executable, "-c", GYROSTAT, "reproduce", "moreira-lopes-kuga", "--quick"]
    clean = {name: each for name, each in os.environ.items() if name != "XLA_FLAGS"}
    with processes(tmp_path / "dask") as cluster:
        for _ in range(2):
            cluster.worker(XLA_FLAGS="")
        cluster.wait()
        for out, more in (("here", ()), ("there", ("--scheduler", cluster.address))):
            command = [*words, "--out", str(tmp_path / out), *more]
            result = subprocess.run(command, capture_output=True, text=True, env=clean)
            assert result.returncode == 0, result.stderr
    first, second = ((tmp_path / out / "claims.json").read_bytes() for out in ("here", "there"))
    assert first == second


def test_a_job_of_slurm_is_a_worker(tmp_path, undisturbed):
    pytest.importorskip("dask_jobqueue", reason="dask-jobqueue is not installed")
    script = SOURCE.parent / "examples" / "cluster" / "slurm.py"
    words = ["scenario.toml", "10", str(tmp_path), "--script", "--queue", "short"]
    result = subprocess.run([sys.executable, script, *words], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    assert "#SBATCH -p short" in result.stdout
    with processes(tmp_path / "dask") as cluster:
        job = re.sub(r"tcp://\S+", cluster.address, result.stdout)
        worker = subprocess.Popen(
            ["bash"], stdin=subprocess.PIPE, text=True, start_new_session=True
        )
        worker.stdin.write(job)
        worker.stdin.close()
        try:
            code, messages = ended(start(tmp_path / "out", cluster.address))
        finally:
            os.killpg(worker.pid, signal.SIGKILL)
            worker.wait()
    assert code == 0, messages
    assert (tmp_path / "out" / "runs.parquet").read_bytes() == undisturbed
