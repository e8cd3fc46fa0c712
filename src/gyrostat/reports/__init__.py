"""Output for people: figures, HTML pages and the files of an answer."""

from gyrostat.reports.feasibility import Drawn, Question, write_holdable
from gyrostat.reports.figures import friction_figure, record_figure, residual_figure, svg
from gyrostat.reports.page import fit_page, render, validation_page
from gyrostat.reports.recovery import recovery_figure, write_recovery
from gyrostat.reports.sky_map import sky_figure
from gyrostat.reports.write import write_fit

__all__ = [
    "Drawn",
    "Question",
    "fit_page",
    "friction_figure",
    "record_figure",
    "recovery_figure",
    "render",
    "residual_figure",
    "sky_figure",
    "svg",
    "validation_page",
    "write_fit",
    "write_holdable",
    "write_recovery",
]
