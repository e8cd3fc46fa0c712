"""Dispersion table of a lot, lot.toml, which scenario files name."""

import json

import numpy as np

from gyrostat.core.skewed_normal import usable_shape
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.lot.correlation import possible
from gyrostat.identification.lot.result import Lot


def score_correlation(correlation: Matrix, shape: Vector) -> Matrix:
    """Correlation of the standard normal numbers behind correlated parameters, (p, p).

    The correlation of two skewed normal parameters with shapes g and h, whose standard normal
    numbers have the correlation q, is (exp(g h q) - 1) / sqrt((exp(g^2) - 1) (exp(h^2) - 1)).

    Args:
        correlation: Correlation of the parameters, (p, p).
        shape: Their shapes, (p,).
    """
    shapes = usable_shape(shape)
    root = np.sqrt(np.expm1(shapes**2))
    product = np.outer(shapes, shapes)
    argument = np.maximum(correlation * np.outer(root, root) * np.sign(product), -1.0 + 1e-12)
    return np.clip(np.log1p(argument) / product, -1.0, 1.0)


def dispersion_table(lot: Lot) -> str:
    """Text of lot.toml."""
    typical = np.array([parameter.draws.typical() for parameter in lot.parameters.values()])
    known = np.where(np.isfinite(lot.correlation.value), lot.correlation.value, 0.0)
    matrix = possible(score_correlation(known, typical[:, 2]))
    rows = ",\n".join(f"    {row}" for row in np.round(matrix, 6).tolist())
    location, scale, shape = (column.tolist() for column in typical.T)
    return f"""# Lot of {len(lot.fits)} wheels: value = location + scale (exp(shape z) - 1) / shape,
# z standard normal with these correlations; SI units. The errors of the fits are taken out.
model = {json.dumps(lot.fits[0].model)}
wheels = {len(lot.fits)}
names = {json.dumps(list(lot.parameters))}
location = {location}
scale = {scale}
shape = {shape}
correlation = [
{rows},
]
"""
