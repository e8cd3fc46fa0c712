"""Files and text of an identification."""

import json
from collections.abc import Callable
from pathlib import Path

from gyrostat.core.outputs import new_files
from gyrostat.identification import Fit
from gyrostat.identification.fit_text import table
from gyrostat.reports.page import fit_page
from gyrostat.wheel import write_model

FILES = ("fit.json", "model.toml", "report.html")


def write_fit(
    fit: Fit,
    out: Path,
    *,
    command: str,
    say: Callable[[str], None],
    force: bool = False,
) -> str:
    """Write fit.json, report.html and, if there is a wheel model, model.toml; print a summary.

    Args:
        fit: Result of the identification.
        out: Output folder.
        command: Command line that produced it.
        say: Called with each line of the summary.
        force: Whether to replace files that an identification did not write; see
            `gyrostat.core.outputs`.

    Returns:
        Text of fit.json.

    Raises:
        InputError: A file of the user is in the way, or the folder cannot be written.
    """
    text = json.dumps(fit.to_dict(), indent=1, ensure_ascii=False, allow_nan=False)
    page = fit_page(fit, command=command)
    model = fit.wheel_model()
    results = [out / "report.html", out / "fit.json"]
    with new_files(out, by="identify", force=force) as folder:
        (folder / "report.html").write_text(page, encoding="utf-8")
        (folder / "fit.json").write_text(text + "\n", encoding="utf-8")
        if model is not None and fit.converged:
            results.append(out / "model.toml")
            write_model(folder / "model.toml", model)
    if len(results) < len(FILES) and (out / "model.toml").exists():
        say(f"warning: {out / 'model.toml'} is of an earlier run; this run gives no wheel model")

    for line in table(fit):
        say(line)
    if fit.converged:
        say(f"written: {', '.join(str(path) for path in results)}")
    else:
        say(f"no valid result; the partial results are in {out / 'fit.json'}")
    return text
