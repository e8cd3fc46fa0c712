"""The paper's filter and controller, and the loop without estimator."""

from typing import TYPE_CHECKING, Any

import numpy as np

from gyrostat._jax import jax, jnp
from gyrostat.control import FrictionTorqueControl, ProportionalMomentumControl
from gyrostat.friction import Scalar
from gyrostat.papers.claims import Claim
from gyrostat.papers.moreira_lopes_kuga.drawings import (
    control_drawing,
    momentum_drawing,
    residual_drawing,
    torque_drawing,
    without_drawing,
)
from gyrostat.papers.moreira_lopes_kuga.printed import (
    BENCH,
    DURATION,
    FILTER,
    FRICTION,
    GAIN,
    PERIOD,
    REFERENCE,
    SENSOR,
    WHEEL,
    steady_deflection,
    steady_friction,
    to_reference,
)
from gyrostat.papers.reproduction import Part
from gyrostat.simulate import simulate
from gyrostat.wheel import Contact, Motion, bend

if TYPE_CHECKING:
    import xarray as xr

SINE_TORQUE, SINE_PERIOD, SINE_END = 0.03, 60.0, 120
"""N·m, s, s."""
SETTLED = 200
"""s: from here on the wheel counts as settled."""


def fly(controller: Any, seeds: int, *, plant: Any = BENCH, seed: int = 0) -> "xr.Dataset":
    """Run the wheel from rest; see `gyrostat.simulate.simulate`."""
    return simulate(
        plant,
        controller,
        SENSOR,
        start=BENCH.start(),
        duration=DURATION,
        control_period=PERIOD,
        runs=seeds,
        seed=seed,
    )


class _SineTorque(Contact):
    friction: Any
    started: Scalar

    def inertia(self) -> Scalar:
        return WHEEL.inertia

    def load(self, carrier: tuple[()], time: Scalar) -> Scalar:
        return SINE_TORQUE * jnp.sin(2.0 * jnp.pi * (self.started + time) / SINE_PERIOD)

    def carrier_rate(
        self, carrier: tuple[()], speed: Scalar, friction: Scalar, time: Scalar
    ) -> tuple[()]:
        return ()

    def longest_segment(self, time: Scalar) -> Scalar:
        return jnp.inf


@jax.jit
def sine_momentum() -> Scalar:
    """Momentum after two minutes of a sine torque from rest, open loop, N·m·s."""

    def second(carry, started):
        speed, bristle = carry
        motion, bristle, _ = bend(_SineTorque(FRICTION, started), Motion(speed, ()), bristle, 1.0)
        return (motion.speed, bristle), None

    rest = (jnp.array(0.0), jnp.array(0.0))
    (speed, _), _ = jax.lax.scan(second, rest, jnp.arange(SINE_END, dtype=float))
    return WHEEL.inertia * speed


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
        claims=(*_filter_claims(kalman, seeds), *_plain_claims(plain, printed)),
        drawings=(
            momentum_drawing(kalman),
            torque_drawing(kalman),
            control_drawing(kalman),
            residual_drawing(kalman),
            without_drawing(kalman, plain),
        ),
    )


def _at(signal: "xr.DataArray", second: int) -> np.ndarray:
    return signal.sel(time=float(second)).values


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
            ours=float(_at(kalman.friction, 300).mean()),
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
            ours=steady_deflection(),
            unit="m",
            tolerance=1e-7,
            why="F_c / sigma_0, since 500 rpm is far above the Stribeck speed.",
        ),
        Claim(
            id="kf.momentum_300s_mean_Nms",
            quantity=f"momentum at 300 s, {over}",
            paper=REFERENCE,
            ours=float(_at(momentum, 300).mean()),
            unit="N·m·s",
            tolerance=0.01,
            why="The approach is exponential with 1 / gamma = 50 s: e^-6 of it is left.",
        ),
        Claim(
            "kf.momentum_300s_std_Nms",
            "scatter of the momentum at 300 s",
            float(_at(momentum, 300).std(ddof=1)),
            "N·m·s",
            "The noise of the friction estimate drives the wheel.",
        ),
    ]
    claims += [
        Claim(
            f"kf.momentum_{k}s_Nms",
            f"momentum at {k} s, {over}",
            float(_at(momentum, k).mean()),
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


def _plain_claims(plain: "xr.Dataset", printed: "xr.Dataset") -> list[Claim]:
    end = float(_at(plain.momentum, 300).mean())
    away = float(_at(printed.momentum, 300).mean())
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
            "no_estimator.printed_sign_300s_Nms",
            "momentum at 300 s without estimator, (18) as printed, mean",
            away,
            "N·m·s",
            "The printed sign is positive feedback: the wheel runs away backwards.",
        ),
        Claim(
            "lugre_sine.momentum_120s_Nms",
            "momentum after 120 s of 0.03 sin(2 pi t / 60) N·m from rest, open loop",
            float(sine_momentum()),
            "N·m·s",
            "The bristles alone decide what is left of two whole cycles.",
        ),
    ]
