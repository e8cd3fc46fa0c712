"""spacecraft.toml: what it says is what is built, and a wrong key is named."""

from pathlib import Path

import numpy as np
import pytest

import gyrostat.wheel
from gyrostat.core.errors import InputError
from gyrostat.spacecraft import read_spacecraft
from gyrostat.wheel import WheelModel, read_model, write_model
from gyrostat.wheel.friction import FRICTION_MODELS

EXAMPLE = Path(__file__).parents[2] / "examples" / "three_wheels.toml"
SHIPPED = Path(gyrostat.wheel.__file__).with_name("data_sheets")
GOOD = """
[body]
inertia = [[8.0, 0.5, 0.0], [0.5, "12 kg·m²", 0.0], [0.0, 0.0, "160000 kg·cm²"]]
[[wheel]]
name = "a"
axis = [0, 3, 4]
inertia = "15 g·m²"
torque_limit = "100 mN·m"
[[wheel]]
name = "b"
axis = [1, 1, 1]
inertia = 0.02
momentum_limit = "3 Nms"
"""


def written(folder, text):
    path = folder / "craft.toml"
    path.write_text(text)
    return path


def test_the_example():
    found = read_spacecraft(EXAMPLE)
    assert (found.name, found.wheel_names) == ("three wheels", ("x", "y", "z"))
    craft = found.spacecraft
    np.testing.assert_array_equal(craft.inertia, np.diag([12.0, 12.0, 12.0]))
    np.testing.assert_array_equal(craft.wheels.axes, np.eye(3))
    np.testing.assert_array_equal(craft.wheels.torque_limit, np.full(3, 0.1))
    np.testing.assert_array_equal(craft.wheels.momentum_limit, np.full(3, 3.0))
    assert found.wheel_number("z", "--failed") == 2
    with pytest.raises(InputError, match=r"--failed: found no wheel 'w', expected one of x, y, z"):
        found.wheel_number("w", "--failed")


def test_units_matrix_and_directions(tmp_path):
    craft = read_spacecraft(written(tmp_path, GOOD)).spacecraft
    expected = [[8.0, 0.5, 0.0], [0.5, 12.0, 0.0], [0.0, 0.0, 16.0]]
    np.testing.assert_allclose(craft.inertia, expected, rtol=1e-15)
    np.testing.assert_allclose(craft.wheels.axes.T, [[0.0, 0.6, 0.8], np.ones(3) / np.sqrt(3.0)])
    np.testing.assert_allclose(craft.wheels.inertia, [0.015, 0.02])
    np.testing.assert_allclose(craft.wheels.torque_limit, [0.1, np.inf])
    np.testing.assert_allclose(craft.wheels.momentum_limit, [np.inf, 3.0])


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("[body]", "[bodi]", r"key bodi: .*did you mean body\?"),
        ("[body]", "[wheels]\n[body]", r"key wheels: .*did you mean wheel\?"),
        ("torque_limit", "torque_limits", r"key wheel\[a\].torque_limits: .*did you mean"),
        ("inertia = [[", "inertias = [[", r"key body.inertias: .*did you mean body.inertia\?"),
        ('inertia = "15 g·m²"', "", r"key wheel\[a\].inertia: found none, expected it in kg·m²"),
        ('"15 g·m²"', '"15 rpm"', r"wheel\[a\].inertia .*found unit 'rpm', expected a unit of"),
        ('"15 g·m²"', "0.0", r"wheel\[a\].inertia: found 0.0, expected a number above 0"),
        ('"15 g·m²"', "true", r"wheel\[a\].inertia: found True"),
        ("[0, 3, 4]", "[0, 0, 0]", r"wheel\[a\].axis: found zero, expected a direction"),
        ("[0, 3, 4]", "[0, 3]", r"wheel\[a\].axis: found 2 values, expected three numbers"),
        ("[0, 3, 4]", '[0, 3, "up"]', r"wheel\[a\].axis\[2\]: found 'up'"),
        ("[0, 3, 4]", "[0, nan, 4]", r"wheel\[a\].axis\[1\]: found nan"),
        ("[[8.0, 0.5, 0.0]", "[[8.0, 0.4, 0.0]", "body.inertia: .*not symmetric"),
        ("[[8.0, 0.5, 0.0]", "[[8.0, 0.5]", r"body.inertia\[0\]: found 2 values"),
        ("[[8.0, 0.5, 0.0]", "[[2.0, 0.5, 0.0]", "body.inertia: .*none larger than the sum"),
        ('name = "b"', 'name = "a"', r"wheel\[1\].name: found 'a' twice"),
        ('name = "b"', "", r"wheel\[1\].name: found none"),
        ('name = "b"', 'name = "b=1"', r"wheel\[1\].name: found 'b=1'"),
        ('name = "b"', "name = 3", r"wheel\[1\].name: found 3, expected a text"),
        ('"3 Nms"', '"3 Nm"', r"wheel\[b\].momentum_limit .*expected a unit of momentum"),
        ('"3 Nms"', "-3", r"wheel\[b\].momentum_limit: found -3"),
        ('"3 Nms"', '3\nmodel = "no.toml"', "no.toml: found no such file"),
        ("[body]", "body = 3\n[body]", "invalid TOML"),
    ],
)
def test_bad_content_is_named(tmp_path, old, new, complaint):
    assert old in GOOD
    path = written(tmp_path, GOOD.replace(old, new, 1))
    with pytest.raises(InputError, match=complaint) as raised:
        read_spacecraft(path)
    assert str(raised.value).startswith(str(tmp_path))
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("text", ["", "[body]\ninertia = [1, 1, 1]", "wheel = 3\n[body]\n"])
def test_what_has_no_body_or_no_wheels(tmp_path, text):
    with pytest.raises(InputError, match=r"key (body|wheel): found .*, expected"):
        read_spacecraft(written(tmp_path, text))


def with_models(folder, *kinds, inertia=0.015):
    """A file whose wheels have a model of each kind, and no inertia of their own."""
    text = ["[body]", "inertia = [12, 12, 12]"]
    for k, kind in enumerate(kinds):
        text += ["[[wheel]]", f'name = "w{k}"', "axis = [0, 0, 1]"]
        if kind is None:
            text.append("inertia = 0.015")
            continue
        friction = FRICTION_MODELS[kind]
        values = dict.fromkeys(friction.dimensions(), 0.001 * (k + 1))
        (folder / f"{k}").mkdir(exist_ok=True)
        known = {"motor_constant": 0.02, "inertia": inertia, **values}
        write_model(folder / f"{k}" / "model.toml", WheelModel(friction, known))
        text.append(f'model = "{k}/model.toml"')
    return "\n".join(text) + "\n"


def test_identified_wheels_bring_their_friction_and_inertia(tmp_path):
    text = with_models(tmp_path, "stribeck", "stribeck")
    wheels = read_spacecraft(written(tmp_path, text)).spacecraft.wheels
    np.testing.assert_array_equal(wheels.inertia, [0.015, 0.015])
    assert wheels.friction.name == "stribeck"
    np.testing.assert_array_equal(wheels.friction.coulomb, [0.001, 0.002])


def test_models_that_do_not_fit_together(tmp_path):
    for kinds, complaint in (
        (("stribeck", None), r"wheel\[w1\].model: found none, expected one for every wheel"),
        (("stribeck", "viscous-coulomb"), "found viscous-coulomb friction, expected stribeck"),
    ):
        with pytest.raises(InputError, match=complaint):
            read_spacecraft(written(tmp_path, with_models(tmp_path, *kinds)))
    text = with_models(tmp_path, "stribeck").replace("axis", "inertia = 0.0015\naxis")
    with pytest.raises(
        InputError, match=r"found 0.0015 kg·m², expected the 0.015 kg·m² of 0/model"
    ):
        read_spacecraft(written(tmp_path, text))


def test_wheels_marked_as_impossible(tmp_path):
    """Refused; with force those are accepted that can be simulated, and the others are named."""
    path = written(tmp_path, with_models(tmp_path, "stribeck", "stribeck"))
    model = tmp_path / "1" / "model.toml"
    good = read_model(model)
    for changes, named in (
        ({"static": 1e-4}, ""),
        ({"motor_constant": -0.02}, ""),
        ({"coulomb": -1e-4}, r"key wheel\[w1\]\.model: coulomb: found -0\.0001, expected"),
    ):
        bad = WheelModel(good.friction, {**good.values, **changes}, impossible="no wheel has this")
        write_model(model, bad)
        with pytest.raises(InputError, match=r"1/model\.toml: key validity\.impossible: .*--force"):
            read_spacecraft(path)
        if named:
            with pytest.raises(InputError, match=named):
                read_spacecraft(path, force=True)
        else:
            assert read_spacecraft(path, force=True).spacecraft.wheels.count == 2


SHEETS = """
[body]
inertia = [0.12, 0.10, 0.06]
[[wheel]]
name = "a"
axis = [1, 0, 0]
sheet = "bct-rwp015"
[[wheel]]
name = "b"
axis = [0, 1, 0]
sheet = "own.toml"
torque_limit = "2 mN·m"
"""


def test_a_data_sheet_gives_what_the_file_leaves_out(tmp_path):
    own = (SHIPPED / "bct-rwp015.toml").read_text(encoding="utf-8")
    text = own.replace('"0.05 mN·m"', '"0.07 mN·m"')
    (tmp_path / "own.toml").write_text(text, encoding="utf-8")
    wheels = read_spacecraft(written(tmp_path, SHEETS)).spacecraft.wheels
    np.testing.assert_allclose(wheels.torque_limit, [0.004, 0.002])
    np.testing.assert_allclose(wheels.momentum_limit, [0.015, 0.015])
    np.testing.assert_allclose(wheels.inertia, 2.38732e-5)
    assert wheels.friction.name == "viscous-coulomb"
    np.testing.assert_allclose(wheels.friction.coulomb, [5e-5, 7e-5])


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('"bct-rwp015"', '"bct-rwp15"', r"wheel\[a\].sheet: .*did you mean bct-rwp015"),
        ('"bct-rwp015"', "15", r"wheel\[a\].sheet: found 15"),
        ('"own.toml"', '"sunspace-0.65"', r"wheel\[b\].model: found stribeck friction"),
        ('sheet = "own.toml"', "inertia = 1.0", r"wheel\[b\].model: found none"),
        ('"own.toml"', '"none.toml"', r"wheel\[b\].sheet: .*none.toml"),
    ],
)
def test_a_sheet_that_does_not_fit_is_refused(tmp_path, old, new, complaint):
    with pytest.raises(InputError, match=complaint):
        read_spacecraft(written(tmp_path, SHEETS.replace(old, new)))


OUTSIDE = """
[box]
size = ["20 cm", "10 cm", 0.3]
centre = [0, "50 mm", 0]
specular = 0.1
[[panel]]
name = "wing"
size = ["60 cm", "30 cm"]
normal = [0, 0, 2]
centre = [0, "0.4 m", 0]
diffuse = 0.25
[[facet]]
name = "lid"
area = "50 cm²"
normal = [1, 1, 0]
centre = [0.1, 0.1, 0.1]
specular = 0.6
diffuse = 0.4
"""
HEAVY = GOOD.replace("[body]", '[body]\nmass = "12000 g"\ncentre_of_mass = ["1 mm", 0, -0.002]')


def test_a_file_without_mass_and_surfaces_leaves_them_out(tmp_path):
    craft = read_spacecraft(written(tmp_path, GOOD)).spacecraft
    assert (craft.mass, craft.centre_of_mass, craft.surfaces) == (None, None, None)


def test_mass_and_surfaces(tmp_path):
    craft = read_spacecraft(written(tmp_path, HEAVY + OUTSIDE)).spacecraft
    assert craft.mass == pytest.approx(12.0, rel=1e-15)
    np.testing.assert_allclose(craft.centre_of_mass, [0.001, 0.0, -0.002], rtol=1e-15)
    found = craft.surfaces
    # faces of the box: +x, -x, +y, -y, +z, -z
    area = [0.03, 0.03, 0.06, 0.06, 0.02, 0.02, 0.18, 0.18, 0.005]
    np.testing.assert_allclose(found.area, area, rtol=1e-14)
    half = np.sqrt(0.5)
    normal = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 1], [half, half, 0]]
    np.testing.assert_allclose(found.normal[[0, 2, 4, 6, 8]], normal, atol=1e-15)
    np.testing.assert_allclose(found.normal[[1, 3, 5, 7]], -np.array(normal[:4]), atol=1e-15)
    centre = [[0.1, 0.05, 0], [0, 0, 0], [0, 0.05, -0.15], [0, 0.4, 0], [0, 0.4, 0], [0.1] * 3]
    np.testing.assert_allclose(found.centre[[0, 3, 5, 6, 7, 8]], centre, atol=1e-15)
    np.testing.assert_allclose(found.specular, [0.1] * 6 + [0.0, 0.0, 0.6])
    np.testing.assert_allclose(found.diffuse, [0.0] * 6 + [0.25, 0.25, 0.4])
    facets = craft.facets("a part")
    np.testing.assert_allclose(facets.centre, found.centre - [0.001, 0.0, -0.002])


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('"12000 g"', '"12 m"', r"body.mass .*expected a unit of mass: kg, g"),
        ('"12000 g"', "0", r"body.mass: found 0, expected a number above 0"),
        ('["1 mm", 0, -0.002]', "[0, 0]", r"body.centre_of_mass: found 2 values"),
        ("[box]", "[box]\nlength = 3", r"key box.length: found an unknown key"),
        ("[box]", "[[box]]", r"key box: found 1 values, expected a table \[box\]"),
        ('size = ["20 cm", "10 cm", 0.3]', "", r"box.size: found none, expected three"),
        ('"10 cm", 0.3', '"10 cm", 0', r"box.size\[2\]: found 0, expected a number above 0"),
        ("[[panel]]", "[panel]", r"key panel: found a table, expected tables \[\[panel\]\]"),
        ('"wing"', '"big wing"', r"panel\[0\].name: found 'big wing', expected a name without"),
        ("[0, 0, 2]", "[0, 0, 0]", r"panel\[wing\].normal: found zero, expected a direction"),
        ('size = ["60 cm", "30 cm"]', "", r"panel\[wing\].area: found none of area and size"),
        ("diffuse = 0.25", "area = 1", r"panel\[wing\].area: found both of area and size"),
        ('["60 cm", "30 cm"]', '"60 cm"', r"panel\[wing\].size: found '60 cm', expected two"),
        ('"50 cm²"', '"50 cm"', r"facet\[lid\].area .*expected a unit of area: m², cm², mm²"),
        ("diffuse = 0.4", "diffuse = 0.5", r"facet\[lid\].diffuse: found the sum 1.1 with spec"),
        ("diffuse = 0.4", "diffuse = -0.4", r"facet\[lid\].diffuse: found -0.4, expected 0 to 1"),
        ("diffuse = 0.4", "difuse = 0.4", r"facet\[lid\].difuse: .*did you mean"),
    ],
)
def test_bad_masses_and_surfaces_are_named(tmp_path, old, new, complaint):
    assert old in HEAVY + OUTSIDE
    path = written(tmp_path, (HEAVY + OUTSIDE).replace(old, new, 1))
    with pytest.raises(InputError, match=complaint) as raised:
        read_spacecraft(path)
    assert str(raised.value).startswith(str(tmp_path))
    assert "\n" not in str(raised.value)


FLEXIBLE = """
[[flexible]]
name = "wing"
frequency = "500 mHz"
participation = [1.5, 0.2, 0.0]
[[slosh]]
name = "tank"
frequency = 0.4
damping = 0.02
mass = "20 kg"
position = [0.0, 0.0, "30 cm"]
direction = [2.0, 0.0, 0.0]
[[hinged_panel]]
name = "panel"
frequency = "0.2 Hz"
mass = 2
inertia = [0.01, 0.1, 0.11]
hinge = ["0.5 m", 0.0, 0.0]
centre = ["1.5 m", 0.0, 0.0]
axis = [0.0, 3.0, 0.0]
"""
MASSIVE = GOOD.replace("[body]", '[body]\nmass = "200 kg"\ncentre_of_mass = [0, 0, "10 cm"]')


def test_appendages_are_modes(tmp_path):
    modes = read_spacecraft(written(tmp_path, MASSIVE + FLEXIBLE)).modes
    # in the order of kinds: flexible, hinged_panel, slosh
    np.testing.assert_allclose(modes.frequency / (2.0 * np.pi), [0.5, 0.2, 0.4])
    np.testing.assert_allclose(modes.damping, [0.0, 0.0, 0.02])
    hinge = 0.1 + 2.0  # kg·m², of the panel about its hinge
    panel = 2.0 * np.cross([1.5, 0.0, -0.1], [0.0, 0.0, -1.0]) + [0.0, 0.1, 0.0]
    tank = np.sqrt(20.0) * np.cross([0.0, 0.0, 0.2], [1.0, 0.0, 0.0])
    wanted = [[1.5, 0.2, 0.0], panel / np.sqrt(hinge), tank]
    np.testing.assert_allclose(modes.participation, wanted)
    moved = [np.zeros(3), [0.0, 0.0, -2.0 / np.sqrt(hinge * 200.0)], [np.sqrt(0.1), 0.0, 0.0]]
    np.testing.assert_allclose(modes.translation, moved)
    assert read_spacecraft(written(tmp_path, MASSIVE)).modes is None


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (GOOD + FLEXIBLE, r"craft.toml: hinged_panel\[panel\]: found a spacecraft without mass"),
        (FLEXIBLE.replace("[2.0,", "[0.0,"), r"slosh\[tank\]\.direction: found zero"),
        (FLEXIBLE.replace("= 0.02", "= -0.02"), r"slosh\[tank\]\.damping: found -0\.02"),
        (FLEXIBLE.replace("[1.5, 0.2,", "[9.5, 0.2,"), "kg·m² as least inertia of the body"),
        (FLEXIBLE.replace('"20 kg"', '"250 kg"'), "of the mass of the spacecraft"),
        (FLEXIBLE.replace("[0.01, 0.1, 0.11]", "[0.01, 0.1]"), r"panel\]\.inertia: found 2 values"),
        (FLEXIBLE.replace('"500 mHz"', "0"), r"flexible\[wing\]\.frequency: found 0"),
        (FLEXIBLE.replace('"wing"', '"a.b"'), "found 'a.b', expected no dot"),
        (FLEXIBLE.replace("position", "place"), r"slosh\[tank\]\.place: found an unknown key"),
    ],
)
def test_appendages_that_cannot_be(tmp_path, text, found):
    text = text if "[body]" in text else MASSIVE + text
    with pytest.raises(InputError, match=found):
        read_spacecraft(written(tmp_path, text))
