"""The picture of the motion in the page of a run, drawn by a real browser without a network."""

import shutil
import subprocess

import numpy as np
import pytest
from matplotlib.image import imread

from gyrostat.reports.campaign_run import run_page
from gyrostat.reports.replay import replay_data

RED = np.array([200, 70, 30]) / 255.0  # the boresight


@pytest.fixture(scope="module")
def flown(small):
    """Nominal run: its row, its history."""
    found = small.fly(None, keep=(0,))
    values = {name: column[0] for name, column in found.columns.items()}
    return values, found.histories.of_run(0).arrays()


def test_the_target_changes_with_the_events(scenario, flown):
    motion = replay_data(scenario, *flown, None)
    turned = np.array(motion["time"]) >= 18.0 - 1e-9
    assert np.all(np.array(motion["target"])[~turned] == [1.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(np.array(motion["target"])[turned, 3], 0.002, rtol=1e-5)
    # sides from 0.06, 0.12, 0.14 kg·m²: squares as 0.2, 0.08, 0.04
    np.testing.assert_allclose(motion["sides"], np.sqrt([1.0, 0.4, 0.2]), rtol=1e-12)


def test_a_run_that_ended_at_once_has_no_motion(scenario, flown):
    values, history = flown
    first = np.arange(len(history["time"])) == 0
    history = {**history, "error": np.where(first, history["error"], np.nan)}
    assert replay_data(scenario, values, history, None) is None
    assert "<canvas" not in run_page(scenario, values, history, "short", "x")


def test_a_browser_draws_the_motion(scenario, flown, tmp_path):
    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
    if browser is None:
        pytest.skip("chromium is not installed")
    values, history = flown
    page = tmp_path / "run.html"
    page.write_text(run_page(scenario, values, history, "small", "x"))
    command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--window-size=1050,2200"]
    address = f"{page.as_uri()}#frame=100"
    picture = tmp_path / "motion.png"
    drawn = subprocess.run(
        [*command, f"--user-data-dir={tmp_path / 'b'}", "--dump-dom", address],
        capture_output=True,
        text=True,
        timeout=60,
    )
    error = np.degrees(history["error"][100])
    assert '<div class="now">25.0 s, error ' in drawn.stdout
    told = drawn.stdout.split('<div class="now">25.0 s, error ')[1].split(" deg")[0]
    assert float(told) == pytest.approx(error, rel=5e-3)
    subprocess.run(
        [*command, f"--user-data-dir={tmp_path / 'b'}", f"--screenshot={picture}", address],
        capture_output=True,
        timeout=60,
        check=True,
    )
    image = imread(picture)[:, :, :3]
    red = np.argwhere(np.linalg.norm(image - RED, axis=2) < 0.06)
    canvas = red[red[:, 0] > 900]  # below the curves, whose events are red too
    # x of the body, 1.7 long, seen from 0.7 and 0.45 rad: across, down (pixels of 130 a unit)
    across = -np.sin(0.7) * 1.7 * 130.0
    down = np.sin(0.45) * np.cos(0.7) * 1.7 * 130.0
    extent = np.ptp(canvas, axis=0)
    np.testing.assert_allclose(extent, [down, -across], atol=6.0)
