"""Runs of the paper's wheel."""

from typing import TYPE_CHECKING, Any

import numpy as np

from gyrostat.papers.moreira_lopes_kuga.printed import BENCH, DURATION, PERIOD, SENSOR
from gyrostat.simulate import simulate

if TYPE_CHECKING:
    import xarray as xr

SETTLED = 200
"""s: from here on the wheel counts as settled."""


def fly(controller: Any, seeds: int, *, plant: Any = BENCH, seed: int = 0) -> "xr.Dataset":
    """Run the wheel from rest; see `gyrostat.simulate.simulate`."""
    return simulate(
        plant,
        controller,
        SENSOR,
        start=BENCH.start(),
        duration=DURATION,
        control_period=PERIOD,
        runs=seeds,
        seed=seed,
    )


def at(signal: "xr.DataArray", second: int) -> np.ndarray:
    """Values of all runs at a whole second."""
    return signal.sel(time=float(second)).values
