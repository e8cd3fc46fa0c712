"""Moreira, Lopes and Kuga: a quick run against closed forms and an implicit solver."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gyrostat.papers.moreira_lopes_kuga.compute import sine_momentum
from gyrostat.papers.moreira_lopes_kuga.setup import FRICTION, RADIUS

PAPER = "moreira-lopes-kuga"


def test_the_sine_is_that_of_an_implicit_solver():
    def rate(t, y):
        h, z = y
        v = 0.006 / 0.0191 * h
        level = 2.0 + 0.5 * np.exp(-((v / 0.01) ** 2))
        z_rate = v - 1e5 * abs(v) / level * z
        friction = 0.006 * (1e5 * z + 495.0 * z_rate + 4.6 * v)
        return [0.03 * np.sin(2.0 * np.pi * t / 60.0) - friction, z_rate]

    exact = solve_ivp(rate, (0.0, 120.0), [0.0, 0.0], "Radau", rtol=1e-10, atol=1e-14)
    assert float(sine_momentum()) == pytest.approx(exact.y[0, -1], rel=1e-6)


def test_the_bristles_of_the_paper_are_not_passive():
    limit = float(FRICTION.largest_passive_damping()) / RADIUS**2
    assert limit == pytest.approx(4.6 * 2.0 / 0.5, rel=1e-9)
    assert limit < 495.0 / 26.0


@pytest.mark.slow
def test_a_quick_run_judges_every_claim_as_published(judged_as_published):
    judged_as_published(PAPER)


@pytest.mark.slow
def test_a_quick_run_agrees_with_closed_forms(quick):
    ours = quick(PAPER).ours
    assert ours["kf.friction_torque_steady_Nm"] == pytest.approx(
        0.006 * (2.0 + 4.6 * 0.006 / 0.0191), rel=1e-9
    )
    for loop in ("kf", "no_estimator"):
        assert ours[f"{loop}.bristle_deflection_m"] == pytest.approx(2e-5, rel=1e-6)
    assert ours["reference.speed_rpm"] == pytest.approx(60.0 / (2.0 * np.pi * 0.0191), rel=1e-9)
    for second in (50, 100, 150, 200):
        expected = 1.0 - np.exp(-0.02 * second)
        assert ours[f"kf.momentum_{second}s_Nms"] == pytest.approx(expected, abs=0.015)
    # the friction at the end of the loop without estimator equals gamma times what is missing
    end = ours["no_estimator.momentum_300s_Nms"]
    assert 0.006 * (2.0 + 4.6 * 0.006 / 0.0191 * end) == pytest.approx(0.02 * (1.0 - end), rel=0.02)
    assert quick(PAPER).page.count('<div class="charts') == 6
