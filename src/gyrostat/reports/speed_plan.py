"""Files of the plan that `plan-speeds` finds."""

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from gyrostat.core.outputs import new_files
from gyrostat.core.text import plain
from gyrostat.core.types import Vector
from gyrostat.core.units import RPM
from gyrostat.microvibration.sight import LineOfSight
from gyrostat.microvibration.sight_text import ARCSEC, bands_text
from gyrostat.reports.axis import scaled_unit
from gyrostat.reports.page_units import shown_unit
from gyrostat.reports.speed_plan_charts import plan_charts
from gyrostat.reports.template import render
from gyrostat.runs.speed_plan.flight import Flight
from gyrostat.runs.speed_plan.plan import FOUND
from gyrostat.search.speed_plan import SpeedPlan, named_entries

FILES = ("plan.json", "plan.toml", "report.html")


def lines_of(result: SpeedPlan) -> list[str]:
    """Summary of a plan, a line for each fact."""
    names = ", ".join(result.windows)
    before = f"present law: {_flown(result.present)} in {names}"
    if result.plan.certificate is not None:
        numbers = ", ".join(str(number + 1) for number in result.plan.windows)
        count = len(result.plan.certificate.leaves)
        return [
            before,
            f"infeasible: without unloading in science time {numbers}, no control keeps the "
            f"clearance with these attitudes and external torques (certificate of {count} linear "
            "programs)",
        ]
    if result.planned is None:
        return [before, "not found: neither a plan nor a proof that there is none"]
    lines = [before, f"{result.answer}: {_flown(result.planned)} with the plan"]
    lines += [
        f"line of sight in the windows, rms: {' by the present law, '.join(texts)} with the plan"
        for texts in [_sights(result)]
        if texts
    ]
    if result.runs:
        present, planned = _shares(result)
        lines.append(
            f"share of {result.runs} dispersed runs without a crossing: {present} by the present "
            f"law, {planned} with the plan (95 % intervals)"
        )
        if result.outside_before or result.outside_after:
            lines.append(
                f"dispersed runs without any time in {names}, which are not in the shares: "
                f"{result.outside_before} by the present law, {result.outside_after} with the plan"
            )
    elif result.answer == FOUND:
        lines.append("no dispersed runs: --runs N estimates the probability of no crossing")
    return lines


def _sights(result: SpeedPlan) -> list[str]:
    """Motion of the line of sight by each law, nominal, and over the dispersed runs."""
    if result.sight is None or result.sight.limit is None:
        return []
    flights = (result.present, *([] if result.planned is None else [result.planned]))
    texts = []
    runs = (result.sight_before, result.sight_after)
    outside = (result.outside_before, result.outside_after)
    for flight, values, without in zip(flights, runs, outside, strict=False):
        text = "unknown: wheels above its speeds"
        if np.isfinite(flight.sight):
            text = f"{plain(flight.sight / ARCSEC)} arcsec"
        if values:
            within = int(np.sum(np.array(values) <= result.sight.limit))
            limit = plain(result.sight.limit / ARCSEC)
            text += f" ({_share(result, within, without)} of the runs within {limit} arcsec)"
        texts.append(text)
    return texts


def _shares(result: SpeedPlan) -> list[str]:
    """Share of the dispersed runs without a crossing by each law."""
    return [
        _share(result, result.clean_before, result.outside_before),
        _share(result, result.clean_after, result.outside_after),
    ]


def _share(result: SpeedPlan, clean: int, outside: int) -> str:
    if outside == result.runs:
        return "unknown"
    share, low, high = (100.0 * value for value in result.probability(clean, outside))
    return f"{share:.3g} % ({low:.3g} to {high:.3g} %)"


def _probability(result: SpeedPlan, clean: int, outside: int) -> list[float] | None:
    return [*result.probability(clean, outside)] if outside < result.runs else None


def _flown(flight: Flight) -> str:
    return (
        f"{_counts(flight.crossings)}, least distance from zero, bands and limits "
        f"{flight.distance / RPM:.3g} rpm"
    )


def _counts(found: dict[str, int]) -> str:
    zero, band = found["zero"], found["band"]
    return (
        f"{zero} zero crossing{'' if zero == 1 else 's'} and {band} "
        f"{'entry' if band == 1 else 'entries'} into bands"
    )


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
        "distance_present": result.present.distance,
        "distance_planned": None if result.planned is None else result.planned.distance,
        "impulse": result.plan.impulse,
        "entries": [
            {
                "name": name,
                "time": entry.time,
                "unloads": entry.unloads,
                "momentum": [float(value) for value in entry.momentum],
                "null_space": entry.null_space,
                "momentum_rate": [float(value) for value in entry.momentum_rate],
                "torque": [float(value) for value in entry.torque],
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
        "outside_present": result.outside_before,
        "outside_planned": result.outside_after,
        "probability_present": _probability(result, result.clean_before, result.outside_before),
        "probability": _probability(result, result.clean_after, result.outside_after),
        "line_of_sight": None if result.sight is None else _sight_content(result, result.sight),
    }


def _sight_content(result: SpeedPlan, sight: LineOfSight) -> dict[str, Any]:
    def finite(values: Iterable[float]) -> list[float | None]:
        return [value if np.isfinite(value) else None for value in values]

    present, planned = finite(
        [result.present.sight, np.nan if result.planned is None else result.planned.sight]
    )
    return {
        "limit": sight.limit,
        "bands": [[*band] for band in sight.bands()],
        "present": present,
        "planned": planned,
        "runs_present": finite(result.sight_before),
        "runs_planned": finite(result.sight_after),
    }


def toml_of(result: SpeedPlan, command: str) -> str:
    """Tables [[controller.plan]] to append to the scenario file."""
    lines = [f"# {result.answer}; written by: {command}", "# append it to the scenario file"]
    if result.sight is not None:
        lines += ["", *bands_text(result.sight).splitlines()]
    for name, entry in named_entries(result.plan):
        begin, end = entry.window
        lines += [
            "",
            f"# for the science time from {begin:g} s to {end:g} s",
            "[[controller.plan]]",
            f'name = "{name}"',
            f"time = {entry.time!r}",
            f"unloads = {entry.unloads!r}",
            f"momentum = {_listed(entry.momentum)}",
            f"null_space = {entry.null_space!r}",
            f"momentum_rate = {_listed(entry.momentum_rate)}",
            f"torque = {_listed(entry.torque)}",
        ]
    return "\n".join(lines) + "\n"


def _listed(vector: Vector) -> str:
    return f"[{', '.join(repr(float(value)) for value in vector)}]"


def page_of(result: SpeedPlan, command: str) -> str:
    """HTML page of a plan.

    Args:
        result: The result.
        command: Command line that produced it.
    """
    flights = [result.present, *([] if result.planned is None else [result.planned])]
    rows = [
        ("zero crossings in science windows", [f.crossings["zero"] for f in flights]),
        ("entries into bands", [f.crossings["band"] for f in flights]),
        (
            "least distance from zero, bands and limits",
            [f"{f.distance / RPM:.4g} rpm" for f in flights],
        ),
    ]
    if sights := _sights(result):
        rows.append(("line of sight in the windows, rms of smear and jitter", sights))
    if result.runs:
        name = f"share of {result.runs} dispersed runs without a crossing, with 95 % interval"
        rows.append((name, _shares(result)))
        if result.outside_before or result.outside_after:
            without = [result.outside_before, result.outside_after]
            rows.append(("dispersed runs without time in the windows, not in the share", without))
    entries = [entry for _, entry in named_entries(result.plan)]
    torque, torque_unit = shown_unit("N·m")
    momenta = [np.append(entry.momentum, entry.null_space) for entry in entries]
    largest = float(np.max(np.abs(momenta), initial=0.0))
    momentum, momentum_unit = scaled_unit(largest, "N·m·s", least=0)
    table = [
        (
            f"{entry.window[0]:g} to {entry.window[1]:g}",
            f"{entry.time:g} to {entry.time + entry.unloads:g}",
            _row(torque * entry.torque),
            _row(momentum * entry.momentum),
            f"{momentum * entry.null_space:.4g}",
        )
        for entry in entries
    ]
    return render(
        "speed_plan.html",
        result=result,
        scenario=result.scenario,
        lines=lines_of(result),
        charts=plan_charts(result),
        unloads=any(np.any(flight.unloading) for flight in flights),
        rows=rows,
        leaves=0 if result.plan.certificate is None else len(result.plan.certificate.leaves),
        entries=table,
        torque_unit=torque_unit,
        momentum_unit=momentum_unit,
        command=command,
    )


def _row(vector: Vector) -> str:
    return ", ".join(f"{value + 0.0:.4g}" for value in vector)


def write_plan(
    result: SpeedPlan, out: Path, *, command: str, say: Callable[[str], None], force: bool = False
) -> None:
    """Write plan.json, plan.toml and report.html.

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
        (folder / "report.html").write_text(page_of(result, command), encoding="utf-8")
    say("written: " + ", ".join(str(out / name) for name in FILES))
