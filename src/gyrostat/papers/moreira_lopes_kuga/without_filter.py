"""The loop without estimator, and what the paper sees when it compares the two."""

from typing import TYPE_CHECKING

import numpy as np

from gyrostat.papers.claims import Claim
from gyrostat.papers.moreira_lopes_kuga.flight import SETTLED, at
from gyrostat.papers.moreira_lopes_kuga.printed import GAIN, RADIUS, REFERENCE, steady_friction

if TYPE_CHECKING:
    import xarray as xr


def plain_claims(plain: "xr.Dataset", printed: "xr.Dataset") -> list[Claim]:
    """Judge the loop without estimator, its sign corrected and as printed."""
    end = float(at(plain.momentum, 300).mean())
    away = float(at(printed.momentum, 300).mean())
    short = GAIN * REFERENCE
    return [
        Claim(
            id="no_estimator.momentum_300s_Nms",
            quantity="momentum at 300 s without estimator, sign of (18) corrected, mean",
            paper=1.0,
            ours=end,
            unit="N·m·s",
            tolerance=0.05,
            why=f"gamma h_ref = {short:g} N·m is less than the friction at h_ref, "
            f"{steady_friction():.5f} N·m: no proportional law reaches it.",
        ),
        Claim(
            id="no_estimator.overshoot",
            quantity="the loop without estimator overshoots the reference",
            paper=True,
            ours=bool(plain.momentum.max() > REFERENCE),
            unit="",
            tolerance=0.0,
            why="It creeps up to where the torque equals the friction and stays there.",
        ),
        Claim(
            id="no_estimator.momentum_280s_Nms",
            quantity="momentum at 280 s without estimator, where the paper's figure falls to, mean",
            paper=0.9,
            ours=float(at(plain.momentum, 280).mean()),
            unit="N·m·s",
            tolerance=0.05,
            why="It has risen to its end by then, far below.",
        ),
        Claim(
            id="no_estimator.friction_torque_300s_Nm",
            quantity="friction torque at 300 s without estimator, mean",
            paper=0.02,
            ours=float(at(plain.friction, 300).mean()),
            unit="N·m",
            tolerance=0.001,
            why="The wheel is slower than the paper's, and viscous friction with it.",
        ),
        Claim(
            id="no_estimator.bristle_deflection_m",
            quantity="mean bristle deflection at 300 s without estimator, mean",
            paper=2e-5,
            ours=RADIUS * float(at(plain.bristle, 300).mean()),
            unit="m",
            tolerance=1e-7,
            why="F_c / sigma_0 at this speed too.",
        ),
        Claim(
            "no_estimator.printed_sign_300s_Nms",
            "momentum at 300 s without estimator, (18) as printed, mean",
            away,
            "N·m·s",
            "The printed sign is positive feedback: the wheel runs away backwards.",
        ),
    ]


def compared_claims(kalman: "xr.Dataset", plain: "xr.Dataset") -> list[Claim]:
    """What the paper sees in figures 3, 5 and 6."""

    def effective(flown):
        return (flown.torque + flown.fading_torque - flown.friction).values

    def largest(flown):
        return float(np.max(effective(flown), axis=1).mean())

    def spread(flown):
        settled = flown.friction.isel(time=slice(SETTLED, None))
        return float(settled.std("time").mean())

    return [
        Claim(
            id="kf.larger_effective_torque",
            quantity="the largest commanded minus friction torque is larger with the estimator",
            paper=True,
            ours=largest(kalman) > largest(plain),
            unit="",
            tolerance=0.0,
            why=f"{largest(kalman):.4f} N·m with it, {largest(plain):.4f} N·m without, means of "
            "the runs.",
        ),
        Claim(
            id="kf.friction_more_spread",
            quantity="the friction torque scatters more with the estimator",
            paper=True,
            ours=spread(kalman) > spread(plain),
            unit="",
            tolerance=0.0,
            why=f"{spread(kalman):.1e} N·m against {spread(plain):.1e} N·m from {SETTLED} s on.",
        ),
    ]
