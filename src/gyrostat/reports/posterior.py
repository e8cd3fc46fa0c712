"""Figure of a sampled posterior."""

import numpy as np
from matplotlib.figure import Figure

from gyrostat.identification import Fit
from gyrostat.identification.result.fit_text import estimate_of
from gyrostat.reports.colours import BAND, MODEL
from gyrostat.reports.drawing import panels
from gyrostat.reports.page_units import bench_unit

COLUMNS = 3


def posterior_figure(fit: Fit) -> Figure:
    """Plot the marginal of each parameter with the Gaussian of value and sigma.

    Args:
        fit: A fit with a posterior.
    """
    assert fit.posterior is not None
    marginals = fit.posterior.marginals
    rows = -(-len(marginals) // COLUMNS)
    with panels(rows, COLUMNS, height=2.2 * rows, squeeze=False) as (figure, grid):
        for axes, marginal in zip(grid.flat, marginals, strict=False):
            value, sigma, unit = estimate_of(fit, marginal.name)
            factor, unit = bench_unit(unit)
            value, sigma = factor * value, factor * sigma
            heights, edges = np.histogram(factor * marginal.draws, bins=40, density=True)
            axes.stairs(heights, edges, fill=True, color=BAND)
            x = np.linspace(edges[0], edges[-1], 200)
            density = np.exp(-0.5 * ((x - value) / sigma) ** 2) / (sigma * np.sqrt(2.0 * np.pi))
            axes.plot(x, density, color=MODEL, lw=1.2)
            axes.set_yticks([])
            axes.set_xlabel(f"{marginal.name} ({unit})")
        for axes in grid.flat[len(marginals) :]:
            axes.set_visible(False)
    return figure
