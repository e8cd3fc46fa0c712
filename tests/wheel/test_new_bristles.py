"""A new friction with bristles is one class in one file: LuGre on another curve."""

import subprocess
import sys

import numpy as np
import pytest

from gyrostat.core.jax64 import jnp
from gyrostat.wheel import WheelArray
from gyrostat.wheel.friction import (
    WHEEL_FRICTION,
    Bristles,
    DirectionalStribeck,
    LuGre,
    Stribeck,
    static_curve,
)

LAW = '''
"""Bristles on a curve of its own for each direction."""
from gyrostat.wheel.friction.bristles import Bristles
from gyrostat.wheel.friction.directional import DirectionalStribeck

class DirectionalBristles(Bristles):
    """LuGre model with a directional curve."""

    name = "directional_bristles"
    title = "directional bristles"
    curve_law = DirectionalStribeck
'''


class Directional(Bristles):
    name = "directional_here"
    title = "directional bristles"
    curve_law = DirectionalStribeck


def curve_of(law):
    """Values of a law's curve, the same in both directions."""
    both = {"viscous": 5e-6, "coulomb": 1e-3, "static": 1.5e-3, "stribeck_speed": 2.0}
    found = {}
    for name in law.curve_law.dimensions():
        found[name] = next(value for key, value in both.items() if name.startswith(key))
    return found


def test_with_the_same_curve_in_both_directions_it_is_lugre():
    ends = {"stiffness": 0.5, "damping": 1e-4}
    own, known = (law.of(**curve_of(law), **ends) for law in (Directional, LuGre))
    speed, bend = np.linspace(-9.0, 9.0, 37), np.linspace(-2e-3, 2e-3, 37)
    for name in ("torque", "deflection_rate"):
        found, expected = (getattr(law, name)(speed, bend) for law in (own, known))
        np.testing.assert_allclose(found, expected, rtol=1e-14, atol=1e-20)
    np.testing.assert_allclose(own.steady_deflection(speed), known.steady_deflection(speed))
    assert own.parameters() == {**curve_of(Directional), **ends}
    assert own.bristles is own
    assert isinstance(static_curve(own), DirectionalStribeck)
    assert {*Directional.signed()} == {*DirectionalStribeck.signed()}


def test_a_wheel_at_a_constant_speed_has_the_torque_of_its_curve():
    """In steady rotation F is the curve, for each direction."""
    values = curve_of(Directional)
    changed = next(name for name in values if name.startswith("coulomb"))
    values[changed] *= 1.2
    law = Directional.of(**values, stiffness=0.5, damping=1e-4)
    for speed in (-5.0, 5.0):
        steady = law.steady_deflection(speed)
        assert float(law.deflection_rate(speed, steady)) == pytest.approx(0.0, abs=1e-15)
        expected = static_curve(law).torque(speed, np.sign(speed))
        assert float(law.torque(speed, steady)) == pytest.approx(float(expected), rel=1e-14)


def test_wheels_take_it():
    ends = {"stiffness": 0.5, "damping": 1e-4}
    law = Directional.of(**{k: jnp.full(3, v) for k, v in (curve_of(Directional) | ends).items()})
    wheels = WheelArray(jnp.eye(3), jnp.full(3, 1e-4), friction=law)
    wheels.check_own()
    assert wheels.friction.bristles is law
    assert Stribeck.bristles is None
    assert isinstance(LuGre.dahl(1e-3, 1.0), LuGre)


def test_the_file_alone_registers_it(tmp_path):
    (tmp_path / "directional_bristles.py").write_text(LAW)
    script = (
        "import gyrostat.core.classes_of as search\n"
        "plain = search.iter_modules\n"
        "def extended(path):\n"
        f"    path.append({str(tmp_path)!r})\n"
        "    return plain(path)\n"
        "search.iter_modules = extended\n"
        "from gyrostat.wheel.friction import WHEEL_FRICTION\n"
        "print(*WHEEL_FRICTION)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert {*done.stdout.split()} == {*WHEEL_FRICTION, "directional_bristles"}
