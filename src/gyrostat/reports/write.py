"""Files and text of an identification."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path

from gyrostat.core.outputs import new_files
from gyrostat.identification import Candidate, Effect, Fit, TemperatureTrend
from gyrostat.reports.page import fit_page
from gyrostat.reports.text import (
    aligned,
    effect_rows,
    measured,
    parameter_rows,
    share_rows,
    summary,
)
from gyrostat.wheel import write_model

FILES = ("fit.json", "model.toml", "report.html")
LIKELY = 0.5
"""Posterior probability from which an effect is listed in the terminal."""


def shown(effect: Effect) -> bool:
    """Whether an effect is more likely than not."""
    return effect.probability > LIKELY


def write_fit(
    fit: Fit,
    out: Path,
    *,
    command: str,
    say: Callable[[str], None],
    comparison: Sequence[Candidate] = (),
    temperatures: Sequence[TemperatureTrend] = (),
    force: bool = False,
) -> str:
    """Write fit.json, report.html and, where there is a wheel model, model.toml.

    Args:
        fit: the result.
        out: folder for the files.
        command: what produced it.
        say: takes each line for a person.
        comparison: of friction models; may be empty.
        temperatures: trends over temperature; may be empty.
        force: whether to replace files that an identification did not write; see
            `gyrostat.core.outputs`.

    Returns:
        The text of fit.json.

    Raises:
        InputError: a file is in the way, or the folder cannot be written.
    """
    content = fit.to_dict()
    if comparison:
        content["comparison"] = [row.to_dict() for row in comparison]
    if temperatures:
        content["temperature"] = [trend.to_dict() for trend in temperatures]
    text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
    page = fit_page(fit, command=command, comparison=comparison, temperatures=temperatures)
    model = fit.wheel_model()
    results = [out / "report.html", out / "fit.json"]
    with new_files(out, by="identify", force=force) as folder:
        (folder / "report.html").write_text(page, encoding="utf-8")
        (folder / "fit.json").write_text(text + "\n", encoding="utf-8")
        if model is not None and fit.converged:
            results.append(out / "model.toml")
            write_model(folder / "model.toml", model)
    if len(results) < len(FILES) and (out / "model.toml").exists():
        say(f"warning: {out / 'model.toml'} is of an earlier run: this one gives no wheel model")

    def table(rows: Sequence[Sequence[str]], header: Sequence[str]) -> None:
        for line in aligned(rows, header):
            say("  " + line)

    for line in summary(fit):
        say(line)
    table(list(parameter_rows(fit)), ("parameter", "value ± sigma", "unit", "observable?"))
    if fit.tolerances is not None:
        table(list(share_rows(fit)), ("share in variance", *fit.variance_shares))
    likely = [row for row, e in zip(effect_rows(fit), fit.effects, strict=True) if shown(e)]
    if likely:
        table(likely, ("effect beside the model", "size", "probability"))
    for trend in temperatures:
        slope = measured(trend.slope, trend.slope_sigma)
        say(f"  {trend.name} changes by {slope} {trend.unit} per °C")
    for warning in fit.warnings:
        say(f"warning: {warning}")
    if fit.impossible:
        say("no valid result: no wheel has these values; model.toml is marked, and is only taken")
        say(f"with --force: {'; '.join(fit.impossible)}")
    if fit.converged:
        say(f"written: {', '.join(str(path) for path in results)}")
    else:
        say(f"no valid result; what there is stands in {out / 'fit.json'}")
    return text
