"""Friction laws of a user: accepted ones, broken ones refused in one line, and where."""

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import si_unit
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import (
    FRICTION_MODELS,
    DirectionalStribeck,
    Friction,
    Stribeck,
    ViscousCoulomb,
    parameter,
)
from gyrostat.wheel.friction.contract import check_curve, check_law, is_free_at_rest
from gyrostat.wheel.friction_laws import friction_law


def law(torque, **more):
    """A class of laws with a viscous coefficient and a Coulomb torque."""
    fields = {"viscous": parameter("viscous"), "coulomb": parameter("torque")}
    hints = dict.fromkeys([*fields, *(n for n in more if n in ("inertia", "title"))], float)
    return type("Law", (Friction,), {"__annotations__": hints, **fields, "torque": torque, **more})


class Drag(Friction):
    """F(w) = b w + sgn(w) (c + d w²)."""

    viscous: float = parameter("viscous")
    coulomb: float = parameter("torque")
    drag: float = parameter("N·m·s²/rad²")

    def torque(self, speed, direction):
        return self.viscous * speed + direction * (self.coulomb + self.drag * speed**2)


BROKEN = {
    "sign of the speed": (
        lambda self, w, d: self.viscous * w + self.coulomb * jnp.sign(w),
        "without a jump: the sense of rotation is `direction`, not the sign of the speed",
    ),
    "sign of the speed, direction at rest": (
        lambda self, w, d: self.coulomb * jnp.where(w == 0.0, d, jnp.sign(w)),
        "without a jump",
    ),
    "no direction": (
        lambda self, w, d: self.viscous * w + self.coulomb,
        "found 0.001 N·m at zero speed in direction -1, expected 0 or less",
    ),
    "drives at rest": (
        lambda self, w, d: self.viscous * w - d * self.coulomb,
        "found -0.001 N·m at zero speed in direction \\+1, expected 0 or more",
    ),
    "drives at high speed": (
        lambda self, w, d: d * self.coulomb * (1.0 - d * w / 100.0),
        "N·m along the motion at 10[0-9]\\.?[0-9]* rad/s, which drives the wheel",
    ),
    "not finite": (lambda self, w, d: d * self.coulomb * jnp.exp(d * w), "found the torque inf at"),
    "infinite slope": (
        lambda self, w, d: d * self.coulomb * (1.0 + jnp.abs(w) ** 0.5),
        "found the derivative of torque by speed (nan|inf|-inf) at 0 rad/s",
    ),
    "not odd": (
        lambda self, w, d: d * self.coulomb * jnp.where(d > 0.0, 1.0, 1.2),
        "expected opposite torques; or write `odd = False`",
    ),
    "hardly odd": (
        lambda self, w, d: d * self.coulomb * jnp.where(d > 0.0, 1.0, 1.0 + 1.3e-9),
        "expected opposite torques; or write `odd = False`",
    ),
    "hidden bend": (
        lambda self, w, d: d * self.coulomb * (1.0 + jnp.exp(-((w / 0.4) ** 2))),
        "and a speed_scale of inf rad/s, expected a method speed_scale",
    ),
    "two torques": (
        lambda self, w, d: jnp.array([d * self.coulomb] * 2),
        "found an array of shape \\(2,\\) from torque, expected one number",
    ),
    "integer": (lambda self, w, d: 0, "found int64 from torque, expected real numbers"),
    "nothing": (lambda self, w, d: None, "found NoneType from torque"),
    "if": (
        lambda self, w, d: self.coulomb if w > 0 else -self.coulomb,
        "found if, while, .* expected jnp.where",
    ),
    "exception": (lambda self, w, d: self.nothing * w, "found AttributeError"),
}


@pytest.mark.parametrize(("torque", "message"), BROKEN.values(), ids=BROKEN)
def test_broken_law_is_refused_in_one_line_when_it_is_made(torque, message):
    with pytest.raises(InputError, match=message) as caught:
        law(torque)(4e-6, 1e-3)
    assert str(caught.value).startswith("Law")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Drag(-1e-6, 1e-3, 0.0), "viscous: found -1e-06, expected .* 0 or more N·m·s/rad"),
        (lambda: Drag(1e-6, 1e-3, np.nan), "drag: found nan, expected .* N·m·s²/rad²"),
        (lambda: Drag(1e-6, "high", 0.0), "coulomb: found 'high', expected a number"),
        (lambda: Drag(np.array([1e-6, -1e-6]), 1e-3, 0.0), "viscous: found -1e-06"),
        (lambda: Stribeck(1e-6, -1e-3, 1e-3, 0.4), "coulomb: found -0.001"),
        (lambda: Stribeck(1e-6, 1e-3, 1e-3, 0.0), "stribeck_speed: found 0, .* above 0 rad/s"),
        (lambda: ViscousCoulomb(-1e-6, 1e-3), "viscous: found -1e-06"),
        (lambda: DirectionalStribeck(1e-6, -1e-6, 0, 0, 0, 0, 1.0), "viscous_negative: found -1"),
        (lambda: parameter("torqe"), "found 'torqe', expected an SI unit"),
        (lambda: friction_law("nope"), "found 'nope', expected one of directional"),
        (lambda: friction_law(Wheel), "found Wheel, expected a subclass of .*Friction"),
        (
            lambda: friction_law(law(lambda self, w, d: d * self.coulomb, name="stribeck")),
            "with the name 'stribeck', that of a law of gyrostat",
        ),
        (
            lambda: friction_law(type("Law", (Friction,), {"torque": lambda self, w, d: w})),
            "Law: found no parameter",
        ),
        (
            lambda: friction_law(law(lambda self, w, d: w, inertia=parameter("torque"))),
            "Law: found a parameter inertia, a name with another meaning here",
        ),
        (
            lambda: friction_law(law(lambda self, w, d: w, title=parameter("torque"))),
            "Law: found a parameter title, a name with another meaning here",
        ),
        (
            lambda: friction_law(type("Law", (Drag,), {"held_by_default": ("drg",)})),
            "found drg in held_by_default",
        ),
    ],
)
def test_wrong_parameters_and_classes_are_refused_in_one_line(make, message):
    with pytest.raises(InputError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_trial_values_and_traced_values_are_not_checked():
    assert Drag.of(viscous=-1.0, coulomb=-1.0, drag=0.0).viscous == -1.0
    broken = law(BROKEN["drives at rest"][0])
    assert broken.of(viscous=1.0, coulomb=1.0).torque(0.0, 1.0) == -1.0
    slope = jax.grad(lambda b: Drag(b, 1e-3, 0.0).torque(2.0, 1.0))(-1.0)
    assert float(slope) == 2.0


def test_concrete_values_are_checked_inside_of_a_traced_function():
    broken = law(BROKEN["drives at rest"][0])
    with pytest.raises(InputError, match="at zero speed"):
        jax.jit(lambda w: broken(1e-6, 1e-3).torque(w, 1.0))(1.0)


def test_purely_viscous_friction_is_allowed_and_known_to_never_stick():
    viscous = law(lambda self, w, d: self.viscous * w)(4e-6, 1e-3)
    assert is_free_at_rest(viscous)
    assert not is_free_at_rest(Drag(4e-6, 1e-3, 1e-9))


@pytest.mark.parametrize("name", FRICTION_MODELS)
def test_laws_of_the_package_keep_the_contract(name):
    check_law(FRICTION_MODELS[name])
    check_curve(FRICTION_MODELS[name].from_coulomb(4e-6, 8e-4))


def test_coefficients_of_a_torque_need_no_start_value():
    assert Drag.start_values(4e-6, 8e-4) == pytest.approx(
        {"viscous": 4e-6, "coulomb": 8e-4, "drag": 0.0}, rel=1e-9, abs=1e-18
    )
    # start values are linear in both coefficients, also where no parameter is the viscous one
    bare = law(lambda self, w, d: d * (self.coulomb + self.viscous * jnp.abs(w) ** 1.5))
    one, two = bare.start_values(1e-6, 0.0), bare.start_values(2e-6, 0.0)
    assert two["viscous"] == pytest.approx(2.0 * one["viscous"], rel=1e-12)
    assert one["viscous"] > 0.0


def test_shape_parameter_without_start_value_is_named():
    hints = {"coulomb": float, "range": float}
    fields = {"coulomb": parameter("torque"), "range": parameter("rad/s")}
    smooth = type(
        "Smooth",
        (Friction,),
        {
            "__annotations__": hints,
            **fields,
            "torque": lambda self, w, d: self.coulomb * jnp.tanh(w / self.range),
        },
    )
    with pytest.raises(InputError, match="no start value of range, expected range = parameter"):
        smooth.start_values(4e-6, 8e-4)
    assert smooth(1e-3, 0.4).speed_scale() == 0.4
    assert si_unit(smooth.dimensions()["range"]) == "rad/s"
