"""LuGre friction: its steady state, its presliding, its energy, and what it refuses."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrostat.core.errors import InputError
from gyrostat.wheel.friction import (
    DirectionalStribeck,
    LuGre,
    Stribeck,
    ViscousCoulomb,
    static_curve,
)

CURVES = [
    Stribeck(4.83e-6, 0.8795e-3, 0.9055e-3, 0.418879),
    ViscousCoulomb(1e-5, 1e-3),
    DirectionalStribeck(1e-5, 2e-5, 1e-3, 1.2e-3, 1.1e-3, 1.5e-3, 0.3),
]
# Hirschorn and Miller (1999), as printed in Moreira, Lopes and Kuga
PAPER = {
    "radius": 0.006,
    "stiffness": 1e5,
    "damping": 495.0,
    "viscous": 4.6,
    "coulomb": 2.0,
    "static": 2.5,
    "stribeck_speed": 0.01,
}


@pytest.mark.parametrize("curve", CURVES, ids=lambda c: c.name)
@pytest.mark.parametrize("speed", [-80.0, -0.2, -1e-3, 1e-3, 0.2, 80.0])
def test_steady_rotation_has_the_static_curve(curve, speed):
    lugre = LuGre(curve, 0.5, 1e-3)
    deflection = lugre.steady_deflection(speed)
    assert float(lugre.deflection_rate(speed, deflection)) == pytest.approx(0.0, abs=1e-12)
    expected = float(curve.torque(speed, np.sign(speed)))
    assert float(lugre.torque(speed, deflection)) == pytest.approx(expected, rel=1e-12)
    assert static_curve(lugre) is curve
    assert static_curve(curve) is curve


def test_the_linear_form_is_that_of_the_paper():
    """Eqs. (2)-(5) written out in forces and metres, at 500 rpm and near zero."""
    lugre = LuGre.from_linear(**PAPER)
    r = PAPER["radius"]
    for speed, z in ((52.0, 2e-5), (0.5, 1e-5), (-1.0, 1.5e-5)):
        v = r * speed
        force = PAPER["coulomb"] + 0.5 * np.exp(-((v / PAPER["stribeck_speed"]) ** 2))
        z_rate = v - PAPER["stiffness"] * abs(v) / force * z
        torque = r * (PAPER["stiffness"] * z + PAPER["damping"] * z_rate + PAPER["viscous"] * v)
        assert float(lugre.deflection_rate(speed, z / r)) == pytest.approx(z_rate / r, rel=1e-12)
        assert float(lugre.torque(speed, z / r)) == pytest.approx(torque, rel=1e-12)


def test_dahl_is_lugre_without_damping_and_with_one_level():
    dahl = LuGre.dahl(1e-3, 0.5)
    for speed, z in ((3.0, 1e-3), (-3.0, 1e-3)):
        rate = speed * (1.0 - 0.5 * z / 1e-3 * np.sign(speed))
        assert float(dahl.deflection_rate(speed, z)) == pytest.approx(rate, rel=1e-12)
        assert float(dahl.torque(speed, z)) == pytest.approx(0.5 * z, rel=1e-12)
    assert bool(dahl.is_passive())


@given(
    st.floats(0.0, 1.0),
    st.floats(-1.0, 1.0),
    st.floats(-300.0, 300.0),
    st.floats(1.0, 3.0),
)
def test_passive_bristles_never_give_out_energy(share, bend, speed, ratio):
    """F w - d/dt (s_0 z²/2) >= 0 for every admissible deflection, at damping within the limit."""
    curve = Stribeck(1e-4, 1e-3, ratio * 1e-3, 0.4)
    limit = min(float(LuGre(curve, 0.5, 0.0).largest_passive_damping()), 10.0)
    lugre = LuGre(curve, 0.5, share * limit)
    z = bend * ratio * 1e-3 / 0.5
    stored = 0.5 * z * float(lugre.deflection_rate(speed, z))
    given_in = float(lugre.torque(speed, z)) * speed
    # the smallest numbers of all are flushed to zero in one of the two
    assert given_in - stored >= -1e-12 * (abs(given_in) + abs(stored)) - 1e-300


def test_too_much_damping_gives_out_energy():
    """The paper's own parameters: beyond the limit, and it happens."""
    lugre = LuGre.from_linear(**PAPER)
    limit = PAPER["viscous"] * 2.0 / 0.5 * PAPER["radius"] ** 2
    assert float(lugre.largest_passive_damping()) == pytest.approx(limit, rel=1e-9)
    assert not bool(lugre.is_passive())
    speed, z = 52.0, PAPER["radius"] * 2.5 / float(lugre.stiffness)
    stored = float(lugre.stiffness) * z * float(lugre.deflection_rate(speed, z))
    assert float(lugre.torque(speed, z)) * speed - stored < 0.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"radius": 0.0}, "radius: found 0,"),
        ({"stribeck_speed": 0.0}, "stribeck_speed: found 0,"),
        ({"stiffness": -1.0}, "stiffness: found -1,"),
        ({"damping": np.nan}, "damping: found nan,"),
        ({"static": 1.9}, "static: found 1.9 N, expected at least coulomb 2 N"),
    ],
)
def test_what_no_bearing_has_is_refused(change, message):
    with pytest.raises(InputError, match=message):
        LuGre.from_linear(**{**PAPER, **change})


STRIBECK = {"viscous": 1e-5, "coulomb": 1e-3, "static": 1.2e-3, "stribeck_speed": 0.4}


@pytest.mark.parametrize(
    ("curve", "bristles", "message"),
    [
        ({"stribeck_speed": 0.0}, {}, "stribeck_speed: found 0, expected a finite value above 0"),
        ({"viscous": -1e-5}, {}, "viscous: found -1e-05"),
        ({"coulomb": np.inf}, {}, "coulomb: found inf"),
        ({"static": 0.9e-3}, {}, "level at rest: found 0.0009 N·m, expected at least .* 0.001 N·m"),
        ({"coulomb": 0.0}, {}, "bristle level: found 0"),
        ({}, {"stiffness": 0.0}, "bristle stiffness: found 0"),
        ({}, {"stiffness": -0.5}, "bristle stiffness: found -0.5"),
        ({}, {"damping": -1e-3}, "bristle damping: found -0.001"),
    ],
)
def test_bristles_that_no_bearing_has_are_refused(curve, bristles, message):
    # a curve that is no friction is refused when it is made
    with pytest.raises(InputError, match=message):
        LuGre(
            Stribeck(**{**STRIBECK, **curve}), **{"stiffness": 0.5, "damping": 1e-3, **bristles}
        ).check()


def test_both_senses_of_a_bristle_curve_are_checked():
    lame = DirectionalStribeck(1e-5, 1e-5, 1e-3, 0.0, 1e-3, 0.0, 0.3)
    with pytest.raises(InputError, match="bristle level: found"):
        LuGre(lame, 0.5, 1e-3).check()
    for curve in CURVES:
        LuGre(curve, 0.5, 1e-3).check()
    many = Stribeck(np.full(3, 1e-5), np.full(3, 1e-3), np.array([1.0, 1.2, 0.5]) * 1e-3, 0.4)
    with pytest.raises(InputError, match=r"level at rest: found 0\.0005 N·m"):
        LuGre(many, 0.5, 1e-3).check()
