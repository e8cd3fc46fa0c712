"""Momentum at the start against the wheels: closed forms, and the plant's own momentum."""

from pathlib import Path

import numpy as np
import pytest

from gyrostat.campaigns.start_momentum import momentum_lines, momentum_rooms, start_momentum
from gyrostat.runs.plans import designs_of, setup_of
from gyrostat.scenario import Dispersion
from gyrostat.scenario_files.scenario_file import read_scenario

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
LIMIT = 0.03  # N·m·s, of each wheel of the pyramid


@pytest.fixture(scope="module")
def tumbling():
    return read_scenario("safe_mode")


def test_rooms_of_a_pyramid_are_those_of_its_closed_form(tumbling):
    """Two opposite axes of (1, ±1, ±1)/√3 span the nearest facets of the four, of three wheels too.

    A pair of axes has the normal (0, 1, -1)/√2 or (1, 1, 0)/√2 ..., along which each of the other
    wheels has √(2/3) of its limit.
    """
    every, three = momentum_rooms(tumbling)
    assert (every.lost, three.lost) == ((), ("b",))
    assert every.every == pytest.approx(2.0 * np.sqrt(2.0 / 3.0) * LIMIT)
    assert three.every == pytest.approx(np.sqrt(2.0 / 3.0) * LIMIT)
    # all four along their common direction, and the longest diagonal of the cell of three
    assert every.best == pytest.approx(4.0 / np.sqrt(3.0) * LIMIT)
    assert three.best == pytest.approx(np.sqrt(11.0 / 3.0) * LIMIT)


def test_momentum_is_that_of_the_plant(tumbling):
    nominal = tumbling.replace(dispersions=(), **{"wheel.a.speed": 400.0})
    plant = setup_of(nominal, designs_of(nominal)).start.momentum
    assert start_momentum(nominal) == pytest.approx([np.linalg.norm(plant)], rel=1e-12)


def test_what_cannot_be_held_is_said(tumbling):
    """45 deg/s about each axis, with rods in a run that is too short for them, and a long one."""
    fast = {f"start.rate.{axis}": np.radians(45.0) for axis in "xyz"}
    rods = tumbling.replace(dispersions=(), **fast)
    (line,), warnings = momentum_lines(rods)
    assert "the wheels hold 0.04899 N·m·s, 0.02449 N·m·s without wheel b" in line
    assert len(warnings) == 2
    assert "cannot hold it in any attitude, only 0.04899 N·m·s, and torque rods" in warnings[0]
    assert warnings[0].endswith("longer than the run")
    lines, warnings = momentum_lines(rods.replace(**{"run.duration": 50000.0}))
    assert warnings == []
    assert "torque rods take" in lines[0]


def test_the_share_of_draws_above_is_said_where_nothing_unloads():
    """Rates about the first axis that are uniform from 0 to twice what the wheels can stop."""
    alone = read_scenario(EXAMPLES / "science_windows.toml")
    still = {f"start.rate.{axis}": 0.0 for axis in "xyz"}
    still |= {f"wheel.{wheel}.speed": 0.0 for wheel in alone.wheels}
    still["controller.external_torque_limit"] = 0.0
    (room,) = momentum_rooms(alone)
    slow = alone.replace(dispersions=(), **{**still, "start.rate.x": 1e-3})
    rate = 2e-3 * room.every / start_momentum(slow)[0]
    drawn = Dispersion(("start.rate.x",), "uniform", ((0.0, rate),))
    _, (line,) = momentum_lines(alone.replace(dispersions=(drawn,), **still), seed=3)
    assert "nothing takes it off them; expected less, or torque rods or thrusters" in line
    share = float(line.partition(" % above")[0].rpartition("(")[2])
    assert share == pytest.approx(50.0, abs=5.0)  # three standard deviations of 1000 draws
