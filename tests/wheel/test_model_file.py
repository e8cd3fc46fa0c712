"""model.toml: what is written is read back bit by bit, and what no wheel has is refused."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrostat.core.errors import InputError
from gyrostat.core.validation import LARGEST, SMALLEST
from gyrostat.wheel import Wheel, WheelModel, read_model, write_model
from gyrostat.wheel.friction import WHEEL_FRICTION, LuGre, Stribeck

GOOD = """
[wheel]
inertia = 0.0015
motor_constant = 0.0228

[friction]
model = "stribeck"
viscous = 4.83e-06
coulomb = 0.0008795
static = 0.0009055
stribeck_speed = 0.418879

[sigma]
static = 1e-6
"""
positive = st.floats(SMALLEST, LARGEST)
finite = st.one_of(st.just(0.0), positive, positive.map(lambda value: -value))
# a surrogate alone is no character: no file can hold it
texts = st.text(st.characters(exclude_categories=["Cs"]))


@given(st.data(), st.sampled_from([*WHEEL_FRICTION.values()]))
def test_a_model_is_read_back_bit_by_bit(tmp_path_factory, data, friction):
    names = ("inertia", "motor_constant", *friction.dimensions())
    # a wheel that is marked as impossible keeps its values, whatever they are
    values = {n: data.draw(finite if n in friction.dimensions() else positive) for n in names}
    if data.draw(st.booleans()):
        del values["inertia"]
    sigma = data.draw(st.dictionaries(st.sampled_from(names), finite))
    origin = data.draw(st.dictionaries(st.sampled_from(["method", "record"]), texts))
    path = tmp_path_factory.getbasetemp() / "model.toml"
    write_model(path, WheelModel(friction, values, sigma, origin, "coulomb"))
    back = read_model(path, force=True)
    assert back.friction is friction
    assert {n: v.hex() for n, v in back.values.items()} == {n: v.hex() for n, v in values.items()}
    assert (back.sigma, back.origin) == (sigma, origin)


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("coulomb", "-8e-4", "key friction: coulomb: found -0.0008, expected a finite value of 0"),
        ("viscous", "-1e-6", "key friction: viscous: found -1e-06, expected a finite value of 0"),
    ],
)
def test_friction_that_drives_the_wheel_is_refused_with_file_and_key(
    tmp_path, key, value, expected
):
    path = tmp_path / "model.toml"
    path.write_text(re.sub(rf"(?m)^{key} = .*$", f"{key} = {value}", GOOD, count=1))
    with pytest.raises(InputError) as caught:
        read_model(path)
    assert f"{path}: {expected}" in str(caught.value)
    path.write_text(f"{path.read_text()}\n{key} = 1e-3\n")  # one standard deviation from 0
    assert read_model(path).values[key] == float(value)


def test_the_wheel_of_a_file(tmp_path):
    path = tmp_path / "model.toml"
    path.write_text("\ufeff" + GOOD, encoding="utf-8")
    friction = Stribeck(
        viscous=4.83e-6, coulomb=0.8795e-3, static=0.9055e-3, stribeck_speed=0.418879
    )
    assert read_model(path).wheel() == Wheel(1.5e-3, 0.0228, friction)


def test_the_bristles_of_a_file_have_a_stribeck_curve(tmp_path):
    path = tmp_path / "model.toml"
    bristles = "stiffness = 8.8e-3\ndamping = 2.2e-3\n[sigma]"
    path.write_text(GOOD.replace('"stribeck"', '"lugre"').replace("[sigma]", bristles))
    curve = Stribeck(viscous=4.83e-6, coulomb=0.8795e-3, static=0.9055e-3, stribeck_speed=0.418879)
    assert read_model(path).wheel() == Wheel(1.5e-3, 0.0228, LuGre(curve, 8.8e-3, 2.2e-3))


def test_a_wheel_without_inertia_is_a_model_but_no_wheel(tmp_path):
    path = tmp_path / "model.toml"
    path.write_text(GOOD.replace("inertia = 0.0015\n", ""))
    with pytest.raises(InputError, match="found no inertia"):
        read_model(path).wheel()


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        (
            "inertia = 0.0015",
            "inertia = 0.0",
            "key wheel.inertia: found 0.0, expected a number above 0",
        ),
        ("inertia = 0.0015", "inertia = true", "key wheel.inertia: found True"),
        ("inertia = 0.0015", "inertia = 1" + 400 * "0", "key wheel.inertia: found 1000"),
        ("inertia = 0.0015", "inertia = 1" + 5000 * "0", "found invalid TOML"),
        ("inertia = 0.0015", "inertia = " + 5000 * "[", "found invalid TOML"),
        ("inertia", "inertai", r"key wheel.inertai: .*did you mean wheel.inertia\?"),
        ("motor_constant = 0.0228", "", "key wheel.motor_constant: found none"),
        ("motor_constant = 0.0228", "motor_constant = 0", "motor_constant: found 0, expected a n"),
        ("constant = 0.0228", "constant = -0.02", "motor_constant: found -0.02, expected a n"),
        ("viscous = 4.83e-06", "viscous = nan", "key friction.viscous: found nan"),
        ("viscous = 4.83e-06", "viscous = '5'", "key friction.viscous: found '5'"),
        ("coulomb = 0.0008795", "", "key friction.coulomb: found none"),
        (
            "stribeck_speed = 0.418879",
            "stribeck_speed = -1.0",
            "found -1.0, expected a number above 0",
        ),
        (
            '"stribeck"',
            '"dahl"',
            "key friction.model: found 'dahl', expected one of directional,",
        ),
        ('"stribeck"', '["stribeck"]', r"key friction.model: found \['stribeck'\]"),
        ('"stribeck"', '"lugre"', "key friction.stiffness: found none"),
        ('model = "stribeck"', "", "key friction.model: found none"),
        ("static = 1e-6", "static = inf", "key sigma.static: found inf"),
        ("static = 1e-6", "windage = 1.0", "key sigma.windage: found an unknown key"),
        ("static = 1e-6", '"a\\rb" = 1.0', r"key sigma.'a\\rb': found an unknown key"),
        ("[sigma]", "[sgima]", r"key sgima: .*did you mean sigma\?"),
        ("[sigma]\nstatic = 1e-6", "", ""),
        ("[wheel]", "sigma = 3\n[wheel]", "found"),
    ],
)
def test_bad_content_is_named(tmp_path, old, new, complaint):
    path = tmp_path / "model.toml"
    assert old in GOOD
    path.write_text(GOOD.replace(old, new, 1))
    if not complaint:
        assert read_model(path).sigma == {}
        return
    with pytest.raises(InputError, match=complaint) as raised:
        read_model(path)
    assert str(raised.value).startswith(f"{path}: ")


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(InputError, match="found no such file or directory, expected a model file"):
        read_model(tmp_path / "none.toml")
    (tmp_path / "latin.toml").write_bytes(b"[wheel]\n# caf\xe9")
    with pytest.raises(InputError, match="found no UTF-8 text"):
        read_model(tmp_path / "latin.toml")


def test_a_model_that_is_marked_as_impossible_is_refused_unless_forced(tmp_path):
    path = tmp_path / "model.toml"
    path.write_text(GOOD)
    good = read_model(path)
    why = 'viscous is negative (-3e-06): "no wheel" has this'
    write_model(path, WheelModel(good.friction, good.values, impossible=why))
    with pytest.raises(InputError, match=r"key validity\.impossible.*--force"):
        read_model(path)
    forced = read_model(path, force=True)
    assert forced.impossible == why
    assert forced.values == good.values
