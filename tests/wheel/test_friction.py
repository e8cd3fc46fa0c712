"""Friction curves against their equations, and the promise that a new file is a new model."""

import ast
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gyrostat.wheel.friction
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import SI_UNIT
from gyrostat.wheel import Wheel, speed_response
from gyrostat.wheel.friction import (
    FRICTION_MODELS,
    DirectionalStribeck,
    Friction,
    Stribeck,
    ViscousCoulomb,
    parameter,
)

each_model = pytest.mark.parametrize("model", FRICTION_MODELS.values(), ids=FRICTION_MODELS)
SPEEDS = np.concatenate([-np.geomspace(1e-9, 700.0, 40), np.geomspace(1e-9, 700.0, 40)])
values = st.floats(0.0, 2.0)


def torque(friction, speeds):
    """The curve at many speeds, each with its own sense of rotation."""
    senses = np.where(speeds < 0.0, -1.0, 1.0)
    return np.asarray(jax.vmap(friction.torque)(speeds, senses))


def stribeck(speeds, viscous, coulomb, static, scale):
    decay = np.exp(-np.square(speeds) / scale**2)
    return viscous * speeds + np.sign(speeds) * (coulomb * (1.0 - decay) + static * decay)


@given(values, values, values, st.floats(0.01, 10.0))
def test_stribeck_curve_is_its_equation(viscous, coulomb, static, scale):
    friction = Stribeck(viscous, coulomb, static, scale)
    expected = stribeck(SPEEDS, viscous, coulomb, static, scale)
    np.testing.assert_allclose(torque(friction, SPEEDS), expected, rtol=1e-12, atol=1e-14)
    assert float(friction.breakaway_torque(1.0)) == pytest.approx(static, abs=1e-15)
    assert float(friction.breakaway_torque(-1.0)) == pytest.approx(static, abs=1e-15)
    assert friction.speed_scale() == scale


@given(values, values)
def test_viscous_coulomb_curve_is_its_equation(viscous, coulomb):
    friction = ViscousCoulomb(viscous, coulomb)
    expected = viscous * SPEEDS + np.sign(SPEEDS) * coulomb
    np.testing.assert_allclose(torque(friction, SPEEDS), expected, rtol=1e-15, atol=1e-15)
    assert friction.breakaway_torque(1.0) == friction.breakaway_torque(-1.0) == coulomb
    assert friction.speed_scale() == np.inf


def test_directional_curve_is_a_stribeck_curve_of_its_own_on_either_side():
    forward, backward = (2e-6, 9e-4, 1.1e-3, 0.4), (3e-6, 8e-4, 1.2e-3, 0.4)
    pairs = [value for pair in zip(forward, backward, strict=True) for value in pair]
    friction = DirectionalStribeck(*pairs[:-1])
    expected = np.where(SPEEDS > 0.0, stribeck(SPEEDS, *forward), stribeck(SPEEDS, *backward))
    np.testing.assert_allclose(torque(friction, SPEEDS), expected, rtol=1e-13)
    assert float(friction.breakaway_torque(1.0)) == pytest.approx(1.1e-3, rel=1e-15)
    assert float(friction.breakaway_torque(-1.0)) == pytest.approx(1.2e-3, rel=1e-15)


@each_model
def test_past_zero_the_curve_of_one_sense_goes_on_smoothly(model):
    """What lets a crossing be located: no jump and no kink at zero for a frozen sense."""
    friction = model.from_coulomb(3e-6, 7e-4)
    for sense in (1.0, -1.0):
        curve, slope = jax.vmap(
            jax.value_and_grad(lambda w, sense=sense: friction.torque(w, sense))
        )(np.array([-1e-9, 0.0, 1e-9]))
        np.testing.assert_allclose(curve, curve[1], rtol=1e-10)
        np.testing.assert_allclose(slope, slope[1], rtol=1e-10)


@jax.jit
def swung(wheel):
    """Speeds of a wheel under a sine of the current."""
    time = 0.05 * np.arange(200)
    return speed_response(wheel, time, 0.06 * np.sin(2.0 * time), 1.0, hold="linear")


@each_model
def test_from_coulomb_gives_viscous_plus_coulomb_friction(model):
    """The same curve, and the same speeds through crossings and rest, to rounding."""
    plain, start = ViscousCoulomb(3e-6, 7e-4), model.from_coulomb(3e-6, 7e-4)
    np.testing.assert_allclose(torque(start, SPEEDS), torque(plain, SPEEDS), rtol=1e-15)
    expected, _ = swung(Wheel(1.5e-3, 0.0228, plain))
    speeds, resolved = swung(Wheel(1.5e-3, 0.0228, start))
    assert bool(resolved)
    assert np.any(np.asarray(expected) == 0.0)
    np.testing.assert_allclose(speeds, expected, atol=1e-13)


@each_model
def test_a_model_says_all_that_others_ask_of_it(model):
    friction = model.from_coulomb(3e-6, 7e-4)
    assert model(**friction.parameters()) == friction
    assert list(friction.parameters()) == list(model.dimensions())
    assert set(model.dimensions().values()) <= set(SI_UNIT)
    assert set(model.held_by_default) <= set(model.dimensions())
    assert set(model.vanishing_at) | set(model.vanishing_at.values()) <= set(model.dimensions())
    # where one parameter takes the effect of another away, the curve does not change with it
    for vanishing, at in model.vanishing_at.items():
        assert friction.parameters()[vanishing] == friction.parameters()[at]
    assert model.title
    assert FRICTION_MODELS[model.name] is model


def test_every_model_in_the_package_is_known_by_a_name_of_its_own():
    found = {}
    for path in Path(gyrostat.wheel.friction.__file__).parent.glob("*.py"):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            bases = [getattr(base, "id", None) for base in getattr(node, "bases", [])]
            if "Friction" in bases:
                found[node.name] = path.name
    assert found == {model.__name__: found[model.__name__] for model in FRICTION_MODELS.values()}
    assert len(set(found.values())) == len(found), "one file for each model"


class Windage(Friction):
    """F(w) = sgn(w) (c + k w²): a model as somebody else would write it."""

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
        return cls(coulomb=coulomb, windage=0.0)


def test_a_new_model_turns_a_wheel_without_touching_anything_else():
    """Coasting: w = sqrt(c/k) tan(atan(w0 sqrt(k/c)) - t sqrt(c k)), J = 1, and a clean stop."""
    coulomb, windage, initial = 0.5, 0.02, 20.0
    time = np.linspace(0.0, 14.0, 281)
    wheel = Wheel(inertia=1.0, motor_constant=1.0, friction=Windage(coulomb, windage))

    def end(initial):
        return speed_response(wheel, time, jnp.zeros(281), initial)

    (speeds, resolved), (slopes, _) = jax.jit(lambda w: jax.jvp(end, (w,), (1.0,)))(initial)
    assert bool(resolved)
    phase = np.arctan(initial * np.sqrt(windage / coulomb)) - time * np.sqrt(coulomb * windage)
    expected = np.sqrt(coulomb / windage) * np.tan(np.maximum(phase, 0.0))
    np.testing.assert_allclose(speeds, expected, atol=1e-6)
    # dw/dw0 = w' / w0'
    ratio = (coulomb + windage * expected**2) / (coulomb + windage * initial**2)
    np.testing.assert_allclose(slopes, np.where(phase > 0.0, ratio, 0.0), atol=1e-6)
