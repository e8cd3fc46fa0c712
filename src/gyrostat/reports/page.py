"""Self-contained HTML pages."""

from functools import lru_cache
from importlib.metadata import version

import jinja2

from gyrostat.core.text import measured, plain
from gyrostat.core.units import RPM, SI_UNIT
from gyrostat.identification import Fit
from gyrostat.identification.fit_text import (
    POSTERIOR_HEADER,
    effect_rows,
    parameter_rows,
    posterior_rows,
    posterior_summary,
    score_rows,
    share_rows,
    summary,
)
from gyrostat.identification.torque_points import torque_regression
from gyrostat.identification.validation import Validation
from gyrostat.reports import figures
from gyrostat.reports.posterior import posterior_figure


@lru_cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("gyrostat.reports"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"plain": plain, "rpm": lambda v: plain(v / RPM)}
    return environment


def render(template: str, **content: object) -> str:
    """Fill a template of this package.

    Args:
        template: File name under templates/.
        content: Variables of the template.
    """
    return _environment().get_template(template).render(version=version("gyrostat"), **content)


def fit_page(fit: Fit, *, command: str) -> str:
    """HTML report of an identification.

    Args:
        fit: Result of the identification.
        command: Command line that produced it, shown so that it can be repeated.
    """
    drawn = [
        (record.name, figures.svg(figures.record_figure(record, speed, sigma, noise)))
        for record, speed, sigma, noise in zip(
            fit.records, fit.predicted, fit.predicted_sigma, fit.speed_sigmas, strict=False
        )
    ]
    friction_known = all(n in fit.parameters for n in fit.model.dimensions())
    return render(
        "fit.html",
        fit=fit,
        command=command,
        summary=summary(fit),
        rows=list(parameter_rows(fit)),
        shares=list(share_rows(fit)),
        posterior=list(posterior_rows(fit)),
        posterior_header=POSTERIOR_HEADER,
        posterior_summary=[] if fit.posterior is None else posterior_summary(fit.posterior),
        posterior_figure=None if fit.posterior is None else figures.svg(posterior_figure(fit)),
        effects=list(effect_rows(fit)),
        scores=list(score_rows(fit)),
        records=drawn,
        friction=figures.svg(figures.friction_figure(fit)) if friction_known else None,
        regression=[
            (row, measured(row.value, row.sigma), SI_UNIT[fit.dimensions[row.name]])
            for row in torque_regression(fit)
        ],
        residuals=figures.svg(figures.residual_figure(fit)) if fit.predicted else None,
        correlation=list(zip(fit.names, fit.correlation.tolist(), strict=True)),
        comparison=fit.comparison,
        temperatures=[
            (t, measured(t.slope, t.slope_sigma), abs(t.slope) > 2.0 * t.slope_sigma)
            for t in fit.temperatures
        ],
    )


def validation_page(validation: Validation, *, command: str) -> str:
    """HTML report of a validation.

    Args:
        validation: Result of the validation.
        command: Command line that produced it.
    """
    figure = figures.record_figure(
        validation.record, validation.predicted, validation.predicted_sigma, validation.noise
    )
    return render(
        "validation.html", validation=validation, command=command, figure=figures.svg(figure)
    )
