"""The paper's filter and controller, flown and judged."""

from typing import TYPE_CHECKING

import numpy as np

from gyrostat.control import FrictionTorqueControl, ProportionalMomentumControl
from gyrostat.papers.claims import Claim
from gyrostat.papers.moreira_lopes_kuga.bristles import model_claims
from gyrostat.papers.moreira_lopes_kuga.drawings import (
    control_drawing,
    momentum_drawing,
    residual_drawing,
    torque_drawing,
    without_control_drawing,
    without_drawing,
)
from gyrostat.papers.moreira_lopes_kuga.flight import SETTLED, at, fly
from gyrostat.papers.moreira_lopes_kuga.printed import (
    FILTER,
    GAIN,
    PERIOD,
    RADIUS,
    REFERENCE,
    steady_friction,
    to_reference,
)
from gyrostat.papers.moreira_lopes_kuga.without_filter import compared_claims, plain_claims
from gyrostat.papers.reproduction import Part

if TYPE_CHECKING:
    import xarray as xr


def with_filter(seeds: int) -> "xr.Dataset":
    """The paper's filter and controller, from rest to the reference."""
    return fly(FrictionTorqueControl(FILTER, GAIN, to_reference), seeds)


def estimated(kalman: "xr.Dataset", seeds: int) -> Part:
    """Judge the paper's statements on its filter and on the loop without it.

    Args:
        kalman: runs of `with_filter`.
        seeds: as many runs without it.
    """
    plain = fly(ProportionalMomentumControl(GAIN, to_reference), seeds)
    printed = fly(ProportionalMomentumControl(-GAIN, to_reference), seeds)
    return Part(
        claims=(
            *_filter_claims(kalman, seeds),
            *plain_claims(plain, printed),
            *compared_claims(kalman, plain),
            *model_claims(),
        ),
        drawings=(
            momentum_drawing(kalman),
            torque_drawing(kalman),
            control_drawing(kalman),
            residual_drawing(kalman),
            without_drawing(kalman, plain),
            without_control_drawing(plain),
        ),
    )


def _filter_claims(kalman: "xr.Dataset", seeds: int) -> list[Claim]:
    gain = np.asarray(FILTER.steady_gain(PERIOD))
    settled = kalman.isel(time=slice(SETTLED, None))
    residual = (kalman.measured_momentum - kalman.estimated_momentum).values
    scatter = float((settled.estimated_friction - settled.friction).std())
    momentum = kalman.momentum
    over = f"mean of {seeds} runs"
    claims = [
        Claim(
            id="kf.friction_torque_300s_Nm",
            quantity=f"friction torque at 300 s, {over}",
            paper=0.02,
            ours=float(at(kalman.friction, 300).mean()),
            unit="N·m",
            tolerance=0.001,
            why="The paper rounds.",
        ),
        Claim(
            id="kf.friction_torque_steady_Nm",
            quantity="friction torque at h_ref exactly",
            paper=0.02,
            ours=steady_friction(),
            unit="N·m",
            tolerance=0.001,
            why="From (2), (4): (F_c + sigma_2 r h / J) r.",
        ),
        Claim(
            id="kf.bristle_deflection_m",
            quantity=f"mean bristle deflection at 300 s, {over}",
            paper=2e-5,
            ours=RADIUS * float(at(kalman.bristle, 300).mean()),
            unit="m",
            tolerance=1e-7,
            why="F_c / sigma_0, since 500 rpm is far above the Stribeck speed.",
        ),
        Claim(
            id="kf.momentum_300s_mean_Nms",
            quantity=f"momentum at 300 s, {over}",
            paper=REFERENCE,
            ours=float(at(momentum, 300).mean()),
            unit="N·m·s",
            tolerance=0.01,
            why="The approach is exponential with 1 / gamma = 50 s: e^-6 of it is left.",
        ),
        Claim(
            id="kf.overshoot",
            quantity=f"the momentum passes the reference, {over}",
            paper=False,
            ours=bool(momentum.mean("run").max() > REFERENCE),
            unit="",
            tolerance=0.0,
            why="Of the mean. The noise of the estimate takes single runs beyond it, up to "
            f"{float(momentum.max()):.3f} N·m·s.",
        ),
        Claim(
            "kf.momentum_300s_std_Nms",
            "scatter of the momentum at 300 s",
            float(at(momentum, 300).std(ddof=1)),
            "N·m·s",
            "The noise of the friction estimate drives the wheel.",
        ),
    ]
    claims += [
        Claim(
            f"kf.momentum_{k}s_Nms",
            f"momentum at {k} s, {over}",
            float(at(momentum, k).mean()),
            "N·m·s",
            f"1 - exp(-gamma t) is {1.0 - np.exp(-GAIN * k):.3f}.",
        )
        for k in (50, 100, 150, 200)
    ]
    claims += [
        Claim(
            f"kf.gain_{n}", f"steady gain of the {n}", float(g), unit, "From the Riccati equation."
        )
        for n, g, unit in (("momentum", gain[0], "1"), ("friction", gain[1], "1/s"))
    ]
    return [
        *claims,
        Claim(
            id="kf.residual_posterior_max_Nms",
            quantity=f"largest measured minus estimated momentum of a run, {over}",
            paper=1.7e-2,
            ours=float(np.max(np.abs(residual), axis=1).mean()),
            unit="N·m·s",
            tolerance=0.4e-2,
            why=f"With rho_1 = 0.1 the gain is {gain[0]:.3f}, so that {100 * (1 - gain[0]):.1f} % "
            "of an innovation is left: the paper's residual does not follow from its numbers.",
        ),
        Claim(
            "kf.innovation_max_Nms",
            f"largest innovation of a run, {over}",
            float(np.max(np.abs(kalman.innovation.values), axis=1).mean()),
            "N·m·s",
            "Measured minus predicted; far larger than the noise, since the torque walks.",
        ),
        Claim(
            "kf.friction_estimate_std_Nm",
            "scatter of the estimated friction torque at steady state",
            scatter,
            "N·m",
            f"As large as the torque itself, {steady_friction():.4f} N·m.",
        ),
    ]
