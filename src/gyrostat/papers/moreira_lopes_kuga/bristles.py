"""What follows from the paper's bristles alone."""

from typing import Any

from gyrostat._jax import jax, jnp
from gyrostat.friction import Friction, LuGre, Scalar
from gyrostat.papers.claims import Claim
from gyrostat.papers.moreira_lopes_kuga.printed import FRICTION, INERTIA, RADIUS, REFERENCE, WHEEL
from gyrostat.units import RPM
from gyrostat.wheel import Contact, Motion, carry

SINE_TORQUE, SINE_PERIOD, SINE_END = 0.03, 60.0, 120
"""N·m, s, s."""


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
def sine_momentum(friction: Friction | LuGre = FRICTION) -> Scalar:
    """Momentum after two minutes of a sine torque from rest, open loop, N·m·s."""

    def second(state, started):
        speed, bristle = state
        contact = _SineTorque(friction, started)
        motion, bristle, _ = carry(contact, Motion(speed, ()), bristle, 1.0)
        return (motion.speed, bristle), None

    rest = (jnp.array(0.0), jnp.array(0.0))
    (speed, _), _ = jax.lax.scan(second, rest, jnp.arange(SINE_END, dtype=float))
    return WHEEL.inertia * speed


def model_claims() -> list[Claim]:
    """Judge what needs no filter."""
    damping = float(FRICTION.damping) / RADIUS**2
    limit = float(FRICTION.largest_passive_damping()) / RADIUS**2
    return [
        Claim(
            id="reference.speed_rpm",
            quantity="speed of the wheel at h_ref",
            paper=500.0,
            ours=REFERENCE / INERTIA / RPM,
            unit="rpm",
            tolerance=0.5,
            why="h_ref / J.",
        ),
        Claim(
            "lugre.largest_passive_damping_Nspm",
            "largest sigma_1 for which the bristles cannot give out energy",
            limit,
            "N·s/m",
            f"sigma_2 F_c / (F_s - F_c); the paper's {damping:g} N·s/m is {damping / limit:.0f} "
            "times that: strongly bent bristles can drive the wheel.",
        ),
        Claim(
            "lugre_sine.momentum_120s_Nms",
            "momentum after 120 s of 0.03 sin(2 pi t / 60) N·m from rest, open loop",
            float(sine_momentum()),
            "N·m·s",
            "Friction turns with the speed, which lags the torque: two cycles do not cancel. The "
            f"static curve alone leaves {float(sine_momentum(FRICTION.curve)):.5f} N·m·s.",
        ),
    ]
