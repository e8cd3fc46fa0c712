"""The private cache: what it trusts, what damage does, and what a killed compiler leaves."""

import os
import signal
import subprocess
import sys
import time

import pytest
from jax._src import compilation_cache

from gyrostat.core.cache import private_cache
from gyrostat.core.jax64 import jax
from gyrostat.core.jax_cache import _Store

NAME, CONTENT = "lanes-0", bytes(range(256))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A safe folder for the cache; pytest's own has parents that only the user may write to."""
    path = tmp_path / "cache"
    monkeypatch.setenv("GYROSTAT_CACHE", str(path))
    return path


@pytest.fixture
def cache(folder):
    return private_cache(pytest.fail)


def test_folders_are_made_private_and_own_ones_are_tightened(folder, monkeypatch):
    old = os.umask(0)
    try:
        monkeypatch.setenv("GYROSTAT_CACHE", str(folder / "deeper"))
        private_cache(pytest.fail)
    finally:
        os.umask(old)
    assert folder.stat().st_mode & 0o777 == (folder / "deeper").stat().st_mode & 0o777 == 0o700
    (folder / "deeper").chmod(0o755)
    private_cache(pytest.fail)
    assert (folder / "deeper").stat().st_mode & 0o777 == 0o700


def test_a_folder_with_other_files_keeps_its_mode(folder):
    folder.mkdir(mode=0o755)
    (folder / "notes.txt").touch()
    private_cache(pytest.fail)
    assert folder.stat().st_mode & 0o777 == 0o755


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o707])
@pytest.mark.parametrize("which", ["itself", "parent"])
def test_a_folder_that_others_may_write_to_is_not_used(folder, mode, which):
    folder.mkdir()
    (folder if which == "itself" else folder.parent).chmod(mode)
    said = []
    found = private_cache(said.append)
    assert len(said) == 1
    assert "others may write to" in said[0]
    assert folder not in (found.path, *found.path.parents)
    assert found.path.stat().st_mode & 0o777 == 0o700
    assert os.environ["GYROSTAT_CACHE"] == str(found.path)  # as workers will find it
    assert private_cache(pytest.fail) == found
    assert not list(folder.iterdir())


def test_a_parent_with_the_sticky_bit_is_as_good_as_tmp(folder):
    folder.parent.chmod(0o1777)
    assert private_cache(pytest.fail).path == folder
    folder.chmod(0o1777)
    assert private_cache(lambda text: None).path != folder


@pytest.mark.skipif(os.geteuid() != 0, reason="only root gives files away")
@pytest.mark.parametrize("which", ["itself", "parent"])
def test_a_folder_of_another_user_is_not_used(folder, which):
    folder.mkdir()
    os.chown(folder if which == "itself" else folder.parent, 12345, 0)
    said = []
    assert private_cache(said.append).path != folder
    assert "belongs to user 12345" in said[0]


def test_a_temporary_cache_goes_with_its_process(tmp_path):
    (tmp_path / "open").mkdir(mode=0o700)
    (tmp_path / "open").chmod(0o777)
    code = (
        "from gyrostat.core.cache import private_cache; import os\n"
        "found = private_cache(print); print(found.path); print(found.path.is_dir())\n"
    )
    environment = {**os.environ, "GYROSTAT_CACHE": str(tmp_path / "open")}
    for end in ("", "os.kill(os.getpid(), 9)\n"):
        # what the killed one leaves, the next removes
        done = subprocess.run(
            [sys.executable, "-uc", code + end], capture_output=True, text=True, env=environment
        )
        line, path, exists = done.stdout.splitlines()
        assert (line.count("expected"), exists) == (1, "True")
        assert os.path.exists(path) == bool(end)
    assert subprocess.run([sys.executable, "-c", code], env=environment).returncode == 0
    assert not os.path.exists(path)


@pytest.mark.parametrize("place", [0, 16, 20, 48, 49, 200, -1])
def test_a_flipped_bit_or_a_truncated_entry_is_found_and_removed(cache, place):
    for damage in ("flip", "truncate"):
        cache.write(NAME, CONTENT)
        assert cache.read(NAME) == CONTENT
        whole = (cache.path / NAME).read_bytes()
        place %= len(whole)
        broken = bytearray(whole if damage == "flip" else whole[:place])
        if damage == "flip":
            broken[place] ^= 1
        (cache.path / NAME).write_bytes(broken)
        assert cache.read(NAME) is None
        assert not (cache.path / NAME).exists()


def test_an_entry_of_another_name_owner_or_kind_is_not_read(cache):
    cache.write(NAME, CONTENT)
    file = cache.path / NAME
    file.rename(cache.path / "lanes-1")
    assert cache.read("lanes-1") is None
    for spoil in (
        lambda: file.chmod(0o666),
        lambda: (file.rename(cache.path / "other"), file.symlink_to(cache.path / "other")),
        lambda: (file.unlink(), os.mkfifo(file)),
        lambda: os.chown(file, 12345, 0) if os.geteuid() == 0 else file.chmod(0o622),
    ):
        cache.write(NAME, CONTENT)
        assert cache.read(NAME) == CONTENT
        spoil()
        assert cache.read(NAME) is None


def test_no_room_is_no_error(cache, monkeypatch):
    def full(handle):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    cache.write(NAME, CONTENT)
    assert cache.read(NAME) is None
    assert {path.name for path in cache.path.iterdir()} == {"lock"}


def test_jax_reads_its_programs_through_the_cache(cache):
    store, _ = compilation_cache.get_file_cache(jax.config.jax_compilation_cache_dir)
    assert isinstance(store, _Store)
    store = _Store(cache)
    store.put("jit_f-0123", CONTENT)
    assert store.get("jit_f-0123") == CONTENT
    (entry,) = cache.path.glob("jax-*")
    entry.write_bytes(entry.read_bytes()[:-1])
    assert store.get("jit_f-0123") is None
    store.put("jit_f-0123", CONTENT)
    assert store.get("jit_f-0123") == CONTENT


COMPILING = """
from gyrostat.codegen.simd.compiler import compiled
print("begun", flush=True)
compiled('#include "lanes.h"\\nint found(void) { return 1; }\\n')
"""


def test_killed_during_a_compile_nothing_is_left(folder, tmp_path):
    pids = tmp_path / "pids"
    script = tmp_path / "compiler"
    # as a compiler driver: it starts another program, and leaves temporary files
    script.write_text(
        f'#!/bin/sh\n[ "$1" = --version ] && exit 0\ntouch $TMPDIR/left.s\nsleep 60 &\n'
        f"echo $$ $! > {pids}.new; mv {pids}.new {pids}\nwait\n"
    )
    script.chmod(0o755)
    environment = {**os.environ, "CC": str(script), "GYROSTAT_CACHE": str(folder)}
    process = subprocess.Popen([sys.executable, "-c", COMPILING], env=environment)
    try:
        _until(pids.exists)
        assert list(folder.glob("making-*/left.s"))
        private_cache(pytest.fail)  # another process does not take what is being made
        assert list(folder.glob("making-*/left.s"))
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    for pid in pids.read_text().split():
        _until(lambda pid=pid: not _runs(pid))
    again = "from gyrostat.core.cache import private_cache; private_cache()"
    assert subprocess.run([sys.executable, "-c", again], env=environment).returncode == 0
    assert {path.name for path in folder.iterdir()} == {"lock"}


def _until(true, seconds=20.0):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


def _runs(pid):
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
