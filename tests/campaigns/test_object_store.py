"""Campaigns whose folder is on an object store: a server of S3 in this process, or in memory."""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from gyrostat.core import remote_folder, remote_lock
from gyrostat.core.errors import InputError
from gyrostat.core.files import check_writable
from gyrostat.core.remote_folder import is_remote, local_folder
from gyrostat.core.remote_lock import RemoteLock
from tests.campaigns.test_faults import RUNS, ended, start

SOURCE = Path(__file__).parents[2] / "src"


def test_addresses_of_stores_are_told_from_folders():
    assert is_remote("s3://bucket/prefix")
    assert is_remote("memory://a")
    assert not any(map(is_remote, ("s3:", "runs", "/tmp/s3://a", "C:/runs", Path("s3://a/b"))))


def test_addresses_are_no_folders_where_folders_are_expected(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("s3://bucket/prefix", "s3:/bucket", "gs:/a"):
        with pytest.raises(InputError, match=r"found an address, expected a folder"):
            check_writable(Path(name))
    check_writable(tmp_path / "s3:" / "bucket")
    assert not [*tmp_path.iterdir()]


def test_without_fsspec_a_line_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "fsspec", None)
    with (
        pytest.raises(InputError, match=r"^--out: found no fsspec, .*pip install 's3fs>="),
        local_folder("s3://bucket/prefix", print),
    ):
        pass


@pytest.fixture
def memory(monkeypatch):
    """File system in memory, with a short lease."""
    fsspec = pytest.importorskip("fsspec", reason="fsspec is not installed")
    monkeypatch.setattr(remote_lock, "BEAT", 0.1)
    files = fsspec.filesystem("memory")
    yield files
    files.rm("/", recursive=True)


def test_files_are_copied_renamed_and_found_again(memory):
    said = []
    with local_folder("memory://bucket/a", said.append) as (folder, tell):
        (folder / "blocks").mkdir()
        (folder / "blocks" / "0.parquet").write_text("zero")
        (folder / ".gyrostat-unfinished").write_text("half")
        tell(f"written: {folder / 'blocks'}")
    assert said == ["written: memory://bucket/a/blocks"]
    names = [path for path in memory.find("/bucket/a") if "/.lock-" not in path]
    assert names == ["/bucket/a/blocks/0.parquet"]
    with local_folder("memory://bucket/a", said.append) as (folder, _):
        assert [*folder.rglob("*.parquet")] == [folder / "blocks" / "0.parquet"]
        (folder / "blocks" / "0.parquet").rename(folder / "blocks" / "0.parquet.changed")
    names = [path for path in memory.find("/bucket/a") if "/.lock-" not in path]
    assert names == ["/bucket/a/blocks/0.parquet.changed"]
    assert memory.cat("/bucket/a/blocks/0.parquet.changed") == b"zero"


def test_a_folder_may_be_an_address_too(memory, tmp_path):
    for content in ("first", "second"):
        with local_folder(f"file://{tmp_path}/a", print) as (folder, _):
            assert content == "first" or (folder / "runs" / "x").read_text() == "first"
            (folder / "runs").mkdir(exist_ok=True)
            (folder / "runs" / "x").write_text(content)
    assert (tmp_path / "a" / "runs" / "x").read_text() == "second"
    assert len([*(tmp_path / "a").iterdir()]) == 2


def test_errors_name_the_address_and_what_is_complete_stays(memory):
    def write_and_fail():
        with local_folder("memory://bucket/b", print) as (folder, _):
            (folder / "done").write_text("done")
            raise InputError(f"{folder / 'x'}: found a fault, expected none")

    with pytest.raises(InputError, match=r"^memory://bucket/b/x: found a fault"):
        write_and_fail()
    assert memory.cat("/bucket/b/done") == b"done"


def test_a_lock_is_refused_while_its_holder_counts_and_taken_over_later(memory):
    first = RemoteLock(memory, "/bucket/c", "memory://bucket/c", print)
    said = []
    with pytest.raises(InputError, match="found another campaign running here"):
        RemoteLock(memory, "/bucket/c", "memory://bucket/c", said.append)
    assert "waiting" in said[0]
    first._ended.set()  # as if it were killed
    first._thread.join()
    second = RemoteLock(memory, "/bucket/c", "memory://bucket/c", said.append)
    with pytest.raises(InputError, match="another campaign"):
        RemoteLock(memory, "/bucket/c", "memory://bucket/c", print)
    second.release()
    RemoteLock(memory, "/bucket/c", "memory://bucket/c", print).release()
    assert memory.find("/bucket/c") == ["/bucket/c/.lock-000003"]


def test_a_holder_that_slept_notices_that_another_took_over(memory):
    slow = RemoteLock(memory, "/bucket/d", "memory://bucket/d", print)
    memory.pipe_file("/bucket/d/.lock-000002", b"{}")
    time.sleep(0.3)
    assert slow.is_lost


@pytest.fixture(scope="module")
def server():
    """Address and bucket of a server of S3."""
    moto = pytest.importorskip("moto.server", reason="moto[server] is not installed")
    pytest.importorskip("s3fs", reason="s3fs is not installed")
    import boto3

    instance = moto.ThreadedMotoServer("127.0.0.1", 0, verbose=False)
    instance.start()
    host, port = instance.get_host_and_port()
    patch = pytest.MonkeyPatch()
    patch.setenv("AWS_ENDPOINT_URL", f"http://{host}:{port}")
    patch.setenv("AWS_ACCESS_KEY_ID", "test")
    patch.setenv("AWS_SECRET_ACCESS_KEY", "test")
    patch.setenv("AWS_DEFAULT_REGION", "us-east-1")
    client = boto3.client("s3")
    client.create_bucket(Bucket="runs")
    yield client
    patch.undo()
    instance.stop()


def contents(client, prefix):
    """Name -> content of the objects below a prefix, without the lock."""
    listed = client.list_objects_v2(Bucket="runs", Prefix=f"{prefix}/").get("Contents", [])
    names = [each["Key"] for each in listed if "/.lock-" not in each["Key"]]
    read = {name: client.get_object(Bucket="runs", Key=name)["Body"].read() for name in names}
    return {name.removeprefix(f"{prefix}/"): content for name, content in read.items()}


def files_of(folder):
    """Name -> content of the files of a folder."""
    paths = [path for path in folder.rglob("*") if path.is_file() and path.name != ".lock"]
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}


def stored(client, prefix):
    """Wait for the first block on the store."""
    for _ in range(1200):
        if any(name.startswith("blocks/") for name in contents(client, prefix)):
            return
        time.sleep(0.05)
    raise AssertionError("no block was stored")


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """Folder of a fake campaign on this machine."""
    out = tmp_path_factory.mktemp("undisturbed")
    assert ended(start(out)) == (0, "")
    return out


def test_a_killed_campaign_goes_on_from_the_store(server, undisturbed):
    process = start("s3://runs/killed", 0.3)
    stored(server, "killed")
    process.kill()
    process.communicate()
    before = contents(server, "killed")
    assert "runs.parquet" not in before
    code, messages = ended(start("s3://runs/killed"))
    assert code == 0, messages
    waited, complete = messages.splitlines()
    assert "waiting 8 s whether it lives" in waited
    assert re.fullmatch(rf"\d+ of {RUNS} runs are already complete", complete)
    assert contents(server, "killed") == files_of(undisturbed)


def test_of_two_at_once_one_is_refused(server, undisturbed):
    both = [start("s3://runs/both", 0.8) for _ in range(2)]
    ends = sorted(ended(process) for process in both)
    assert [code for code, _ in ends] == [0, 1]
    assert "s3://runs/both: found another campaign running here" in ends[1][1]
    assert contents(server, "both") == files_of(undisturbed)


def command(*words, **environment):
    """Result of a command."""
    program = "from gyrostat.cli import main; main()"
    return subprocess.run(
        [sys.executable, "-c", program, *words],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(SOURCE), **environment},
    )


def test_stores_that_cannot_be_used_are_one_line(server, folder):
    words = "campaign", str(folder / "scenario.toml"), "--runs", "2", "--out"
    nowhere = command(*words, "s3://nothing/a")
    no_keys = {"AWS_ACCESS_KEY_ID": "", "AWS_SECRET_ACCESS_KEY": "", "HOME": "/nonexistent"}
    stranger = command(*words, "s3://runs/b", AWS_EC2_METADATA_DISABLED="true", **no_keys)
    unknown = command(*words, "s4://runs/c")
    results = (nowhere, "s3://nothing/a"), (stranger, "s3://runs/b"), (unknown, "s4://runs/c")
    for result, address in results:
        assert result.returncode == 2, result.stderr
        line = result.stderr.splitlines()[-1]
        assert address in line
        assert ": found " in line
        assert ", expected " in line
        assert "Traceback" not in result.stderr
    assert contents(server, "b") == {}


def test_a_report_is_made_on_the_store(server, small, tmp_path):
    shutil.copytree(small.out, tmp_path / "made")
    here = command("report", str(tmp_path / "made"), "--json")
    for name, content in files_of(small.out).items():
        server.put_object(Bucket="runs", Key=f"made/{name}", Body=content)
    result = command("report", "s3://runs/made", "--json")
    assert result.returncode == 0, result.stderr
    assert result.stdout == here.stdout
    written = contents(server, "made")
    assert b"gyrostat replay s3://runs/made" in written["report.html"]
    assert written["runs.parquet"] == files_of(small.out)["runs.parquet"]


def test_what_cannot_be_copied_at_the_end_is_kept(memory, monkeypatch):
    said = []

    def work():
        with local_folder("memory://bucket/e", said.append) as (folder, _):
            (folder / "first").write_text("first")
            kept.append(folder)
            time.sleep(2.5 * remote_folder.LOOK)
            monkeypatch.setattr(type(memory), "put_file", refuse)
            (folder / "late").write_text("late")
            time.sleep(2.5 * remote_folder.LOOK)

    def refuse(*_):
        raise PermissionError("ExpiredToken")

    kept = []
    monkeypatch.setattr(remote_folder, "LOOK", 0.05)
    with pytest.raises(InputError, match=r"ExpiredToken.* goes on with them") as error:
        work()
    assert str(kept[0]) in str(error.value)
    assert (kept[0] / "late").read_text() == "late"
    assert len(said) == 1
    assert "ExpiredToken" in said[0]
    shutil.rmtree(kept[0].parent)


def test_files_that_are_not_of_the_campaign_stay_on_the_store(memory):
    others = {"/bucket/f/.lock": b"theirs", "/bucket/f/.gyrostat-user/x": b"theirs"}
    for path, content in others.items():
        memory.pipe_file(path, content)
    with local_folder("memory://bucket/f", print) as (folder, _):
        assert [*folder.iterdir()] == []
    assert {path: memory.cat(path) for path in others} == others


def test_objects_that_mark_folders_are_no_files(server):
    for name in ("marked/", "marked/blocks/"):
        server.put_object(Bucket="runs", Key=name, Body=b"")
    with local_folder("s3://runs/marked", print) as (folder, _):
        (folder / "blocks").mkdir()
        (folder / "blocks" / "0").write_text("zero")
    assert contents(server, "marked") == {"": b"", "blocks/": b"", "blocks/0": b"zero"}


def test_a_folder_that_cannot_be_read_removes_nothing(memory, monkeypatch):
    memory.pipe_file("/bucket/g/blocks/0", b"zero")

    def work():
        with local_folder("memory://bucket/g", print) as (folder, _):
            shutil.rmtree(folder)
            copies.append(folder)

    copies = []
    with pytest.raises(InputError, match="FileNotFoundError"):
        work()
    assert memory.cat("/bucket/g/blocks/0") == b"zero"
    shutil.rmtree(copies[0].parent)


def test_a_store_without_conditional_creation_is_refused(memory, monkeypatch):
    create = type(memory).pipe_file
    monkeypatch.setattr(
        type(memory), "pipe_file", lambda self, path, value, **_: create(self, path, value)
    )
    with pytest.raises(InputError, match="two campaigns could write"):
        RemoteLock(memory, "/bucket/h", "memory://bucket/h", print)
    assert memory.find("/bucket/h") == []
