"""Modes that branch: read, checked on their graph, and flown alike by both engines."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.core.errors import InputError
from gyrostat.scenario.mode_graph import check_modes, edges, late_changes
from gyrostat.scenario_files.scenario_file import read_scenario

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
TEXT = """
[run]
duration = "60 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[start]
rate = ["1.5 deg/s", "-1 deg/s", "0.8 deg/s"]
[controller]
kind = "three_axis"
[[controller.law]]
name = "soft"
kind = "three_axis"
rate_gain = 0.3
[reference]
kind = "sequence"
rate = "0.7 deg/s"
[[reference.mode]]
name = "safe"
kind = "fixed"
target = [1, 0, 0, 0]
law = "soft"
minimum_dwell = "5 s"
[[reference.mode]]
name = "science"
kind = "fixed"
target = [0.0, 0.6, 0.0, 0.8]
[[reference.transition]]
to = "science"
rate_below = "0.3 deg/s"
held = "2 s"
[[reference.transition]]
to = "safe"
at = "30 s"
"""


OWN = """
from typing import NamedTuple
import equinox as eqx
import jax.numpy as jnp

class Late(eqx.Module):
    after: float = 0.0

    def __call__(self, measurement, time):
        return time - self.after - 1e3 * jnp.minimum(measurement.rate[2], 0.0)
"""
LAW = """
class Law(eqx.Module):
    def start(self, period):
        return ()

    def __call__(self, memory, measurement):
        return memory, Command(LOOP * jnp.ones(4))

class Command(NamedTuple):
    torque: jnp.ndarray
"""
AT = 'at = "30 s"'
LATE = 'python = "own.py:Late"\nafter = 2.1'
BACK = {'duration = "60 s"': 'duration = "4 s"', "0.3 deg/s": "5 deg/s", AT: LATE}
BACK |= {'held = "2 s"': 'held = "1 s"', 'dwell = "5 s"': 'dwell = "0.5 s"'}


MODES = """
#include <stdio.h>
#include "controller_vectors.h"

int main(void)
{
    for (int row = 0; row < VECTOR_ROWS; row++) {
        if (vector_prepare(row) != 0 || vector_step() != 0) { return 1; }
        printf("%d", (int)vector.command.mode);
    }
    return 0;
}
"""


@pytest.fixture
def scenario(tmp_path):
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, tmp_path)

    def write(changes=(), own=OWN):
        (tmp_path / "own.py").write_text(own)
        path = tmp_path / "scenario.toml"
        text = TEXT
        for was, now in dict(changes).items():
            assert was in text
            text = text.replace(was, now, 1)
        path.write_text(text)
        return path

    return write


def test_both_engines_take_the_same_changes(scenario):
    """The way back is a condition of the user's Python."""
    path = scenario(BACK)
    said = []
    gs.check(path, say=said.append)
    assert "  engine: native or JAX; export to C: yes" in said
    runs = [gs.simulate(path, engine=engine) for engine in ("native", "jax")]
    for name in ("attitude", "rate", "torque", "wheel_speed", "target", "mode", "mode_start"):
        one, other = (np.asarray(run[name]) for run in runs)
        np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-10, err_msg=name)
    modes = np.asarray(runs[0]["mode"])
    # into the mode after the hold and the dwell, back from the first sample after 2.1 s on
    assert list(modes[:10]) == [0.0] * 5 + [1.0] * 4 + [0.0]
    assert float(runs[0].attrs["change.to_science"]) == 1.0
    assert float(runs[0].attrs["change.to_safe"]) == 1.0
    times = [float(runs[0].attrs[f"mode.{name}.time"]) for name in ("safe", "science")]
    assert times == pytest.approx([3.0, 1.0])


def test_exported_c_steps_as_in_python(scenario, tmp_path, tools):
    """To the other mode, and back by a condition of the user."""
    out = tmp_path / "flight"
    gs.export(read_scenario(scenario(BACK)), out, to="c")
    (out / "modes.c").write_text(MODES)
    tools.build(out, "-c", "controller.c")
    done = []
    for name in ("controller_test.c", "modes.c"):
        tools.build(out, "controller.o", name, "-lm", "-o", "program")
        done.append(subprocess.run([out / "program"], capture_output=True, text=True))
        assert done[-1].returncode == 0, done[-1].stdout
    assert "command.mode_change: as in Python" in done[0].stdout
    assert done[1].stdout.startswith("0000011110")


@pytest.mark.parametrize(
    ("result", "message"),
    [
        ("jnp.ones(2) * time", "found shape (2,) of condition, a number above 0 while it holds"),
        ("jnp.nan * time", "found the condition nan at the first sample, expected a finite number"),
        ("1.0 if time > 2.0 else 0.0", "expected jnp.where(condition, a, b)"),
    ],
)
def test_mistakes_in_a_condition_of_the_user_are_one_line(scenario, result, message):
    own = OWN.replace(OWN.partition("return ")[2], f"{result}\n")
    with pytest.raises(InputError, match=re.escape(message)) as caught:
        read_scenario(scenario({AT: LATE}, own))
    assert "own.py:Late" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_check_says_which_conditions_and_laws_cannot_be_exported(scenario):
    loop = "jax.lax.while_loop(lambda x: x > 1.0, lambda x: 0.5 * x, 3.0 + measurement.rate[0])"
    own = OWN.replace("return time", f"return {loop} + time") + LAW.replace("LOOP", loop)
    changes = {AT: LATE, 'kind = "three_axis"\nrate_gain = 0.3': 'python = "own.py:Law"'}
    parts = gs.check(scenario(changes, f"import jax\n{own}")).parts
    for name in ("reference.transition.to_safe", "controller.law.soft"):
        assert parts[name].exported
        assert "a loop without a bound" in str(parts[name].export)
        assert parts[name].native is None


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("wheels_lost", "found a controller whose command has no works, expected"),
        ("tracker_lost", "found a measurement without attitude_measured, expected"),
    ],
)
def test_conditions_that_can_never_hold_are_refused(scenario, run, key, message):
    code, _, said = run("check", scenario({AT: f"{key} = 1"}))
    assert code == 2
    (line,) = said.splitlines()
    assert f"key reference.transition.to_safe.{key}: {message}" in line


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('to = "safe"', 'to = "save"', "found 'save', expected one of safe, science"),
        ('law = "soft"', 'law = "hard"', "found 'hard', expected one of soft"),
        ('at = "30 s"', "", "to_safe: found no condition"),
        ('at = "30 s"', 'when = "eclipse"', "found it without [orbit]"),
        ('at = "30 s"', 'rate_above = "-0.1 deg/s"', "'-0.1 deg/s', expected 0 or more, in rad/s"),
        ('at = "30 s"', "momentum_above = -0.5", "found -0.5, expected 0 or more, in N·m·s"),
        ('at = "30 s"', 'at = "-0.5 s"', "found '-0.5 s', expected 0 or more, in s"),
        ('at = "30 s"', 'at = "0 s"', "found at 0 s, before which no mode can begin"),
        ('held = "2 s"', 'rate_above = "0.4 deg/s"', "expected conditions that can hold together"),
        ('to = "safe"', 'from = "safe"\nto = "safe"', ""),
        ('to = "safe"', 'name = "until_safe"\nto = "safe"', "that does not begin with until_"),
        ('to = "science"', 'to = "safe"', "found no path to it from the first mode, safe"),
    ],
)
def test_mistakes_are_one_line(scenario, old, new, message):
    if not message:
        assert check_modes(read_scenario(scenario({old: new})))
        return
    with pytest.raises(InputError, match=re.escape(message)):
        read_scenario(scenario({old: new}))


@pytest.mark.parametrize(
    ("old", "new", "place", "time"),
    [
        ('at = "30 s"', 'at = "90 s"', "reference.transition.to_safe", "at"),
        ('at = "30 s"', 'time_in_mode = "90 s"', "reference.transition.to_safe", "time_in_mode"),
        ('dwell = "5 s"', 'dwell = "90 s"', "reference.transition.to_science", "minimum_dwell of"),
        ('law = "soft"', 'until_time = "90 s"', "reference.mode.safe", "until_time"),
    ],
)
def test_a_change_after_the_end_of_the_run_is_a_warning(scenario, old, new, place, time):
    """A short run of a mission is flown, such as one of 60 s of which a mode lasts 90 s."""
    late = read_scenario(scenario({old: new}))
    assert "modes: 2" in check_modes(late)
    (line,) = late_changes(late)
    assert line.startswith(f"warning: {place}: found {time} ")
    assert "90 s in a run of 60 s" in line
    assert late_changes(late.replace(**{"run.duration": 90.0})) == []


def test_check_says_which_changes_come_after_the_end_of_the_run():
    short = read_scenario(EXAMPLES / "nadir_and_slew.toml").replace(**{"run.duration": 100.0})
    lines = gs.check(short).warnings
    assert any("found until_time 170 s in a run of 100 s" in line for line in lines)


def test_more_lost_wheels_than_there_are_is_a_mistake(scenario):
    changes = {'kind = "three_axis"\n[[': 'kind = "wheel_array"\n[[', AT: "wheels_lost = 9"}
    with pytest.raises(InputError, match="found wheels_lost 9 of 4 wheels"):
        read_scenario(scenario(changes))


def test_a_cycle_that_takes_no_time_is_refused(scenario):
    text = TEXT.replace('minimum_dwell = "5 s"\n', "").replace('held = "2 s"\n', "")
    path = scenario({TEXT: text.replace('at = "30 s"', 'rate_above = "0.3 deg/s"')})
    with pytest.raises(InputError, match="safe -> science -> safe"):
        read_scenario(path)


@pytest.mark.parametrize(("verb", "suffix"), [("simulate", ".nc"), ("campaign", "")])
def test_an_invalid_graph_is_not_flown(scenario, run, tmp_path, verb, suffix):
    path = scenario({'to = "science"': 'to = "safe"'})
    runs = ["--runs", 8] if verb == "campaign" else []
    code, _, said = run(verb, path, *runs, "--out", tmp_path / f"out{suffix}")
    assert code == 2
    assert "key reference.mode.science: found no path to it from the first mode, safe" in said


def test_modes_of_which_none_ends_are_refused(scenario):
    text = TEXT[: TEXT.index("[[reference.transition]]")]
    with pytest.raises(InputError, match="science: found no path to it"):
        read_scenario(scenario({TEXT: text}))


ORBIT = """
[orbit]
kind = "circular"
epoch = "2026-06-21T10:12:00Z"
ascending_node = "112 deg"
altitude = "500 km"
inclination = "97.4 deg"
"""


@pytest.mark.parametrize(
    ("there", "back"),
    [
        ('rate_below = "0.3 deg/s"', 'rate_above = "0.5 deg/s"'),
        ('when = "eclipse"', 'when = "sunlight"'),
    ],
)
def test_a_cycle_whose_conditions_exclude_each_other_takes_time(scenario, there, back):
    text = TEXT.replace('minimum_dwell = "5 s"\n', "").replace('held = "2 s"\n', "")
    text = text.replace('rate_below = "0.3 deg/s"', there).replace('at = "30 s"', back)
    path = scenario({TEXT: text + ORBIT if "when" in there else text})
    assert "modes: 2, changes: 2, final: none" in check_modes(read_scenario(path))


def test_a_mode_that_changes_only_to_itself_is_final(scenario):
    path = scenario({'to = "safe"\n': 'from = "science"\nto = "science"\n'})
    assert "final: science;" in check_modes(read_scenario(path))


def test_times_of_edges_are_those_of_dwell_and_hold(scenario):
    found = {(edge.name, edge.start): edge.time for edge in edges(read_scenario(scenario()))}
    assert found == {("to_science", "safe"): 5.0, ("to_safe", "science"): 0.0}
