"""Self-contained HTML pages."""

from markupsafe import Markup

from gyrostat.core.text import measured
from gyrostat.core.units import si_unit
from gyrostat.identification import Fit
from gyrostat.identification.judge.acceptance_text import HEADER, acceptance_rows
from gyrostat.identification.judge.validation import Validation
from gyrostat.identification.result.fit_text import (
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
from gyrostat.reports.fit_charts import friction_charts, record_charts, residual_charts
from gyrostat.reports.page_units import bench_unit
from gyrostat.reports.template import render


def fit_page(fit: Fit, *, command: str) -> str:
    """HTML report of an identification.

    Args:
        fit: Result of the identification.
        command: Command line that produced it, shown so that it can be repeated.
    """
    records = [
        (record.name, record_charts(record, speed, sigma, noise, f"record{k}"))
        for k, (record, speed, sigma, noise) in enumerate(
            zip(fit.records, fit.predicted, fit.predicted_sigma, fit.speed_sigmas, strict=False)
        )
    ]
    friction_known = all(n in fit.parameters for n in fit.model.dimensions())
    return render(
        "fit.html",
        fit=fit,
        command=command,
        summary=summary(fit, bench_unit),
        rows=list(parameter_rows(fit, bench_unit)),
        shares=list(share_rows(fit)),
        posterior=list(posterior_rows(fit, bench_unit)),
        posterior_header=POSTERIOR_HEADER,
        posterior_summary=[] if fit.posterior is None else posterior_summary(fit.posterior),
        posterior_figure=None if fit.posterior is None else _posterior(fit),
        effects=list(effect_rows(fit, bench_unit)),
        scores=list(score_rows(fit, bench_unit)),
        records=records,
        friction=friction_charts(fit) if friction_known else None,
        regression=[
            (row, *_shown(row.value, row.sigma, si_unit(fit.dimensions[row.name])))
            for row in torque_regression(fit)
        ],
        residuals=residual_charts(fit) if fit.predicted else None,
        correlation=list(zip(fit.names, fit.correlation.tolist(), strict=True)),
        comparison=fit.comparison,
        temperatures=[
            (t, *_shown(t.slope, t.slope_sigma, t.unit), abs(t.slope) > 2.0 * t.slope_sigma)
            for t in fit.temperatures
        ],
    )


def _shown(value: float, sigma: float, unit: str) -> tuple[str, str]:
    """Value ± sigma, and the unit in which the page shows it."""
    factor, shown = bench_unit(unit)
    return measured(factor * value, factor * sigma), shown


def _posterior(fit: Fit) -> Markup:
    from gyrostat.reports.figure_charts import figure_charts  # matplotlib is slow to import
    from gyrostat.reports.posterior import posterior_figure

    return figure_charts(posterior_figure(fit), "posterior")


def validation_page(validation: Validation, *, command: str) -> str:
    """HTML report of a validation.

    Args:
        validation: Result of the validation.
        command: Command line that produced it.
    """
    charts = record_charts(
        validation.record, validation.predicted, validation.predicted_sigma, validation.noise
    )
    acceptance = validation.acceptance
    return render(
        "validation.html",
        validation=validation,
        command=command,
        charts=charts,
        acceptance=acceptance,
        header=HEADER,
        lines=[]
        if acceptance is None
        else list(zip(acceptance_rows(acceptance), acceptance.lines, strict=True)),
    )
