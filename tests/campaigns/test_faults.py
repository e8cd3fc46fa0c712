"""What a campaign survives, each fault really made: processes killed, a full disk, a broken file.

The runs cost nothing (fake_campaign.py beside this file); store, executor and processes are real.
"""

import dataclasses
import multiprocessing
import os
import random
import re
import shutil
import signal
import subprocess
import tempfile
import time
from importlib import import_module
from multiprocessing import spawn
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from gyrostat.campaigns import Store

FAKE = Path(__file__).with_name("fake_campaign.py")
IMPORTS = (
    *("fake_campaign", "gyrostat.campaigns.execute", "gyrostat.campaigns.cluster"),
    *("gyrostat.core.remote_folder", "gyrostat.scenario.metrics.results", "pyarrow.parquet"),
)
RUNS = 41  # the last block is not full


class Campaign:
    """A campaign as a process of its own, at the head of its group.

    It is forked from a process that has imported what it needs, which takes most of its time.
    """

    def __init__(self, context, target, out, pause, environment):
        self._files = [Path(tempfile.mkstemp()[1]) for _ in range(2)]
        words = [str(out), str(RUNS), str(pause)]
        self._process = context.Process(target=target, args=(words, self._files, environment))
        self._process.start()
        self.pid, self.kill, self.wait = self._process.pid, self._process.kill, self._process.join

    @property
    def returncode(self):
        return self._process.exitcode

    def poll(self):
        return self.returncode

    def communicate(self, timeout=None):
        """Both outputs, after the end."""
        self.wait(timeout)
        assert self.returncode is not None
        texts = [path.read_text() for path in self._files]
        for path in self._files:
            path.unlink()
        return texts


@pytest.fixture(scope="module")
def start():
    """Start a campaign."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(FAKE.parent)
        # as of workers: the process does not run the main module, which is that of pytest
        prepare = spawn.get_preparation_data

        def without_main(name):
            return {k: v for k, v in prepare(name).items() if not k.startswith("init_main")}

        patch.setattr(spawn, "get_preparation_data", without_main)
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload([*IMPORTS])
        target = import_module(FAKE.stem).begin
        yield lambda out, pause=0.0, **environment: Campaign(
            context, target, out, pause, environment
        )


def ended(process):
    """Exit code and messages."""
    _, messages = process.communicate(timeout=120)
    return process.returncode, messages


def begun(process, out):
    """Wait for the first block."""
    while not list(out.glob("blocks/0*.parquet")):
        assert process.poll() is None, process.communicate()
        time.sleep(0.02)


@pytest.fixture(scope="module")
def undisturbed(start, tmp_path_factory):
    """Bytes of the table of a campaign that nothing happened to."""
    out = tmp_path_factory.mktemp("undisturbed")
    assert ended(start(out)) == (0, "")
    table = pq.read_table(out / "runs.parquet")
    assert table["run"].to_pylist() == list(range(RUNS))
    return (out / "runs.parquet").read_bytes()


def gone(process):
    """Wait until no process of its group is left."""
    for _ in range(200):
        try:
            os.killpg(process.pid, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


def test_killed_at_ten_random_moments_it_ends_with_the_same_table(start, tmp_path, undisturbed):
    moments, killed, processes = random.Random(7), 0, []
    for _ in range(10):
        # at most 10 of the 11 blocks are done before they are killed, however fast a process starts
        processes.append(start(tmp_path, 0.3))
        time.sleep(moments.uniform(0.2, 1.1))
        killed += processes[-1].poll() is None
        processes[-1].kill()
        processes[-1].wait()
    for process in processes:
        output, messages = process.communicate(timeout=120)
        assert output == ""
        assert re.fullmatch(rf"(\d+ of {RUNS} runs are already complete\n)?", messages), messages
        assert gone(process), "workers outlive the campaign that made them"
    assert killed >= 5
    code, messages = ended(start(tmp_path))
    assert code == 0, messages
    assert (tmp_path / "runs.parquet").read_bytes() == undisturbed
    assert {p.name for p in tmp_path.rglob(".*")} == {".lock", ".gyrostat.json"}


def test_a_killed_worker_costs_nothing(start, tmp_path, undisturbed):
    once = tmp_path / "died"
    process = start(tmp_path / "out", FAKE_DIES_AT="17", FAKE_DIES_ONCE=str(once))
    assert ended(process) == (0, "")
    assert once.exists()
    assert (tmp_path / "out" / "runs.parquet").read_bytes() == undisturbed


def test_workers_that_always_die_end_the_campaign(start, tmp_path):
    process = start(tmp_path / "out", FAKE_DIES_AT="0")
    code, messages = ended(process)
    assert code == 1
    assert "Traceback" not in messages
    assert "3 worker pools in a row" in messages


def test_control_c_stops_cleanly_and_it_goes_on(start, tmp_path, undisturbed):
    process = start(tmp_path, 0.4)
    begun(process, tmp_path)
    os.killpg(process.pid, signal.SIGINT)  # a terminal sends it to all of them
    code, messages = ended(process)
    assert (code, messages) == (130, "")
    assert gone(process)
    code, messages = ended(start(tmp_path))
    assert code == 0
    assert f"of {RUNS} runs are already complete" in messages
    assert (tmp_path / "runs.parquet").read_bytes() == undisturbed


def test_damaged_blocks_are_flown_again(start, tmp_path, undisturbed):
    ended(start(tmp_path))
    (flipped,), (cut,) = (tmp_path.glob(f"blocks/00000{k}.*") for k in (3, 5))
    content = bytearray(flipped.read_bytes())
    content[len(content) // 2] ^= 1
    flipped.write_bytes(content)
    cut.write_bytes(cut.read_bytes()[:-7])
    (tmp_path / "runs.parquet").unlink()
    code, messages = ended(start(tmp_path))
    assert code == 0
    assert "block 3 is damaged" in messages
    assert "block 5 is damaged" in messages
    assert (tmp_path / "runs.parquet").read_bytes() == undisturbed


def test_another_engine_is_refused(start, tmp_path):
    ended(start(tmp_path))
    known = Store(tmp_path).known()
    other = dataclasses.replace(known, engine={**known.engine, "jaxlib": "0.0.1"})
    (tmp_path / "campaign.json").write_text(other.text())
    code, messages = ended(start(tmp_path))
    assert code == 1
    assert "found jaxlib" in messages
    assert "expected 0.0.1, as recorded" in messages


def test_results_of_unknown_origin_are_refused_and_hidden_files_left_alone(start, tmp_path):
    (tmp_path / ".abcdefgh.parquet").write_text("mine")
    (tmp_path / "runs.parquet").write_text("mine too")
    code, messages = ended(start(tmp_path))
    assert code == 1
    assert "found results without their campaign.json" in messages
    assert (tmp_path / "runs.parquet").read_text() == "mine too"
    (tmp_path / "runs.parquet").unlink()
    assert ended(start(tmp_path))[0] == 0
    assert (tmp_path / ".abcdefgh.parquet").read_text() == "mine"


def test_a_full_disk_is_told_and_survived(start, tmp_path, undisturbed):
    small = tmp_path / "small"
    small.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=44k", "tmpfs", str(small)]
    if os.geteuid() != 0 or shutil.which("mount") is None:
        pytest.skip("a small file system can be made by root only")
    made = subprocess.run(mount, capture_output=True, text=True)
    if made.returncode != 0:
        pytest.skip(f"no small file system could be mounted here: {made.stderr.strip()}")
    try:
        code, messages = ended(start(small))
        assert code == 1
        assert "Traceback" not in messages
        assert "No space left on device" in messages
        found = [path.name for path in small.glob("blocks/0*.parquet")]
        assert 0 < len(found) < 11
        subprocess.run(["mount", "-o", "remount,size=4m", str(small)], check=True)
        code, messages = ended(start(small))
        assert code == 0, messages
        assert "runs are already complete" in messages
        assert (small / "runs.parquet").read_bytes() == undisturbed
    finally:
        subprocess.run(["umount", str(small)], check=True)


def test_two_at_once_are_refused(start, tmp_path):
    # long enough for the second to begin, on a busy machine too
    first = start(tmp_path, 2.0)
    begun(first, tmp_path)
    code, messages = ended(start(tmp_path))
    os.killpg(first.pid, signal.SIGINT)
    ended(first)
    assert code == 1
    assert "found another campaign running here" in messages
