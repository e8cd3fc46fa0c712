"""Output files: the user's are never replaced, gyrostat's own always, whenever it was killed."""

import json
import os
import subprocess
import sys

import pytest

from gyrostat.core.errors import InputError
from gyrostat.core.outputs import MANIFEST, Manifest, check_outputs, new_files


def write(folder, by="identify", force=False, **texts):
    """Write NAME.txt with each text."""
    with new_files(folder, by=by, force=force) as scratch:
        for name, text in texts.items():
            (scratch / f"{name}.txt").write_text(text)


def refused(folder, found, **options):
    """Writing a.txt and b.txt, which must change nothing."""
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    with pytest.raises(InputError) as caught:
        write(folder, a="new", b="new", **options)
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    assert found in str(caught.value)
    assert "--force" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_same_command_writes_again(tmp_path):
    for text in ("first", "second", "third"):
        write(tmp_path / "out", a=text, b=text)
        assert (tmp_path / "out" / "a.txt").read_text() == text
    assert sorted(os.listdir(tmp_path / "out")) == [MANIFEST, "a.txt", "b.txt"]
    listed = json.loads((tmp_path / "out" / MANIFEST).read_text())["files"]
    assert [len(row["sha256"]) for row in listed.values()] == [1, 1]


def test_files_of_the_user_are_refused_and_others_do_not_matter(tmp_path):
    (tmp_path / "b.txt").write_text("mine")
    (tmp_path / "c.txt").write_text("mine")
    refused(tmp_path, f"{tmp_path / 'b.txt'}: found a file that gyrostat identify did not write")
    with pytest.raises(InputError, match=r"b\.txt"):
        check_outputs(tmp_path, ["a.txt", "b.txt"], by="identify")
    check_outputs(tmp_path, ["a.txt", "b.txt"], by="identify", force=True)
    write(tmp_path, force=True, a="new", b="new")
    assert (tmp_path / "b.txt").read_text() == "new"
    write(tmp_path, a="newer", b="newer")
    assert (tmp_path / "c.txt").read_text() == "mine"


def test_what_the_user_changed_since_is_refused(tmp_path):
    write(tmp_path, a="1", b="2")
    (tmp_path / "b.txt").write_text("my own correction")
    refused(tmp_path, "found a file that was changed since gyrostat identify wrote it")
    (tmp_path / "b.txt").unlink()
    write(tmp_path, a="new", b="new")


def test_a_file_of_another_command_is_refused(tmp_path):
    write(tmp_path, by="holdable", a="1")
    refused(tmp_path, "found a file of gyrostat holdable")


def test_a_file_that_has_the_content_already_is_adopted(tmp_path):
    (tmp_path / "a.txt").write_text("same")
    write(tmp_path, a="same")
    write(tmp_path, a="other")


@pytest.mark.parametrize("target", ["kept.txt", "absent.txt"])
def test_a_link_is_never_written_through(tmp_path, target):
    (tmp_path / "kept.txt").write_text("mine")
    out = tmp_path / "out"
    out.mkdir()
    (out / "a.txt").symlink_to(tmp_path / target)
    refused(out, "found a symbolic link")
    write(out, force=True, a="new")
    assert (tmp_path / "kept.txt").read_text() == "mine"
    assert not (out / "a.txt").is_symlink()
    assert not (tmp_path / "absent.txt").exists()


def test_a_linked_folder_is_looked_into(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "a.txt").write_text("mine")
    (tmp_path / "link").symlink_to(tmp_path / "real")
    refused(tmp_path / "link", "did not write")
    (tmp_path / "real" / "a.txt").unlink()
    write(tmp_path / "link", a="1")
    write(tmp_path / "real", a="2")


def test_a_folder_in_the_place_of_a_file(tmp_path):
    (tmp_path / "a.txt").mkdir()
    refused(tmp_path, "found a folder or device")


@pytest.mark.parametrize(
    "damage",
    [
        *("", "{", "[]", "0", "[" * 5000),
        *('{"gyrostat": 2, "files": {}}', '{"gyrostat": 1, "files": 3}'),
        *('{"gyrostat": 1, "files": {"a": 3}}', '{"gyrostat": 1, "files": {"a": {"by": 1}}}'),
    ],
)
def test_a_damaged_manifest_is_refused_and_written_anew_by_force(tmp_path, damage):
    write(tmp_path, a="1")
    (tmp_path / MANIFEST).write_text(damage)
    refused(tmp_path, MANIFEST)
    with pytest.raises(InputError, match=r"\.gyrostat\.json"):
        check_outputs(tmp_path, ["z.txt"], by="identify")
    write(tmp_path, force=True, a="2")
    write(tmp_path, a="3")


@pytest.mark.parametrize("kind", ["link", "folder"])
def test_something_else_called_as_the_manifest(tmp_path, kind):
    (tmp_path / "precious").write_text("mine")
    if kind == "link":
        (tmp_path / MANIFEST).symlink_to(tmp_path / "precious")
    else:
        (tmp_path / MANIFEST).mkdir()
    refused(tmp_path, MANIFEST)
    assert (tmp_path / "precious").read_text() == "mine"


def test_a_flipped_bit_in_the_manifest_never_gives_a_file_away(tmp_path):
    write(tmp_path, a="1", b="2")
    (tmp_path / "b.txt").write_text("mine")
    content = (tmp_path / MANIFEST).read_bytes()
    for place in range(0, 8 * len(content), 5):
        flipped = bytearray(content)
        flipped[place // 8] ^= 1 << place % 8
        (tmp_path / MANIFEST).write_bytes(flipped)
        assert not Manifest(tmp_path).is_own("b.txt", "identify")


def test_what_was_not_written_leaves_nothing(tmp_path):
    def half():
        with new_files(tmp_path / "out", by="x") as scratch:
            (scratch / "a.txt").write_text("half")
            raise ValueError("half")

    with pytest.raises(ValueError, match="half"):
        half()
    assert os.listdir(tmp_path) == []


KILLED = """
import os, sys
from pathlib import Path
from gyrostat.core.outputs import new_files
replace, left = os.replace, [int(sys.argv[2])]
def counted(*paths):
    if left[0] == 0:
        os.kill(os.getpid(), 9)
    left[0] -= 1
    replace(*paths)
os.replace = counted
with new_files(Path(sys.argv[1]), by="identify") as scratch:
    (scratch / "a.txt").write_text("new")
    (scratch / "b.txt").write_text("new")
"""


@pytest.mark.parametrize("moment", range(4))  # manifest, a.txt, b.txt, manifest
def test_killed_at_any_moment_it_can_go_on(tmp_path, moment):
    write(tmp_path, a="old", b="old")
    done = subprocess.run([sys.executable, "-c", KILLED, str(tmp_path), str(moment)], timeout=60)
    assert done.returncode == -9
    texts = {(tmp_path / name).read_text() for name in ("a.txt", "b.txt")}
    assert texts <= {"old", "new"}
    write(tmp_path, a="newer", b="newer")
    assert sorted(os.listdir(tmp_path)) == [MANIFEST, "a.txt", "b.txt"]


TOGETHER = """
import sys
from pathlib import Path
from gyrostat.core.outputs import new_files
for number in range(20):
    with new_files(Path(sys.argv[1]), by="bench") as scratch:
        (scratch / f"{sys.argv[2]}{number}.csv").write_text("x")
"""


def test_commands_that_write_at_once_lose_no_entry(tmp_path):
    running = [
        subprocess.Popen([sys.executable, "-c", TOGETHER, str(tmp_path), name]) for name in "abc"
    ]
    assert [process.wait(60) for process in running] == [0, 0, 0]
    assert len(Manifest(tmp_path).entries) == 60
    assert len(os.listdir(tmp_path)) == 61
