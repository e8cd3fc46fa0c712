"""Three wheels that point a body, without friction: gyrostat beside Basilisk."""

from pathlib import Path

import numpy as np
import pytest

from gyrostat.core import rotations
from gyrostat.core.jax64 import jax
from gyrostat.simulation import run

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
COUNT, EVERY = 3000, 500


@pytest.fixture(scope="module")
def case(module_at):
    """The case of the benchmark, friction off, and Basilisk's trajectory of it."""
    pytest.importorskip("Basilisk", reason="found no Basilisk (bsk), of the extra peers")
    if not BENCHMARKS.is_dir():
        pytest.skip("found no benchmarks, expected those of the repository")
    case = module_at(BENCHMARKS / "pointing_case.py")
    peer = module_at(BENCHMARKS / "basilisk_peer.py")
    drawn = case.Drawn(*(x[0] for x in case.draw(1)))._replace(friction=np.zeros(3))
    period = case.PERIOD
    given = {name: value.tolist() for name, value in drawn._asdict().items()}
    return case, drawn, peer.three_wheels(given, case.CRAFT, period, COUNT * period, EVERY * period)


def test_trajectories_without_friction_are_those_of_basilisk(case):
    case, drawn, theirs = case
    histories = run(*case.parts(drawn), jax.random.key(0), case.PERIOD, count=COUNT)
    rows = slice(None, None, EVERY)
    mrp = jax.vmap(rotations.to_mrp)(histories.state.attitude[rows])
    np.testing.assert_allclose(mrp, theirs["mrp"], rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(histories.record.rate[rows], theirs["rate"], rtol=0.0, atol=1e-13)
    speed = histories.state.wheel_speed[rows]
    assert np.ptp(speed) > 10.0
    np.testing.assert_allclose(speed, theirs["wheel_speed"], rtol=0.0, atol=1e-9)
