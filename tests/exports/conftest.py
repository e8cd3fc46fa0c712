"""Flight module of an attitude law, and its evidence."""

import subprocess

import pytest

from gyrostat.control import CurrentMode
from gyrostat.core.files import write_texts
from gyrostat.exports import files, read_results, targets


@pytest.fixture(scope="session")
def law(g2):
    """Files of the flight module of an attitude law."""
    return files(targets.controller(CurrentMode(g2.law, 0.0228), 0.1), "double", "Made by a test.")


@pytest.fixture(scope="session")
def check():
    """Write a flight folder and run a kind of its evidence; its result."""

    def result(kind, folder, texts):
        write_texts(folder, texts)
        script = folder / "evidence" / "run.sh"
        subprocess.run(["sh", script, kind], check=False, capture_output=True)
        return next(each for each in read_results(folder) if each.name == kind)

    return result
