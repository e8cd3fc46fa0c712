"""Files and text of an identification."""

import json
from collections.abc import Callable
from pathlib import Path

from gyrostat.core.files import digest_of
from gyrostat.core.outputs import check_outputs, new_files
from gyrostat.core.user_modules import Source
from gyrostat.identification import Fit
from gyrostat.identification.result.fit_text import table
from gyrostat.reports.page import fit_page
from gyrostat.runs.user.elsewhere import check_law_elsewhere
from gyrostat.scenario.user.live_calls import compare_live_law
from gyrostat.scenario_files.python.objects import user_object
from gyrostat.wheel import write_model
from gyrostat.wheel.friction import Friction
from gyrostat.wheel.friction_laws import digest, law_texts, loaded_law, write_texts


def law_source(law: type[Friction]) -> tuple[str, tuple[Source, ...]] | None:
    """Kind and texts of a user's friction law; None of a law of this package.

    Raises:
        InputError: The law is defined in a script or a notebook, and its text cannot be extracted.
    """
    if law.is_shipped():
        return None
    texts = law_texts(law)
    if texts is None:
        kind, sources, *_ = user_object("friction", law.of(**dict.fromkeys(law.dimensions(), 1.0)))
        compare_live_law(f"friction {kind}", law, loaded_law(kind, sources))
        texts = kind, sources
    return texts


def check_law_files(law: type[Friction], out: Path, *, force: bool) -> None:
    """Check, before a fit, that the text of a user's law can be written beside its results.

    Raises:
        InputError: There is no text of the law, its curve depends on the process, or another file
            of the user is in the way.
    """
    texts = law_source(law)
    sources = () if texts is None else texts[1]
    if texts is not None:
        check_law_elsewhere(*texts)
    # a law may stand in the folder itself
    paths = [s.path for s in sources if digest_of(out / s.path) != digest(s)]
    check_outputs(out, paths, by="identify", force=force)


FILES = ("fit.json", "model.toml", "report.html")


def write_fit(
    fit: Fit, out: Path, *, command: str, say: Callable[[str], None], force: bool = False
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
    law = law_source(fit.model)
    content = fit.to_dict()
    if law is not None:
        digests = {source.path: digest(source) for source in law[1]}
        content["law"] = {"python": law[0], "sources": digests}
    text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
    page = fit_page(fit, command=command)
    model = fit.wheel_model()
    results = [out / "report.html", out / "fit.json"]
    with new_files(out, by="identify", force=force) as folder:
        (folder / "report.html").write_text(page, encoding="utf-8")
        (folder / "fit.json").write_text(text + "\n", encoding="utf-8")
        if model is not None and fit.converged:
            results.append(out / "model.toml")
            write_model(folder / "model.toml", model, law)
        elif law is not None:
            write_texts(folder, law[1])
    if len(results) < len(FILES) and (out / "model.toml").exists():
        say(f"warning: {out / 'model.toml'} is of an earlier run; this run gives no wheel model")

    for line in table(fit):
        say(line)
    if fit.converged:
        say(f"written: {', '.join(str(path) for path in results)}")
    else:
        say(f"no valid result; the partial results are in {out / 'fit.json'}")
    return text
