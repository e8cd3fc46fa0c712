"""Header, source and README say what they are made from."""

import re
from pathlib import Path

import gyrostat as gs
from gyrostat.core.source_digest import source_digest
from gyrostat.wheel import WheelModel, read_model
from gyrostat.wheel.friction import Friction, ViscousCoulomb

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
VALUES = {"inertia": 1.5e-3, "motor_constant": 0.0228, "viscous": 4.8e-6, "coulomb": 8.8e-4}
OPTIONS = {"to": "c", "what": "controller", "period": 0.1, "gains": (0.1, 0.01, 0.3)}
LAW = '''
from gyrostat.core.arrays import Scalar
from gyrostat.wheel.friction.base import Friction, parameter


class Viscous(Friction):
    """F(w) = b w."""

    viscous: Scalar = parameter("viscous")

    def torque(self, speed, direction):
        """See `Friction.torque`."""
        return self.viscous * speed{}
'''


def made_from(path):
    """What the comment at the top of a file says."""
    comment = path.read_text(encoding="utf-8").partition("*/")[0]
    return dict(re.findall(r"^ +(\w+): (.+?) *$", comment, re.MULTILINE))


def test_the_same_digests_are_in_header_source_and_readme(tmp_path):
    model = WheelModel(ViscousCoulomb, VALUES)
    gs.export(model, tmp_path / "out", **OPTIONS)
    digests = made_from(tmp_path / "out" / "controller.c")
    assert digests == {
        "generator": f"gyrostat {source_digest()}",
        "model": f"SHA-256 {model.digest()}",
    }
    assert made_from(tmp_path / "out" / "controller.h") == digests
    readme = (tmp_path / "out" / "README.md").read_text(encoding="utf-8")
    assert all(f"{what}: `{text}`" in readme for what, text in digests.items())


def test_the_controller_of_a_scenario_has_the_digest_of_the_scenario(tmp_path):
    scenario = gs.read_scenario(EXAMPLES / "own_controller.toml")
    gs.export(scenario, tmp_path / "out", to="c")
    digests = made_from(tmp_path / "out" / "controller.c")
    assert digests["scenario"] == f"SHA-256 {scenario.digest()}"


def test_a_part_has_no_model(tmp_path):
    law = gs.AttitudePID(0.1, 0.01, 0.3)
    controller = gs.CurrentMode(law, 0.0228)
    gs.export(controller, tmp_path / "out", to="c", what="controller", period=0.1)
    assert made_from(tmp_path / "out" / "controller.c").keys() == {"generator"}


def test_the_digest_of_a_model_is_that_of_its_law_and_values():
    model = WheelModel(ViscousCoulomb, VALUES)
    again = WheelModel(
        ViscousCoulomb, dict(reversed(VALUES.items())), {"coulomb": 1e-6}, {"method": "batch"}
    )
    assert again.digest() == model.digest()
    others = [
        WheelModel(ViscousCoulomb, {**VALUES, name: value * (1.0 + 2.0**-52)}).digest()
        for name, value in VALUES.items()
    ]
    assert len({model.digest(), *others}) == 1 + len(VALUES)


def test_the_digest_of_a_model_changes_with_the_text_of_its_own_law(tmp_path):
    text = (
        '[wheel]\ninertia = 1e-3\nmotor_constant = 0.02\n[friction]\nmodel = "{}"\nviscous = 1e-6\n'
    )
    digests = set()
    for number, change in enumerate(("", " * 1.0")):
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / "law.py").write_text(LAW.format(change), encoding="utf-8")
        (folder / "model.toml").write_text(text.format("law.py:Viscous"), encoding="utf-8")
        digests.add(read_model(folder / "model.toml").digest())
    assert len(digests) == 2
    assert None not in digests


def test_a_law_without_a_file_has_no_digest():
    class Unknown(ViscousCoulomb):
        """F(w) = b w + sgn(w) c."""

    assert issubclass(Unknown, Friction)
    assert WheelModel(Unknown, VALUES).digest() is None
