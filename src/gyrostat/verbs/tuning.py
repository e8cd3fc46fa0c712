"""Verb `tune`: the best values of free numbers of a scenario."""

import os
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Named, Say, named, opener_of, silent
from gyrostat.verbs.progress import shown
from gyrostat.verbs.scenario_check import say_unlikely, scenario_of

if TYPE_CHECKING:
    from gyrostat.scenario import Scenario
    from gyrostat.search.tuning import TunedGains

TUNED = "tuned.toml"
"""Name of the tuned scenario."""


def tune(
    scenario: "Scenario | str | Path",
    free: Named,
    minimise: str,
    out: "str | Path",
    *,
    subject_to: str | Iterable[str] = (),
    runs: int = 50_000,
    seed: int = 0,
    workers: int | None = None,
    scheduler: str | None = None,
    force: bool = False,
    verify: bool = False,
    on_progress: Callable[[int, int], None] | None = None,
    say: Say = silent,
    command: str = "gyrostat.tune",
    **changes: Any,
) -> "TunedGains":
    """Search for the values of free numbers that minimise a metric, and prove them on fresh runs.

    All candidates are simulated with the same draws and noise. A candidate is judged by the values
    below which 95 % of its runs stay.

    Args:
        scenario: Scenario with dispersions, or path of scenario.toml.
        free: Free keys, "controller.rate_gain", or with bounds, "controller.rate_gain=0.1:2";
            without, a quarter to four times the value.
        minimise: Metric.
        out: Folder for the runs, report.html, report.json and, for a path, tuned.toml.
        subject_to: Limits, "torque_rms < 30 uN*m".
        runs: Largest number of runs.
        seed: Seed of all draws.
        workers: Number of threads; None: one for each core.
        scheduler: As for `campaign`.
        force: As for `campaign`.
        verify: As for `campaign`.
        on_progress: Function called with the number of runs done and the largest number; None: a
            bar in a terminal or notebook.
        say: Function that receives each message for the user.
        command: Text that the report names as its origin.
        changes: Changes of the scenario, as for `simulate`.

    Returns:
        The content of report.json, SI units; "values" has the best value of each free key, for
        `Scenario.replace`. Its `plot()` draws the candidates with their front.

    Raises:
        InputError: A key, metric or limit does not fit the scenario, or options cannot be used.
    """
    from gyrostat.core.files import check_writable
    from gyrostat.search.execute import Options
    from gyrostat.search.tuning import TunedGains, Tuning
    from gyrostat.verbs.searches import run_question

    folder = Path(out)
    check_writable(folder)
    definition = scenario_of(scenario, force=force, changes=changes)
    if not definition.dispersions:
        raise InputError(f"{definition.name}: key dispersion: found none, expected at least one")
    say_unlikely(definition, say)
    limits = [subject_to] if isinstance(subject_to, str) else [*subject_to]
    question = Tuning.of(definition, named(free, "--free", bare=True), minimise, limits)
    options = Options(runs, seed, workers, 0, force, verify, opener_of(scheduler, say))
    free_scenario = question.scenario(definition)
    about = say, shown(on_progress), command
    content = run_question(free_scenario, folder, question, options, *about)
    values = {each["key"]: each["after"] for each in content["free"]}
    if isinstance(scenario, str | Path) and not changes:
        _write(Path(scenario), definition.replace(**values), values, folder, say)
    result = TunedGains(content, values=values)
    result.folder = folder.resolve()
    return result


def _write(
    path: Path, expected: "Scenario", values: dict[str, float], folder: Path, say: Say
) -> None:
    """Write the tuned scenario into the folder, if the file has its keys in plain sections."""
    from gyrostat.campaigns import Store
    from gyrostat.scenario_files.scenario_file import read_scenario

    text = path.read_text(encoding="utf-8")
    for key, value in values.items():
        section, name = key.rsplit(".", 1)
        text = _with_value(text, section, name, value)
    text = _with_paths(text, path.parent, folder)
    store = Store(folder, say)
    campaign = store.known()
    trial = folder / f".{TUNED}"
    try:
        trial.write_text(text, encoding="utf-8")
        matches = dict(read_scenario(trial, force=True).values) == dict(expected.values)
    except InputError:
        matches = False
    finally:
        trial.unlink(missing_ok=True)
    if not matches:
        say(f"{TUNED}: not written, the keys are not plain lines of {path.name}: see report.json")
        return
    with store.locked(), store.results(campaign) as scratch:
        (scratch / TUNED).write_text(text, encoding="utf-8")
    say(f"written: {folder / TUNED}")


def _with_value(text: str, section: str, name: str, value: float) -> str:
    """Text of a scenario file in which a number of a section has another value, SI."""
    head = re.search(rf"^\[{re.escape(section)}\][^\n]*\n", text, re.MULTILINE)
    if head is None:
        return text
    tail = text[head.end() :]
    end = re.search(r"^\[", tail, re.MULTILINE)
    body = tail[: end.start()] if end else tail
    line = f"{name} = {value!r}\n"
    new_body, count = re.subn(rf"^{re.escape(name)}\s*=[^\n]*\n", line, body, flags=re.MULTILINE)
    return text[: head.end()] + (new_body if count else line + body) + tail[len(body) :]


def _with_paths(text: str, source: Path, folder: Path) -> str:
    """Text in which the paths of existing files are relative to another folder."""

    def relocate(match: re.Match[str]) -> str:
        name, colon, suffix = match[1].partition(":")
        if not name or not (source / name).is_file():
            return match[0]
        return f'"{os.path.relpath(source / name, folder)}{colon}{suffix}"'

    return re.sub(r'"([^"\n]+)"', relocate, text)
