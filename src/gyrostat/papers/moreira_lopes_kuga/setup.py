"""Parameters that the paper prints, and the wheel, sensor and filter that they describe."""

from typing import TYPE_CHECKING, Any

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.estimation import FrictionTorqueFilter
from gyrostat.papers.moreira_lopes_kuga.bench_wheel import BenchWheel, MomentumSensor
from gyrostat.simulation import simulate
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import LuGre

if TYPE_CHECKING:
    import xarray as xr

RADIUS = 0.006
"""Radius r of the bearing, m."""
FRICTION = LuGre.from_linear(
    radius=RADIUS,
    stiffness=1e5,
    damping=495.0,
    viscous=4.6,
    coulomb=2.0,
    static=2.5,
    stribeck_speed=0.01,
)
INERTIA = 0.0191
"""Rotor inertia J, kg·m²."""
REFERENCE = 1.0
"""Momentum reference h_ref, N·m·s."""
GAIN = 0.02
"""Control gain gamma, 1/s."""
MOMENTUM_SIGMA, TORQUE_DRIFT, INITIAL_SIGMA = 0.01, 0.1, 0.1
"""Filter parameters rho, rho_1 and rho_0."""
DURATION, PERIOD = 300.0, 1.0
"""Duration of a run and period of the measurements, s."""
SEEDS, QUICK_SEEDS = 64, 40
"""Number of runs of each case, in a full and in a quick reproduction."""

WHEEL = Wheel(INERTIA, 1.0, FRICTION)
BENCH = BenchWheel(WHEEL)
SENSOR = MomentumSensor(INERTIA, MOMENTUM_SIGMA)
FILTER = FrictionTorqueFilter(MOMENTUM_SIGMA, TORQUE_DRIFT, INITIAL_SIGMA)


def to_reference(time: Scalar) -> Scalar:
    """Momentum reference h_ref, N·m·s, constant from the start."""
    return jnp.full_like(jnp.asarray(time, float), REFERENCE)


def steady_friction() -> float:
    """Friction torque at h_ref in steady rotation, N·m."""
    return float(FRICTION.curve.torque(REFERENCE / INERTIA, 1.0))


def fly(controller: Any, seeds: int, *, plant: Any = BENCH) -> "xr.Dataset":
    """Simulate the wheel from rest, one run for each noise seed; see `gyrostat.simulation`."""
    return simulate(
        plant,
        controller,
        SENSOR,
        start=BENCH.start(),
        duration=DURATION,
        control_period=PERIOD,
        runs=seeds,
    )


def mean_at(signal: "xr.DataArray", second: int) -> float:
    """Mean of all runs at a given second."""
    return float(signal.sel(time=float(second)).values.mean())
