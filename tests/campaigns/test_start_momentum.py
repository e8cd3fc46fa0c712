"""Momentum at the start against the wheels: closed forms, and the plant's own momentum."""

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from gyrostat.campaigns.draws import draw
from gyrostat.campaigns.start_momentum import momentum_lines, momentum_rooms, start_momentum
from gyrostat.core.text import plain
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
    assert every.best(0) == pytest.approx(4.0 / np.sqrt(3.0) * LIMIT)
    assert three.best(0) == pytest.approx(np.sqrt(11.0 / 3.0) * LIMIT)


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
    assert "cannot hold it in any attitude, only 0.06928 N·m·s, and torque rods" in warnings[0]
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
    rate = 2e-3 * room.every[0] / start_momentum(slow)[0]
    drawn = Dispersion(("start.rate.x",), "uniform", ((0.0, rate),))
    _, (line,) = momentum_lines(alone.replace(dispersions=(drawn,), **still), seed=3)
    assert "nothing takes it off them; expected less, or torque rods or thrusters" in line
    share = float(line.partition(" % above")[0].rpartition("(")[2])
    assert share == pytest.approx(50.0, abs=5.0)  # three standard deviations of 1000 draws


def test_limits_that_are_drawn_are_those_of_each_draw(tumbling):
    """Nearest facets from the axes of each draw, each spanned by a pair of wheels."""
    keys = tuple(f"wheel.{wheel}.momentum_limit" for wheel in tumbling.wheels)
    still = {f"start.rate.{axis}": 0.0 for axis in "xyz"}
    still |= {f"wheel.{wheel}.speed": 10.0 for wheel in tumbling.wheels}
    wide = Dispersion(keys, "uniform", ((1e-3, LIMIT),) * len(keys))
    drawn = tumbling.replace(dispersions=(wide,), events=(), **still)
    (room,) = momentum_rooms(drawn, seed=3, runs=50)
    limits = draw(drawn, 3, np.arange(50))[0]
    np.testing.assert_array_equal(room.limits, limits)
    (nominal,) = momentum_rooms(drawn.replace(dispersions=()))
    axes = nominal.axes
    pairs = [np.cross(axes[:, a], axes[:, b]) for a, b in combinations(range(4), 2)]
    normals = [pair / np.linalg.norm(pair) for pair in pairs]
    supports = [[np.abs(n @ axes) @ row for n in normals] for row in limits]
    np.testing.assert_allclose(room.every, np.min(supports, axis=1), rtol=1e-12)
    (line,), _ = momentum_lines(drawn, seed=3, runs=50)
    assert f"the wheels hold at least {plain(float(np.min(room.every)))} N·m·s, at rest" in line


def test_more_wheels_than_the_envelope_takes_have_no_line(tumbling):
    many = 17
    names = tuple(f"w{k}" for k in range(many))
    values = {
        f"wheel.{name}.{key.rpartition('.')[2]}": value
        for name in names
        for key, value in tumbling.values.items()
        if key.startswith("wheel.a.")
    }
    axes = tuple(tuple(np.eye(3)[k % 3]) for k in range(many))
    crowd = replace(
        tumbling,
        wheels=names,
        axes=axes,
        events=(),
        dispersions=(),
        values={**tumbling.values, **values},
    )
    assert momentum_rooms(crowd) == []
    assert momentum_lines(crowd) == ([], [])
