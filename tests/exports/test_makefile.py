"""`make test` of a flight folder, with a shell script in place of the test program."""

import os
import shutil
import subprocess

import pytest

from gyrostat.exports.template import filled

EXPECTED = "torque: as in Python\nspeed: as in Python\n"


@pytest.mark.skipif(shutil.which("make") is None, reason="found no make")
@pytest.mark.parametrize(
    ("printed", "end", "passes"),
    [
        (EXPECTED, "exit 0", True),
        (EXPECTED, "exit 1", False),
        (EXPECTED, "kill -9 $$", False),
        (EXPECTED.replace("speed: as", "speed: not as"), "exit 0", False),
        ("", "exit 0", False),
    ],
)
def test_output_and_exit_status_decide(printed, end, passes, tmp_path):
    makefile = filled("Makefile", name="law", flags="", optimisation="")
    (tmp_path / "Makefile").write_text(makefile, encoding="utf-8")
    (tmp_path / "expected.txt").write_text(EXPECTED, encoding="utf-8")
    for name in ("law.c", "law.h", "law_test.c", "law_vectors.h"):
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (0, 0))
    program = tmp_path / "law_test"
    program.write_text(f"#!/bin/sh\nprintf '%s' '{printed}'\n{end}\n", encoding="utf-8")
    program.chmod(0o755)
    before = sorted(tmp_path.iterdir())
    done = subprocess.run(["make", "test"], cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode == 0) == passes, done.stdout + done.stderr
    assert sorted(tmp_path.iterdir()) == before
