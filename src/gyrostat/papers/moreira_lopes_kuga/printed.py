"""The numbers that the paper prints, and the wheel that they describe."""

from gyrostat._jax import jnp
from gyrostat.body import BenchWheel, MomentumSensor
from gyrostat.estimate import FrictionTorqueFilter
from gyrostat.friction import LuGre, Scalar
from gyrostat.wheel import Wheel

NAME = "moreira-lopes-kuga"
CITATION = (
    "M. L. B. Moreira, R. V. F. Lopes and H. K. Kuga, Estimation of torque in a reaction wheel "
    "using a bristle model for friction"
)
RADIUS = 0.006
"""r, m."""
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
"""J, kg·m²."""
REFERENCE = 1.0
"""h_ref, N·m·s."""
GAIN = 0.02
"""gamma, 1/s."""
MOMENTUM_SIGMA, TORQUE_DRIFT, INITIAL_SIGMA = 0.01, 0.1, 0.1
"""rho, rho_1 and rho_0."""
DURATION, PERIOD = 300.0, 1.0
"""s."""

WHEEL = Wheel(INERTIA, 1.0, FRICTION)
BENCH = BenchWheel(WHEEL)
SENSOR = MomentumSensor(INERTIA, MOMENTUM_SIGMA)
FILTER = FrictionTorqueFilter(MOMENTUM_SIGMA, TORQUE_DRIFT, INITIAL_SIGMA)


def to_reference(time: Scalar) -> Scalar:
    """h_ref from the start, N·m·s."""
    return jnp.full_like(jnp.asarray(time, float), REFERENCE)


def steady_friction() -> float:
    """Friction torque at h_ref, N·m."""
    return float(FRICTION.curve.torque(REFERENCE / INERTIA, 1.0))
