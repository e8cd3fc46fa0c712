"""Temperature of a wheel from rounded telemetry, against the exact one."""

from dataclasses import replace

import numpy as np
import pytest

from gyrostat.monitoring.blocks import Samples, blocks_of
from gyrostat.monitoring.rows import warmth

ORBIT = 5676.0  # s


@pytest.mark.parametrize("gap", [False, True])
def test_a_rounded_temperature_keeps_its_extremes_and_ends(gap):
    """Everywhere within half a step of the rounding, and by rms within a third of its rms.

    A moving average of 21 minutes is wrong by 0.6 K at the ends, 0.8 K at the gap.
    """
    time, step = np.arange(43200.0), 0.5
    turn = 2.0 * np.pi / ORBIT
    exact = 2.4 * np.sin(turn * time) + 0.5 * np.sin(2.0 * turn * time + 1.0)
    one = np.full((time.size, 1), 100.0)
    rounded = 20.0 + step * np.round(exact / step)
    blocks, _ = blocks_of(Samples(time, one, one, temperature=rounded[:, None]), 60.0, 0.0)
    if gap:
        blocks = blocks.part((blocks.start < 20000.0) | (blocks.start > 20600.0))
    exact = np.array([exact[(time >= b) & (time < b + 60.0)].mean() for b in blocks.start])
    error = warmth(blocks, 0) - (exact - exact.mean())
    assert np.sqrt(np.mean(error**2)) < step / np.sqrt(12.0) / 3.0
    assert np.max(np.abs(error)) < 0.5 * step


def test_a_temperature_that_hardly_changes_or_is_not_known_has_no_effect():
    time = np.arange(7200.0)
    one = np.ones((time.size, 1))
    blocks, _ = blocks_of(Samples(time, one, one, temperature=20.0 + 0.4 * one), 60.0, 0.0)
    assert warmth(blocks, 0) is None
    assert warmth(replace(blocks, temperature=np.full((len(blocks), 1), np.nan)), 0) is None
