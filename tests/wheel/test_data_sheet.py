"""Data sheets of wheels, and that wheels with their friction come to rest when they must."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import RPM
from gyrostat.wheel import Wheel, advance, pyramid_axes, read_wheel_sheet, wheel_sheets
from gyrostat.wheel.friction import Stribeck, ViscousCoulomb

SHEET = """name = "one"
[momentum_limit]
value = "20 mN·m·s"
source = "a"
[speed_limit]
value = 1000.0
source = "b"
[inertia]
value = 2e-5
source = "c"
[coulomb]
value = "0.05 mN·m"
source = "d"
[viscous]
value = 0
source = "e"
"""


@pytest.mark.parametrize("name", wheel_sheets())
def test_every_sheet_makes_wheels_and_names_its_sources(name):
    sheet = read_wheel_sheet(name)
    wheels = sheet.array(pyramid_axes(4))
    wheels.check()
    assert wheels.count == 4
    assert sheet.sources.keys() == sheet.values.keys()
    assert min(map(len, sheet.sources.values())) > 5
    stribeck = name == "sunspace-0.65"
    assert isinstance(wheels.friction, Stribeck if stribeck else ViscousCoulomb)


def test_published_numbers_are_read_in_si():
    sheet = read_wheel_sheet("bct-rwp015")
    assert sheet.values["momentum_limit"] == pytest.approx(0.015)
    assert sheet.values["torque_limit"] == pytest.approx(0.004)
    assert sheet.values["speed_limit"] == pytest.approx(6000 * RPM)
    assert "estimate" in sheet.sources["coulomb"]


@jax.jit
def _coasts(wheel, speed, step, count):
    """Speed after so many steps without current, rad/s."""
    return jax.lax.fori_loop(0, count, lambda _, w: advance(wheel, w, 0.0, 0.0, step).speed, speed)


def _time_to_rest(values, start):
    """Of a coasting wheel, s: J w0 / c, or J / b log(1 + b w0 / c), or the integral of J / F."""
    inertia, viscous, coulomb = (values[name] for name in ("inertia", "viscous", "coulomb"))
    if "static" in values:
        excess, scale = values["static"] - coulomb, values["stribeck_speed"]

        def slowness(speed):
            bend = excess * np.exp(-((speed / scale) ** 2))
            return inertia / (viscous * speed + coulomb + bend)

        parts = [0.0, scale, 2.0 * scale, start]
        return sum(quad(slowness, *pair, epsabs=1e-13, epsrel=1e-13)[0] for pair in pairwise(parts))
    if viscous == 0.0:
        return inertia * start / coulomb
    return inertia / viscous * np.log1p(viscous * start / coulomb)


@pytest.mark.parametrize("step", [0.01, 0.1, 0.5])
@pytest.mark.parametrize(
    ("name", "speed", "viscous"),
    [
        *((name, 10.0, None) for name in wheel_sheets()),
        *((name, 6000.0, v) for name in ("bct-rwp015", "nanoavionics-rw0") for v in (0.0, 2e-8)),
    ],
)
def test_a_coasting_wheel_is_at_rest_at_the_analytic_time(name, speed, viscous, step):
    """Not before, and for good after, from a speed in rpm.

    The last step is cut where the time is, so that this is told at any step: to 1e-8 s, but for the
    bend of a Stribeck curve, whose error goes with the fourth power of the step.
    """
    values = dict(read_wheel_sheet(name).values)
    values["viscous"] = values["viscous"] if viscous is None else viscous
    names = ("viscous", "coulomb", "static", "stribeck_speed")
    curve = [jnp.asarray(values[key]) for key in names if key in values]
    friction = ViscousCoulomb(*curve) if len(curve) == 2 else Stribeck(*curve)
    inertia, start = jnp.asarray(values["inertia"]), jnp.asarray(speed * RPM)
    wheel = Wheel(inertia, jnp.asarray(1.0), friction)
    time = _time_to_rest(values, float(start))
    whole = int(time / step)
    before = _coasts(wheel, start, jnp.asarray(step), whole)
    rest, near = time - whole * step, 1e-8
    if "static" in values:
        near += 1e-8 * (step / 0.1) ** 4
    ends = [float(_coasts(wheel, before, jnp.asarray(rest + late), 1)) for late in (-near, near)]
    level = values.get("static", values["coulomb"])
    assert 0.0 < ends[0] < 2.0 * near * level / values["inertia"]
    assert ends[1] == 0.0
    assert float(_coasts(wheel, start, jnp.asarray(step), 3 * whole + 3)) == 0.0


def test_a_file_of_ones_own_is_read(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(SHEET, encoding="utf-8")
    sheet = read_wheel_sheet(path)
    assert sheet.name == "one"
    assert sheet.values["coulomb"] == pytest.approx(5e-5)
    assert np.all(np.isinf(sheet.array(np.eye(3)).torque_limit))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "one"', "name = 1", "key name"),
        ('[viscous]\nvalue = 0\nsource = "e"', "", "key viscous: found none"),
        ("[viscous]", "[viscuous]", "did you mean viscous"),
        ('source = "e"', "", "key viscous.source"),
        ('source = "e"', 'source = "e"\nunit = 1', "viscous.unit"),
        ("value = 0\n", "value = -1.0\n", "viscous.value: found -1"),
        ("value = 2e-5", "value = nan", "inertia.value"),
        ("value = 2e-5", "value = 3e-5", "momentum over speed"),
        ('"20 mN·m·s"', '"20 mN·m"', "momentum_limit.value"),
        ("[viscous]", '[static]\nvalue = 1.0\nsource = "f"\n[viscous]', "both or none"),
        ('[viscous]\nvalue = 0\nsource = "e"', "[[viscous]]", "key viscous"),
    ],
)
def test_a_bad_sheet_is_refused_by_its_key(tmp_path, old, new, message):
    path = tmp_path / "bad.toml"
    path.write_text(SHEET.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError, match=message) as caught:
        read_wheel_sheet(path)
    assert str(caught.value).startswith(str(path))


def test_an_unknown_sheet_is_refused_with_the_nearest():
    with pytest.raises(InputError, match=r"did you mean bct-rwp015\?"):
        read_wheel_sheet("bct-rwp15")
