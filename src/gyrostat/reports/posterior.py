"""Figure of a sampled posterior."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from gyrostat.identification import Fit
from gyrostat.identification.result.fit_text import estimate_of
from gyrostat.identification.uncertainty.posterior import Marginal, Posterior
from gyrostat.reports.colours import BAND, MODEL
from gyrostat.reports.drawing import literal, panels
from gyrostat.reports.page_units import bench_unit, labelled

COLUMNS = 3


def posterior_figure(fit: Fit) -> Figure:
    """Plot the marginal of each parameter with the Gaussian of value and sigma.

    Args:
        fit: A fit with a posterior.
    """
    assert fit.posterior is not None
    marginals = fit.posterior.marginals
    return _histograms(marginals, [estimate_of(fit, each.name) for each in marginals])


def posterior_picture(posterior: Posterior) -> Figure:
    """Plot the marginal of each parameter with the Gaussian of its mean and sigma.

    Args:
        posterior: Posterior.
    """
    marginals = posterior.marginals
    return _histograms(marginals, [(each.mean, each.sigma, each.unit) for each in marginals])


def _histograms(
    marginals: Sequence[Marginal], gaussians: Sequence[tuple[float, float, str]]
) -> Figure:
    """Histograms of the draws; Gaussians have a mean, a sigma and their SI unit."""
    rows = -(-len(marginals) // COLUMNS)
    with panels(rows, COLUMNS, height=2.2 * rows, squeeze=False) as (figure, grid):
        for axes, marginal, gaussian in zip(grid.flat, marginals, gaussians, strict=False):
            value, sigma, si = gaussian
            factor, unit = bench_unit(si)
            mean, spread = factor * value, factor * sigma
            heights, edges = np.histogram(factor * marginal.draws, bins=40, density=True)
            axes.stairs(heights, edges, fill=True, color=BAND)
            x = np.linspace(edges[0], edges[-1], 200)
            density = np.exp(-0.5 * ((x - mean) / spread) ** 2) / (spread * np.sqrt(2.0 * np.pi))
            axes.plot(x, density, color=MODEL, lw=1.2)
            axes.set_yticks([])
            axes.set_xlabel(labelled(literal(marginal.name), unit))
        for axes in grid.flat[len(marginals) :]:
            axes.set_visible(False)
    return figure
