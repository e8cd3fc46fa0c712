"""Friction curves against their equations, and the promise that a new file is a new model."""

from typing import ClassVar

import numpy as np
import pytest

from gyrostat._jax import jnp
from gyrostat.friction import FRICTION_MODELS, Friction, Stribeck, ViscousCoulomb, parameter
from gyrostat.units import SI_UNIT
from gyrostat.wheel import Wheel, speed_response

SPEEDS = np.array([-40.0, -0.3, -1e-9, 1e-9, 0.2, 7.0])


def test_stribeck_curve_is_its_equation():
    model = Stribeck(viscous=2e-6, coulomb=9e-4, static=1.1e-3, stribeck_speed=0.4)
    for speed in SPEEDS:
        sense = np.sign(speed)
        expected = 2e-6 * speed + sense * (9e-4 + 2e-4 * np.exp(-(speed**2) / 0.16))
        assert float(model.torque(speed, sense)) == pytest.approx(expected, rel=1e-14)
    assert float(model.breakaway_torque(1.0)) == pytest.approx(1.1e-3)
    assert float(model.breakaway_torque(-1.0)) == pytest.approx(1.1e-3)


def test_viscous_coulomb_curve_is_its_equation():
    model = ViscousCoulomb(viscous=2e-6, coulomb=9e-4)
    for speed in SPEEDS:
        expected = 2e-6 * speed + np.sign(speed) * 9e-4
        assert float(model.torque(speed, np.sign(speed))) == pytest.approx(expected, rel=1e-14)


def test_directional_curve_is_two_stribeck_curves():
    values = (2e-6, 3e-6, 9e-4, 8e-4, 1.1e-3, 1.2e-3, 0.4)
    model = FRICTION_MODELS["directional"](*values)
    sides = {1.0: Stribeck(2e-6, 9e-4, 1.1e-3, 0.4), -1.0: Stribeck(3e-6, 8e-4, 1.2e-3, 0.4)}
    for speed in SPEEDS:
        sense = float(np.sign(speed))
        expected = float(sides[sense].torque(speed, sense))
        assert float(model.torque(speed, sense)) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("model", FRICTION_MODELS.values(), ids=FRICTION_MODELS)
def test_every_model_starts_as_coulomb_friction_and_keeps_its_promises(model):
    start = model.from_coulomb(3e-6, 7e-4)
    plain = ViscousCoulomb(3e-6, 7e-4)
    for speed in SPEEDS:
        sense = np.sign(speed)
        assert float(start.torque(speed, sense)) == pytest.approx(
            float(plain.torque(speed, sense)), rel=1e-14
        )
    assert model(**start.parameters()) == start
    assert all(dimension in SI_UNIT for dimension in model.dimensions().values())
    assert set(model.held_by_default) <= set(model.dimensions())
    assert set(model.vanishing_at) | set(model.vanishing_at.values()) <= set(model.dimensions())


def test_a_new_model_works_without_touching_anything_else():
    class Windage(Friction):
        """F(w) = sgn(w) (c + k w²)."""

        name: ClassVar[str] = "windage"
        title: ClassVar[str] = "Coulomb and windage"
        coulomb: float = parameter("torque")
        windage: float = parameter("viscous")

        def torque(self, speed, direction):
            return direction * (self.coulomb + self.windage * speed**2)

        def speed_scale(self):
            return float("inf")

        @classmethod
        def from_coulomb(cls, viscous, coulomb):
            return cls(coulomb=coulomb, windage=0.0 * viscous)

    wheel = Wheel(inertia=1.0, motor_constant=1.0, friction=Windage(0.0, 0.5))
    time = jnp.linspace(0.0, 3.0, 301)
    speeds, resolved = speed_response(wheel, time, jnp.zeros(301), 2.0)
    assert bool(resolved)
    np.testing.assert_allclose(speeds, 2.0 / (1.0 + time), rtol=1e-8)
