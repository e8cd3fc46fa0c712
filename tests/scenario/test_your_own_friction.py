"""A user's friction law in a scenario: from a wheel model or in the spacecraft file."""

import contextlib
import shutil
from pathlib import Path

import pytest

import gyrostat as gs
from gyrostat.campaigns.native import trace
from gyrostat.codegen.flight.c import emit
from gyrostat.core.errors import InputError
from gyrostat.exports import scenario_controller
from gyrostat.runs.plans import designs_of
from gyrostat.scenario.kinds.events import EVENTS
from gyrostat.scenario.kinds.wheel_keys import WHEEL_ALL
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.structure import structure_of
from gyrostat.wheel import read_model, write_model
from gyrostat.wheel.friction.contract import RESERVED

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
LAW = '''
import jax.numpy as jnp
from gyrostat.wheel.friction import Friction, parameter


class Copy(Friction):
    """F(w) = b w + sgn(w) [c + (T_s - c) exp(-w^2 / w_s^2)]."""

    viscous: float = parameter("viscous")
    coulomb: float = parameter("torque")
    static: float = parameter("torque")
    stribeck_speed: float = parameter("rad/s", start=0.4)

    def torque(self, speed, direction):
        excess = (self.static - self.coulomb) * jnp.exp(-((speed / self.stribeck_speed) ** 2))
        return self.viscous * speed + direction * (self.coulomb + excess)
'''
INLINE = """inertia = "0.2 kg·cm²"
friction = { python = "mine.py:Copy", viscous = 1e-7, coulomb = "20 µN·m", static = 3e-5, \
stribeck_speed = "2 rad/s" }
"""
SCENARIO = """
[run]
duration = "5 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[start]
wheel_speed = ["2 rpm", "-20 rpm", "20 rpm", "-2 rpm"]
[controller]
kind = "three_axis"
[compensator]
kind = "friction_model"
[sensors]
attitude_sigma = "0.003 deg"
rate_sigma = "0.002 deg/s"
wheel_sigma = "2 µN·m·s"
[[event]]
name = "worn"
kind = "friction_step"
wheel = "b"
time = "2 s"
coulomb = "50 µN·m"
[[dispersion]]
key = "wheel.*.coulomb"
distribution = "log_normal"
sigma = "20 %"
"""


@pytest.fixture
def folder(tmp_path):
    """Folder with a scenario whose wheels have a law of a Python file."""
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, tmp_path / name)
    (tmp_path / "mine.py").write_text(LAW)
    (tmp_path / "scenario.toml").write_text(SCENARIO)
    return tmp_path


def spacecraft(folder, old, new, file="cubesat.toml"):
    """Change a file of the folder, which must have the text."""
    text = (folder / file).read_text()
    assert old in text
    (folder / file).write_text(text.replace(old, new))


def use_inline(folder):
    spacecraft(folder, 'model = "cubesat_wheel.toml"', INLINE)


def use_model(folder):
    spacecraft(folder, '"stribeck"', '"mine.py:Copy"', "cubesat_wheel.toml")


def test_copy_of_stribeck_flies_as_the_shipped_law(folder):
    shipped = gs.campaign(folder / "scenario.toml", runs=2, seed=1, out=folder / "shipped")
    use_model(folder)
    own = gs.campaign(folder / "scenario.toml", runs=2, seed=1, out=folder / "own")
    assert set(own) == set(shipped)
    for name in ("wheel.b.coulomb", "error_max", "error_rms"):
        assert own[name].values == pytest.approx(shipped[name].values, rel=1e-9), name


GAMMA = "jax.scipy.special.gammaln(2.5 + speed**2)"
WHILE = "jax.lax.while_loop(lambda x: jnp.max(x) > 1.0, lambda x: 0.5 * x, 3.0 + speed**2)"


@pytest.mark.parametrize(
    ("addition", "native", "export"),
    [("0.0", None, None), (GAMMA, "(lgamma)", "(lgamma)"), (WHILE, None, "(while)")],
)
def test_check_says_what_the_law_can_be_compiled_for(folder, addition, native, export):
    use_model(folder)
    text = LAW.replace("excess = ", f"nothing = 0.0 * {addition}\n        excess = nothing + ")
    (folder / "mine.py").write_text("import jax" + text)
    said = []
    scenario = gs.read_scenario(folder / "scenario.toml")
    support = gs.check(scenario, say=said.append).parts["friction"]
    for obstacle, expected in zip(support, (native, export), strict=False):
        assert (obstacle is None) == (expected is None)
        if expected is not None:
            assert expected in obstacle.operation
            assert "nothing = " in obstacle.text
    engine = "native or JAX" if native is None else "JAX only"
    assert any(line.startswith(f"  engine: {engine}") for line in said)
    compensator = scenario_controller(scenario, "hold").entries
    for refused, compile in (
        (native, lambda: trace(structure_of(scenario), designs_of(scenario), 0)),
        (export, lambda: emit("c", compensator)),
    ):
        with contextlib.nullcontext() if refused is None else pytest.raises(InputError):
            compile()


@pytest.mark.parametrize("use", [use_inline, use_model])
def test_data_of_the_law_travel_with_it(folder, use):
    use(folder)
    (folder / "factor.csv").write_text("2.0")
    head = 'import numpy as np\nFACTOR = float(np.loadtxt("factor.csv"))\n'
    (folder / "mine.py").write_text(head + LAW.replace("self.viscous *", "FACTOR * self.viscous *"))
    with pytest.raises(InputError, match=r"mine\.py:Copy, line 2: found .*factor\.csv"):
        gs.read_scenario(folder / "scenario.toml")
    old, file = {
        use_inline: ('python = "mine.py:Copy",', "cubesat.toml"),
        use_model: ('model = "mine.py:Copy"', "cubesat_wheel.toml"),
    }[use]
    data = ' data = ["factor.csv"],' if use is use_inline else '\ndata = ["factor.csv"]'
    spacecraft(folder, old, old + data, file)
    scenario = gs.read_scenario(folder / "scenario.toml")
    assert [source.path for source in scenario.sources] == ["factor.csv", "mine.py"]
    if use is use_inline:
        return
    out = folder / "copy" / "model.toml"
    out.parent.mkdir()
    write_model(out, read_model(folder / "cubesat_wheel.toml"))
    assert (out.parent / "factor.csv").read_bytes() == b"2.0"
    assert 'data = ["factor.csv"]' in out.read_text()
    law = read_model(out).friction
    torque = law(viscous=1.0, coulomb=0.0, static=0.0, stribeck_speed=1.0).torque(3.0, 1.0)
    assert float(torque) == pytest.approx(6.0)
    files = gs.export(out, folder / "fmu", to="fmu", what="wheel", period=0.01)
    assert [path.name for path in files] == ["wheel.fmu"]
    (out.parent / "factor.csv").write_text("3.0")
    with pytest.raises(InputError, match=r"factor\.csv: found a text that was edited since"):
        read_model(out)


@pytest.mark.parametrize("use", [use_inline, use_model])
def test_text_of_the_law_is_part_of_the_scenario(folder, use):
    use(folder)
    scenario = gs.read_scenario(folder / "scenario.toml")
    assert scenario.friction == "mine.py:Copy"
    assert [source.text for source in scenario.sources] == [LAW]
    assert scenario.values["wheel.a.coulomb"] == pytest.approx(2e-5)
    assert "wheel.b.coulomb" in scenario.dispersed
    again = Scenario.from_text(scenario.text())
    (folder / "mine.py").unlink()
    changed = again.replace(**{"wheel.a.coulomb": "0.03 mN·m"})
    assert changed.values["wheel.a.coulomb"] == pytest.approx(3e-5)
    assert changed.sources == scenario.sources
    # sources without any part of the user's are dropped with the last one, but not those of a law
    assert again.replace(controller="three_axis").sources == scenario.sources


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"20 µN·m"', '"-20 µN·m"', "key wheel\\[a\\].friction: coulomb: found -2e-05"),
        ('"2 rad/s"', '"2 N·m"', "friction.stribeck_speed '2 N·m': found unit 'N·m'"),
        ("viscous = 1e-7, ", "", "friction.viscous: found none, expected it, in N·m·s/rad"),
        ("viscous", "drag", "friction.drag: found an unknown key"),
        ("mine.py:Copy", "mine.py:Nope", "mine.py: found no Nope, expected one of Copy"),
        ("mine.py:Copy", "other.py:Copy", "friction.python: .*other.py: found no such file"),
        ('python = "mine.py:Copy", ', "", "found a table, expected a table with kind or python"),
        ('python = "mine.py:Copy"', 'kind = "nope"', "friction.kind: found 'nope', expected one"),
        ("friction =", 'model = "cubesat_wheel.toml"\nfriction =', "found it beside model"),
    ],
)
def test_wrong_friction_in_a_spacecraft_file_is_refused_in_one_line(folder, old, new, message):
    use_inline(folder)
    text = (folder / "cubesat.toml").read_text()
    assert old in text
    (folder / "cubesat.toml").write_text(text.replace(old, new))
    with pytest.raises(InputError, match=message) as caught:
        gs.read_spacecraft(folder / "cubesat.toml")
    assert "\n" not in str(caught.value)


def test_shipped_law_can_stand_in_the_spacecraft_file(folder):
    use_inline(folder)
    spacecraft(folder, 'python = "mine.py:Copy"', 'kind = "stribeck"')
    wheels = gs.read_spacecraft(folder / "cubesat.toml").spacecraft.wheels
    assert type(wheels.friction) is gs.Stribeck
    assert wheels.friction.static == pytest.approx([3e-5] * 4)


def test_law_that_drives_a_wheel_is_refused_with_its_place(folder):
    use_inline(folder)
    (folder / "mine.py").write_text(LAW.replace("direction * (self.c", "-direction * (self.c"))
    with pytest.raises(InputError, match=r"cubesat.toml: key wheel\[a\].friction: Copy: found "):
        gs.check(folder / "scenario.toml")


def test_check_names_the_law_and_says_that_it_never_sticks(folder):
    use_inline(folder)
    lines: list[str] = []
    gs.check(folder / "scenario.toml", say=lines.append)
    assert "friction: mine.py:Copy" in lines
    spacecraft(folder, "static = 3e-5", "static = 0")
    spacecraft(folder, '"20 µN·m"', "0")
    lines.clear()
    # a share of zero is no dispersion
    spacecraft(folder, "log_normal", "normal", "scenario.toml")
    spacecraft(folder, '"20 %"', '"1 µN·m"', "scenario.toml")
    gs.check(folder / "scenario.toml", say=lines.append)
    assert "friction: mine.py:Copy, no friction at rest: the wheels never stick" in lines


def test_parameter_of_a_law_cannot_have_the_name_of_another_key_of_a_wheel_or_an_event():
    events = (
        EVENTS["friction_step"].keys_of(gs.Stribeck, None, {}).keys() - gs.Stribeck.dimensions()
    )
    assert {*WHEEL_ALL, *events} <= RESERVED


def test_two_laws_of_the_same_file_name_are_refused(folder):
    use_inline(folder)
    (folder / "own").mkdir()
    (folder / "own" / "mine.py").write_text("def torque(craft, attitude, time):\n    return 0\n")
    shutil.move(folder / "scenario.toml", folder / "own" / "scenario.toml")
    spacecraft(folder / "own", '"cubesat.toml"', '"../cubesat.toml"', "scenario.toml")
    with (folder / "own" / "scenario.toml").open("a") as file:
        file.write('[[environment.torque]]\npython = "mine.py:torque"\n')
    with pytest.raises(InputError, match=r"found two different files mine.py, expected"):
        gs.read_scenario(folder / "own" / "scenario.toml")
