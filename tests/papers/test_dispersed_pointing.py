"""The dispersed cases of two-wheel pointing: what is drawn, what is kept, what is claimed."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.core.jax64 import jnp
from gyrostat.core.validation import check_parts
from gyrostat.papers.endo_sekiguchi_nonaka import ENDO_SEKIGUCHI_NONAKA
from gyrostat.papers.endo_sekiguchi_nonaka.controllers import (
    OURS,
    SAFE_FRIT,
    SLOW,
    UNCOMPENSATED,
    Estimated,
    Outcome,
    evaluate,
)
from gyrostat.papers.endo_sekiguchi_nonaka.dispersed import claimed
from gyrostat.papers.endo_sekiguchi_nonaka.dispersion import draw, paper_case
from gyrostat.spacecraft import SpacecraftMeasurement

NOMINAL = np.array([4000.675, 5000.675, 6000.45])


def own_angle(case):
    """Pointing error and its axis, from the attitude by another library."""
    seen = Rotation.from_quat(case.start.attitude, scalar_first=True).inv().apply([0, 0, 1])
    axis = np.cross([0, 0, 1], seen)
    return np.arctan2(np.linalg.norm(axis), seen[2]), axis / np.linalg.norm(axis)


def test_cases_are_what_the_settings_say():
    cases = draw(30, 5)
    for case in cases:
        craft = case.plant.spacecraft
        check_parts(case.plant, case.sensor)
        total = np.asarray(craft.inertia_locked())
        assert np.all(np.abs(np.diag(total) / NOMINAL - 1.0) <= 0.05)
        assert np.abs(total[0, 1]) <= 0.02 * np.sqrt(total[0, 0] * total[1, 1]) * (1 + 1e-9)
        assert np.allclose(np.diag(craft.wheels.axes[:2]), np.cos(np.deg2rad(0.5)), atol=1e-12)
        momentum = case.plant.momentum
        assert np.linalg.norm(momentum.amplitude) <= 0.2
        angle, axis = own_angle(case)
        assert np.deg2rad(1.0) <= angle <= np.deg2rad(150.0)
        assert case.angle == pytest.approx(angle, abs=1e-9)
        inertia = max(total[0, 0] * abs(axis[0]), total[1, 1] * abs(axis[1]))
        assert case.quickest == pytest.approx(2.0 * np.sqrt(angle * inertia / 0.1), rel=1e-9)
        # the body rate is what makes up the momentum
        rate = np.asarray(case.plant.rate(case.start))
        wheels = np.asarray(craft.wheels.axes) @ (0.45 * np.asarray(case.start.wheel_speed))
        held = Rotation.from_quat(case.start.attitude, scalar_first=True).apply(
            total @ rate + wheels
        )
        assert np.allclose(held, momentum(0.0), atol=1e-12)
    drawn = np.array([case.start.wheel_speed for case in cases])
    assert set(np.unique(drawn)) == {-5.0, 0.0, 5.0}
    assert {case.plant.momentum.frequency for case in cases} == {1e-4, 1e-3}
    few = draw(3, 5)
    assert all(a.quickest == b.quickest for a, b in zip(few, cases, strict=False))
    assert draw(1, 6)[0].quickest != cases[0].quickest


def test_a_small_set_and_the_papers_case_reach_the_goals():
    candidate = dataclasses.replace(OURS, duration=900.0, judged=100.0)
    cases = [*draw(3, 17), paper_case()]
    told = []
    found = evaluate(candidate, cases, block_size=4, say=told.append)
    assert told == [f"{OURS.name}, runs of 900 s: 4 of 4"]
    limit = np.array([1.1 * case.quickest + 40.0 for case in cases])
    assert np.all(found.holds)
    assert np.all(found.settled <= limit)
    assert np.all(found.last <= 0.005)
    assert np.all((found.demand > 0.09) & (found.demand <= 0.105))
    assert np.all((found.roll > 0.0) & (found.roll < 1e-3))
    assert found.settled[3] <= 270.0


class Echo:
    def start(self, period):
        return period

    def __call__(self, memory, measurement):
        return memory, measurement


def test_controllers_are_given_the_filters_attitude():

    wrapped = Estimated(Echo())
    memory = wrapped.start(0.1)
    true = jnp.array([1.0, 0.0, 0.0, 0.0])
    off = jnp.array([np.cos(5e-5), np.sin(5e-5), 0.0, 0.0])
    for seen in (true, off):
        sample = SpacecraftMeasurement(seen, jnp.zeros(3), jnp.array([2.0, 3.0]), True)
        memory, got = wrapped(memory, sample)
    # one sample of the tracker pulls by twice the bandwidth times the period
    assert got.attitude[1] == pytest.approx(2.0 * 0.05 * 0.1 * 5e-5, rel=1e-3)
    assert got.rate[0] == pytest.approx(0.05**2 * 0.1 * 1e-4, rel=1e-3)
    assert np.array_equal(got.wheel_speed, [2.0, 3.0])


def made_up(last, settled):
    last = np.asarray(last, dtype=float)
    return Outcome(np.array(settled), last, np.full_like(last, 0.1), np.full_like(last, 1e-4))


@pytest.fixture(scope="module")
def runs():
    """Four cases and the paper's own, and made-up runs of every controller."""
    cases = [*draw(4, 5), paper_case()]
    quickest = np.array([case.quickest for case in cases])
    settled = quickest * [1.0, 1.1, 1.2, 9.0, 1.0]
    found = {OURS.key: made_up([0.001, 0.002, 0.003, 0.06, 0.001], [*settled[:4], 226.0])}
    for one in (SAFE_FRIT, UNCOMPENSATED):
        found[one.key] = made_up([*[0.01, 0.2] * 2, 0.001], [*[50.0, 6000.0] * 2, 226.0])
    for one in SLOW:
        found[one.key] = made_up([*[np.inf, 60.0] * 2, 0.001], [15_000.0] * 5)
    return cases, found


def test_claims_are_read_off_the_runs(runs):
    cases, found = runs
    part = claimed(cases, found)
    assert set(part.values) == {row.id for row in ENDO_SEKIGUCHI_NONAKA.rows if row.full}
    assert part.values["dispersed.cases"] == 4.0
    assert part.values["dispersed.success_fraction"] == 0.75
    assert part.values["dispersed.worst_settle_ratio"] == pytest.approx(9.0)
    assert part.values["dispersed.worst_last_error_deg"] == 0.06
    assert part.values["dispersed.paper_success_fraction"] == 0.0
    assert part.values["paper_case.settle_s"] == 226.0
    quickest = np.array([case.quickest for case in cases[:4]])
    in_time = found[OURS.key].settled[:4] <= 1.1 * quickest + 40.0
    assert part.facts["in_time"][0] == np.mean(in_time)
    assert part.facts["share"]["safe_frit"] == 0.5
    assert part.facts["mean_last"]["pointing"] == pytest.approx(0.0165)
    for row in ENDO_SEKIGUCHI_NONAKA.rows:
        if row.full:
            assert row.claim(part.values[row.id], part.facts).why.endswith(".")


def test_a_failed_run_can_be_drawn(runs):
    left, right = claimed(*runs).drawings[0].figure.axes
    assert len(left.lines) == 3
    assert np.max(right.lines[1].get_xdata()) == 180.0
