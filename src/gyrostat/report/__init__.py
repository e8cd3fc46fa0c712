"""What a person reads: figures, HTML pages and the files of an identification."""

from gyrostat.report.figures import friction_figure, record_figure, residual_figure, svg
from gyrostat.report.page import fit_page, render, validation_page
from gyrostat.report.write import write_fit

__all__ = [
    "fit_page",
    "friction_figure",
    "record_figure",
    "render",
    "residual_figure",
    "svg",
    "validation_page",
    "write_fit",
]
