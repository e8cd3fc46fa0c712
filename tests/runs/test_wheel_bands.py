"""Bands of wheel speeds and wear in a scenario: read, given to the controller, refused."""

from pathlib import Path

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.core.units import RPM
from gyrostat.runs.build import build
from gyrostat.runs.designs import plan
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario_files.scenario_file import read_scenario

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
WEAR = "[wear]\nwear = [1.0, 3.0, 1.0, 1.0]\n"
DISPERSED = """
[[dispersion]]
key = "controller.band.resonance.above"
distribution = "normal"
sigma = "20 rpm"
"""


@pytest.fixture
def variant(tmp_path):
    """Write the scenario of a stiff wheel with parts replaced."""

    def make(*changes, more=""):
        for name in ("cubesat.toml", "cubesat_wheel.toml"):
            (tmp_path / name).write_text((EXAMPLES / name).read_text())
        text = (EXAMPLES / "stiff_wheel.toml").read_text()
        for old, new in changes:
            assert old in text
            text = text.replace(old, new, 1)
        (tmp_path / "stiff_wheel.toml").write_text(text + more)
        return tmp_path / "stiff_wheel.toml"

    return make


def test_bands_and_wear_reach_the_controller(variant):
    scenario = read_scenario(variant(more=WEAR + DISPERSED))
    assert scenario.values["controller.band.zero.above"] == 0.0
    assert "controller.band.resonance.above" in scenario.dispersed
    made = build(structure_of(scenario), scenario.values, plan(scenario))
    law = made.controller.controller.controller.plans
    np.testing.assert_allclose(law.wear.given, [[1.0, 3.0, 1.0, 1.0]])
    np.testing.assert_allclose(law.wear.time, 200.0)
    np.testing.assert_allclose(law.null_space.clearance, 150.0 * RPM * 2e-5)
    ends = np.array([[2000.0, 2200.0], [0.0, 100.0]])[:, :, None] * np.ones(4) * RPM * 2e-5
    np.testing.assert_allclose(law.null_space.bands[0], ends, rtol=1e-12)
    np.testing.assert_allclose(made.plant.friction_steps.duration, [0.0, 2000.0, 0.0, 0.0])


LAST = '[[wheel]]\nname = "d"'
ARRAY = """kind = "wheel_array"
turn_gain = 0.1
rate_gain = 0.4
clearance = "150 rpm"
"""
LQR = (f'{ARRAY}wear_time = "200 s"', 'kind = "lqr"')
SAME = ("", "")


@pytest.mark.parametrize(
    ("change", "more", "found"),
    [
        (LQR, "", "key controller.band: found it with the controller lqr, expected a wheel_"),
        (('below = "100 rpm"', ""), "", "key controller.band[zero].below: found none, expected"),
        (
            ('below = "2200 rpm"', "below = 2"),
            "",
            "key controller.band[resonance].below: found 2 rad/s, expected more than above, 209.44",
        ),
        (('"2000 rpm"\nbelow', '"-5 rpm"\nbelow'), "", "above: found '-5 rpm', expected 0 or more"),
        (('name = "zero"', 'name = "resonance"'), "", "expected another name than that of another"),
        (('"150 rpm"', "0.0"), "", "key controller.clearance: found 0.0, expected above 0"),
        (('"200 s"', "-1.0"), "", "key controller.wear_time: found -1.0, expected above 0"),
        (('"2000 s"', "-1.0"), "", "key event[stiff].rise_time: found -1.0, expected 0 or more"),
        (SAME, "[wear]\nwear = [1.0, 3.0]\n", "found 2 values"),
        (SAME, "[wear]\nwear = 0.0\n", "wear: found 0.0, expected abo"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(variant, change, more, found):
    with pytest.raises(InputError) as refused:
        read_scenario(variant(change, more=more))
    message = str(refused.value)
    assert found in message
    assert "stiff_wheel.toml" in message
    assert "\n" not in message


def test_three_wheels_have_no_null_space_to_keep_out_of_bands(variant):
    path = variant(('["2230 rpm", "-1410 rpm", "990 rpm", "-170 rpm"]', "0.0"))
    craft = path.with_name("cubesat.toml")
    craft.write_text(craft.read_text().partition(LAST)[0])
    with pytest.raises(
        InputError, match=r"key controller.band: found 3 wheels, which have no null"
    ):
        read_scenario(path)
