"""[reference] of a scenario: read, refused in one line, and the same in both engines."""

import shutil
from pathlib import Path

import equinox as eqx
import numpy as np
import pytest

from gyrostat.control.guidance import Mode, Reference
from gyrostat.core.errors import InputError
from gyrostat.core.rotations import error_angle
from gyrostat.runs import plans
from gyrostat.runs.plans import plans_of
from gyrostat.scenario import Scenario
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario_files.scenario_file import read_scenario

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
HEAD = """
[run]
duration = "60 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[controller]
kind = "three_axis"
"""
SLEWS = """
[reference]
kind = "slews"
rate = "auto"
[[reference.slew]]
name = "there"
time = "5 s"
target = [0.0, 0.6, 0.0, 0.8]
[[reference.slew]]
name = "back"
time = "40 s"
target = [1.0, 0.0, 0.0, 0.0]
"""
OWN = """import jax.numpy as jnp


class Turn:
    rate: float = 0.01

    def __call__(self, time):
        half = 0.5 * self.rate * time
        return jnp.array([jnp.cos(half), 0.0, 0.0, jnp.sin(half)])


def profile(time):
    return jnp.zeros(3)


def nothing(time):
    return jnp.zeros(4)
"""
TABLE = "time,q0,q1,q2,q3\n" + "".join(
    f"{t},{np.cos(0.005 * t)},0,0,{np.sin(0.005 * t)}\n" for t in range(0, 61, 5)
)


@pytest.fixture
def written(tmp_path):
    """Write a scenario with a reference beside the cubesat."""

    def write(text, head=HEAD):
        for name in ("cubesat.toml", "cubesat_wheel.toml"):
            shutil.copy(EXAMPLES / name, tmp_path)
        (tmp_path / "mission.py").write_text(OWN)
        (tmp_path / "pass.csv").write_text(TABLE)
        (tmp_path / "short.csv").write_text("\n".join(TABLE.splitlines()[:8]))
        (tmp_path / "bad.csv").write_text(TABLE.replace("5,", "5,x,", 1))
        path = tmp_path / "scenario.toml"
        path.write_text(head + text)
        return path

    return write


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[reference]\nkind = "slews"\n', "found slews without tables [[reference.slew]]"),
        ('[reference]\nkind = "sequence"\n', "found sequence without tables [[reference.mode]]"),
        (
            SLEWS.replace('"slews"', '"fixed"').replace('rate = "auto"', ""),
            "found fixed with tables [[reference.slew]]",
        ),
        (SLEWS.replace("0.6, 0.0", "0.7, 0.0"), "reference.slew[there].target"),
        (SLEWS.replace('"40 s"', '"4 s"'), "a time after the slew before, 5 s"),
        (SLEWS.replace('"40 s"', '"90 s"'), "before the end of the run, 60 s"),
        (SLEWS.replace('"back"', '"there"'), "another name"),
        (SLEWS.replace('rate = "auto"', 'rate = "0 deg/s"'), "above 0"),
        (SLEWS.replace('rate = "auto"', "torque_share = 1.5"), "at most 1"),
        ('[reference]\nkind = "nadir"\n', "reference.altitude: found none"),
        (
            '[reference]\nkind = "nadir"\naltitude = 5e5\nalong = [0.0, 0.0, 2.0]\n',
            "found parallel body axes",
        ),
        ('[reference]\nkind = "table"\nfile = "bad.csv"\n', "bad.csv, line"),
        ('[reference]\nkind = "table"\nfile = "no.csv"\n', "no.csv"),
        ('[reference]\nkind = "table"\nfile = "short.csv"\n', "from 0 s to 30 s, expected"),
        ('[reference]\npython = "mission.py:profile"\n', "found shape (3,) of attitude"),
        (
            '[reference]\npython = "mission.py:nothing"\n',
            "reference mission.py:nothing: found command.torque with NaN",
        ),
        ('[[event]]\nkind = "slew"\ntime = "9 s"\ntarget = [1, 0, 0, 0]\n' + SLEWS, "event[1]"),
    ],
)
def test_mistakes_are_one_line(written, text, message):
    with pytest.raises(InputError) as caught:
        read_scenario(written(text))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "scenario.toml" in str(caught.value) or ".csv" in str(caught.value)


def test_a_target_beside_a_reference_and_two_wheels_are_refused(written):
    head = HEAD + "target = [1.0, 0.0, 0.0, 0.0]\n"
    with pytest.raises(InputError, match=r"controller.target: found a target attitude beside"):
        read_scenario(written(SLEWS, head))
    nadir = '[reference]\nkind = "nadir"\naltitude = 5e5\n'
    with pytest.raises(InputError, match="found two_wheels with the reference nadir"):
        read_scenario(written(nadir, HEAD.replace("three_axis", "two_wheels")))


def test_a_reference_given_in_python_is_validated_too(written):
    scenario = read_scenario(written(""))
    for kind, message in (
        ("slews", "without tables"),
        ("table", "found none, expected the name of a file"),
    ):
        with pytest.raises(InputError, match=message):
            scenario.replace(reference=kind)


def reference_of(scenario):
    values = {key: np.asarray(value) for key, value in scenario.values.items()}
    # the program that has checked the scenario when it was read
    made = plans._build(structure_of(scenario), values, plans_of(scenario))
    return made.reference


def test_tables_own_profiles_and_nadir_of_the_environment(written):
    """All three are copied by the text of the scenario."""
    table = read_scenario(written('[reference]\nkind = "table"\nfile = "pass.csv"\n'))
    own = read_scenario(written('[reference]\npython = "mission.py:Turn"\n'))
    orbit = '[environment]\nkind = "orbit"\naltitude = 7e5\n[reference]\nkind = "nadir"\n'
    nadir = read_scenario(written(orbit))
    assert nadir.values["reference.altitude"] == 7e5
    assert own.values["reference.rate"] == 0.01
    for scenario in (table, own, nadir):
        assert Scenario.from_text(scenario.text()).digest() == scenario.digest()
    at = eqx.filter_jit(Reference.at)
    found = [
        at(reference_of(Scenario.from_text(s.text())), Mode(0, 0.0), 23.0) for s in (table, own)
    ]
    assert error_angle(found[0].attitude, found[1].attitude) < 1e-9
    np.testing.assert_allclose(found[0].rate, [0.0, 0.0, 0.01], atol=1e-9)


def test_slews_are_within_the_wheels_and_their_numbers_are_keys(written):
    scenario = read_scenario(written(SLEWS))
    assert scenario.values["reference.slew.there.time"] == 5.0
    assert scenario.values["reference.slew.there.target.3"] == 0.8
    assert scenario.values["reference.rate"] == np.inf
    profiles = reference_of(scenario).modes[0].profiles
    # 4 wheels of 1 mN·m and 10 mN·m·s in a pyramid
    limit = 0.8e-3 * 4.0 / np.sqrt(3.0) / 0.06
    assert np.all(profiles.acceleration <= limit)
    assert np.all(profiles.duration < 35.0)
