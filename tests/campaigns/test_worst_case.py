"""Worst case within bounds, and the pages of searches; flights are known functions."""

import json

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.campaigns.search.moves import Answers
from gyrostat.campaigns.search.worst import Bounds, noise_share, worst_case
from gyrostat.campaigns.search.worst_case import WorstCase
from gyrostat.core.errors import InputError

pytest.importorskip("cma", reason="the library of the extra search is not installed")


def searched(response, bounds, runs=3000, seed=1):
    """Worst case of a function of standard normal numbers and of one of noise."""
    random, noise = np.random.default_rng(seed), np.zeros(0)
    search, first = worst_case(bounds, runs, seed), 0
    moves = next(search)
    while True:
        normal = moves.normal
        if normal is None:
            normal = random.standard_normal((moves.size, len(bounds.is_uniform)))
        fresh = (moves.parents < 0) | (moves.share == 1.0)
        drawn = random.standard_normal(moves.size)
        noise = np.append(noise, np.where(fresh, drawn, np.append(noise, 0.0)[moves.parents]))
        numbers, first = first + np.arange(moves.size), first + moves.size
        try:
            moves = search.send(Answers(numbers, normal, response(normal, noise[numbers])))
        except StopIteration as end:
            assert first <= runs
            return end.value


def normal_bounds(keys, sigma=3.0):
    return Bounds(np.zeros(keys, bool), sigma, False)


def test_the_worst_corner_is_found():
    weight = np.array([1.0, -2.0, 3.0, 0.5])
    found = searched(lambda z, w: z @ weight, normal_bounds(4))
    assert found.response > 0.99 * 3.0 * np.sum(np.abs(weight))
    assert found.response > 1.2 * found.random
    np.testing.assert_allclose(found.coordinates, np.sign(weight), atol=0.1)
    loss = found.response - found.without
    np.testing.assert_allclose(loss, 3.0 * found.coordinates * weight, atol=1e-9)
    assert found.noise_share < 1e-6


def test_one_dispersion_is_enough():
    assert searched(lambda z, w: -z[:, 0], normal_bounds(1)).coordinates[0] < -0.99


def test_a_worst_case_inside_the_bounds_is_found():
    found = searched(lambda z, w: -np.sum((z - 1.5) ** 2, axis=1), normal_bounds(3))
    np.testing.assert_allclose(found.coordinates, 0.5, atol=0.02)


def test_noise_that_drives_the_metric_is_seen():
    found = searched(lambda z, w: w + 0.1 * z[:, 0], normal_bounds(2))
    assert found.noise_share > 0.85  # 300 pairs
    random = np.random.default_rng(0)
    values, one, two = random.standard_normal((3, 100_000))
    share = noise_share(2.0 * values + one, 2.0 * values + two)
    assert share == pytest.approx(0.2, abs=0.01)
    assert np.isnan(noise_share(np.ones(5), np.ones(5)))


def test_runs_that_end_early_are_the_worst():
    found = searched(lambda z, w: np.where(z[:, 0] > 2.5, np.inf, z[:, 0]), normal_bounds(2))
    assert found.response == np.inf
    assert found.coordinates[0] > 2.5 / 3.0


def test_bounds_of_a_box_are_the_ends_of_uniform_distributions():
    box = Bounds(np.array([True, False]), 3.0, True)
    np.testing.assert_allclose(box.normal(np.array([[1.0, 1.0]])), [[np.inf, 3.0]])
    sigma = box._replace(ends=False)
    np.testing.assert_allclose(sigma.normal(np.array([[1.0, -1.0]])), [[3.0, -3.0]])
    place = np.array([[0.3, -0.4]])
    for bounds in (box, sigma):
        np.testing.assert_allclose(bounds.coordinates(bounds.normal(place)), place, rtol=1e-12)


def test_bad_bounds_and_metrics_are_refused(scenario):
    for within in ("3", "9sigma", "sigma", "0sigma"):
        with pytest.raises(InputError, match="expected box or a number up to 8"):
            WorstCase.of(scenario, "error_max", within)
    with pytest.raises(InputError, match="expected one of"):
        WorstCase.of(scenario, "error", "box")
    with pytest.raises(InputError, match="expected at least"):
        WorstCase.of(scenario, "error_max", "box").searches(100, 0)


def test_a_worst_case_in_a_folder(scenario, fake_flights, tmp_path):
    said = []
    found = gs.campaign(
        scenario, 1000, tmp_path / "worst", worst_case="error_max", worst=0, say=said.append
    )
    assert found.worst == found.error_max[found.attrs["run"]] == found.error_max.max()
    assert found.noise_share == pytest.approx(0.5, abs=0.15)
    content = json.loads((tmp_path / "worst" / "report.json").read_text())
    assert content["values"][0]["key"] == "wheel.a.speed"
    assert content["values"][0]["place"] > 0.9
    page = (tmp_path / "worst" / "report.html").read_text()
    assert f"gyrostat replay {tmp_path / 'worst'} {found.attrs['run']}" in page
    assert any("wheel.a.speed at " in line for line in said)
    assert gs.report(tmp_path / "worst") == content
    noisy = gs.campaign(scenario, 1000, tmp_path / "n", worst_case="settling", worst=0)
    assert noisy.noise_share > 0.7  # 100 pairs
    assert "Noise drives settling" in (tmp_path / "n" / "report.html").read_text()


def test_a_rare_failure_in_a_folder(scenario, fake_flights, tmp_path):
    said = []
    found = gs.campaign(
        scenario, 4100, tmp_path, rare="error_max > 1", worst=0, seed=3, say=said.append
    )
    assert "20000 of 1e-6" in said[0]
    assert found.low < 1e-4 < found.high
    content = json.loads((tmp_path / "report.json").read_text())
    assert content["doubts"] == [*found.doubts]
    assert content["shared"][0]["key"] == "wheel.a.speed"
    # half of the failing sum of 3.95 standard deviations is due to the speed; the failures of a
    # replication of 20 chains descend from one or two runs
    assert content["shared"][0]["shift"] == pytest.approx(3.95 / np.sqrt(2.0), abs=0.6)
    failing = [each["run"] for each in content["failures"]]
    assert np.all(found.error_max[failing] > 1.0)
    with pytest.raises(InputError, match="expected the native engine"):
        gs.campaign(scenario, 4100, tmp_path, rare="error_max > 1", engine="jax")
    with pytest.raises(InputError, match="--keep"):
        gs.campaign(scenario, 4100, tmp_path, rare="error_max > 1", keep=[1])
