"""Files of the plan that `plan-speeds` finds."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gyrostat.core.outputs import new_files
from gyrostat.search.speed_plan import SpeedPlan, named_entries

FILES = ("plan.json", "plan.toml")


def lines_of(result: SpeedPlan) -> list[str]:
    """Summary of a plan, a line for each fact."""
    names = ", ".join(result.windows)
    before = f"present law: {_counts(result.before)} in {names}"
    if result.plan.certificate is not None:
        numbers = ", ".join(str(number + 1) for number in result.plan.windows)
        count = len(result.plan.certificate.leaves)
        return [
            before,
            f"infeasible: without unloading in science time {numbers}, no control keeps the "
            f"clearance with these attitudes and external torques (certificate of {count} linear "
            "programs)",
        ]
    if result.after is None:
        return [before, "not found: neither a plan nor a proof that there is none"]
    lines = [before, f"{result.answer}: {_counts(result.after)} with the plan"]
    if result.runs:
        share, low, high = result.probability()
        lines.append(
            f"dispersed runs without a crossing: {100 * result.clean_before / result.runs:.3g} % "
            f"by the present law, {100 * share:.3g} % with the plan ({100 * low:.3g} to "
            f"{100 * high:.3g} %, {result.runs} runs)"
        )
    return lines


def _counts(found: dict[str, int]) -> str:
    return f"{found['zero']} zero crossings and {found['band']} entries into bands"


def content_of(result: SpeedPlan) -> dict[str, Any]:
    """Plan as JSON, SI units."""
    certificate = result.plan.certificate
    leaves = () if certificate is None else certificate.leaves
    return {
        "scenario": result.scenario.name,
        "answer": result.answer,
        "windows": [*result.windows],
        "clearance": result.clearance,
        "present": result.before,
        "planned": result.after,
        "impulse": result.plan.impulse,
        "entries": [
            {
                "name": name,
                "time": entry.time,
                "unloads": entry.unloads,
                "momentum": [float(value) for value in entry.momentum],
                "null_space": entry.null_space,
                "window": [*entry.window],
            }
            for name, entry in named_entries(result.plan)
        ],
        "infeasible_windows": [*result.plan.windows],
        "certificate": [
            {"intervals": [*leaf.made], "weights": [float(weight) for weight in leaf.weights]}
            for leaf in leaves
        ],
        "runs": result.runs,
        "clean_present": result.clean_before,
        "clean_planned": result.clean_after,
        "probability": [*result.probability()] if result.runs else None,
    }


def toml_of(result: SpeedPlan, command: str) -> str:
    """Tables [[controller.plan]] to append to the scenario file."""
    lines = [f"# {result.answer}; written by: {command}", "# append it to the scenario file"]
    for name, entry in named_entries(result.plan):
        begin, end = entry.window
        momentum = ", ".join(repr(float(value)) for value in entry.momentum)
        lines += [
            "",
            f"# for the science time from {begin:g} s to {end:g} s",
            "[[controller.plan]]",
            f'name = "{name}"',
            f"time = {entry.time!r}",
            f"unloads = {entry.unloads!r}",
            f"momentum = [{momentum}]",
            f"null_space = {entry.null_space!r}",
        ]
    return "\n".join(lines) + "\n"


def write_plan(
    result: SpeedPlan, out: Path, *, command: str, say: Callable[[str], None], force: bool = False
) -> None:
    """Write plan.json and plan.toml.

    Args:
        result: The result.
        out: Output folder.
        command: Command line that produced it.
        say: Called with a line that names the files.
        force: Whether to replace files that `plan-speeds` did not write; see
            `gyrostat.core.outputs`.

    Raises:
        InputError: A file of the user is in the way, or the folder cannot be written.
    """
    text = json.dumps(content_of(result), indent=1, ensure_ascii=False, allow_nan=False)
    with new_files(out, by="plan-speeds", force=force) as folder:
        (folder / "plan.toml").write_text(toml_of(result, command), encoding="utf-8")
        (folder / "plan.json").write_text(text + "\n", encoding="utf-8")
    say(f"written: {out / 'plan.toml'}, {out / 'plan.json'}")
