"""The paper's filter, its loop without estimator, and its bristle model in open loop."""

from typing import TYPE_CHECKING, Any

import numpy as np

from gyrostat.control import FrictionTorqueControl, ProportionalMomentumControl
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import RPM
from gyrostat.papers.claims import Value
from gyrostat.papers.moreira_lopes_kuga import setup
from gyrostat.papers.moreira_lopes_kuga.figures import figures
from gyrostat.papers.reproduction import Part, Run
from gyrostat.wheel import BearingEquation, Motion, step_wheel
from gyrostat.wheel.friction import AnyFriction

if TYPE_CHECKING:
    import xarray as xr

SETTLED = 200
"""Time after which the wheel counts as settled, s."""
SINE_TORQUE, SINE_PERIOD, SINE_END = 0.03, 60.0, 120
"""Amplitude, N·m, period, s, and duration, s, of the sine torque."""


def loops(run: Run) -> Part:
    """Simulate the loop with the paper's filter and without a filter."""
    seeds = setup.QUICK_SEEDS if run.quick else setup.SEEDS
    run.say(f"{seeds} runs with and without the filter")
    kalman = setup.fly(FrictionTorqueControl(setup.FILTER, setup.GAIN, setup.to_reference), seeds)
    unfiltered = setup.fly(ProportionalMomentumControl(setup.GAIN, setup.to_reference), seeds)
    gain = np.asarray(setup.FILTER.steady_gain(setup.PERIOD))
    residual = (kalman.measured_momentum - kalman.estimated_momentum).values
    late = kalman.isel(time=slice(SETTLED, None))
    momentum = kalman.momentum
    effective = [_largest_effective(histories) for histories in (kalman, unfiltered)]
    spread = [_friction_spread(histories) for histories in (kalman, unfiltered)]
    values: dict[str, Value] = {
        "kf.friction_torque_300s_Nm": setup.mean_at(kalman.friction, 300),
        "kf.friction_torque_steady_Nm": setup.steady_friction(),
        "kf.bristle_deflection_m": setup.RADIUS * setup.mean_at(kalman.bristle, 300),
        "kf.momentum_300s_mean_Nms": setup.mean_at(momentum, 300),
        "kf.overshoot": bool(momentum.mean("run").max() > setup.REFERENCE),
        "kf.momentum_300s_std_Nms": float(momentum.sel(time=300.0).values.std(ddof=1)),
        **{f"kf.momentum_{k}s_Nms": setup.mean_at(momentum, k) for k in (50, 100, 150, 200)},
        "kf.gain_momentum": float(gain[0]),
        "kf.gain_friction": float(gain[1]),
        "kf.residual_posterior_max_Nms": _mean_largest(residual),
        "kf.innovation_max_Nms": _mean_largest(kalman.innovation.values),
        "kf.friction_estimate_std_Nm": float((late.estimated_friction - late.friction).std()),
        "no_estimator.momentum_300s_Nms": setup.mean_at(unfiltered.momentum, 300),
        "no_estimator.overshoot": bool(unfiltered.momentum.max() > setup.REFERENCE),
        "no_estimator.momentum_280s_Nms": setup.mean_at(unfiltered.momentum, 280),
        "no_estimator.friction_torque_300s_Nm": setup.mean_at(unfiltered.friction, 300),
        "no_estimator.bristle_deflection_m": setup.RADIUS * setup.mean_at(unfiltered.bristle, 300),
        "kf.larger_effective_torque": effective[0] > effective[1],
        "kf.friction_more_spread": spread[0] > spread[1],
        "reference.speed_rpm": setup.REFERENCE / setup.INERTIA / RPM,
    }
    facts = {
        "seeds": seeds,
        "largest_momentum": float(momentum.max()),
        "left_percent": 100.0 * (1.0 - gain[0]),
        "effective": effective,
        "spread": spread,
        "steady": setup.steady_friction(),
    }
    return Part(values, facts, figures(kalman, unfiltered))


def _mean_largest(signal: np.ndarray) -> float:
    """Largest magnitude of each run, averaged over the runs."""
    return float(np.max(np.abs(signal), axis=1).mean())


def _largest_effective(histories: "xr.Dataset") -> float:
    """Largest commanded minus friction torque of each run, averaged over the runs, N·m."""
    effective = histories.torque + histories.fading_torque - histories.friction
    return float(np.max(effective.values, axis=1).mean())


def _friction_spread(histories: "xr.Dataset") -> float:
    """Standard deviation of the settled friction torque over time, averaged over the runs, N·m."""
    return float(histories.friction.isel(time=slice(SETTLED, None)).std("time").mean())


class _SineTorque(BearingEquation):
    friction: Any
    started: Scalar

    def inertia(self) -> Scalar:
        return setup.WHEEL.inertia

    def load(self, carrier: tuple[()], time: Scalar) -> Scalar:
        return SINE_TORQUE * jnp.sin(2.0 * jnp.pi * (self.started + time) / SINE_PERIOD)

    def carrier_rate(
        self, carrier: tuple[()], speed: Scalar, friction: Scalar, time: Scalar
    ) -> tuple[()]:
        return ()

    def longest_segment(self, time: Scalar) -> Scalar:
        return jnp.inf


@jax.jit
def sine_momentum(friction: AnyFriction = setup.FRICTION) -> Scalar:
    """Momentum after two minutes of a sine torque from rest, open loop, N·m·s."""

    def second(state, started):
        speed, bristle = state
        contact = _SineTorque(friction, started)
        motion, bristle, _ = step_wheel(contact, Motion(speed, ()), bristle, 1.0)
        return (motion.speed, bristle), None

    start = (jnp.array(0.0), jnp.array(0.0))
    (speed, _), _ = jax.lax.scan(second, start, jnp.arange(SINE_END, dtype=float))
    return setup.WHEEL.inertia * speed


def open_loop(run: Run) -> Part:
    """Simulate the bristle model under a sine torque."""
    return Part(
        {"lugre_sine.momentum_120s_Nms": float(sine_momentum())},
        {"static_sine": float(sine_momentum(setup.FRICTION.curve))},
    )
