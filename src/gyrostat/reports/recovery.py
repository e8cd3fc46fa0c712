"""Files and text of a recovery."""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gyrostat.core.outputs import new_files
from gyrostat.core.text import triple
from gyrostat.failures import BrakeGain, Loss, Recovery
from gyrostat.failures.attitude_words import turn_and_angles
from gyrostat.failures.momentum_drift import MomentumDrift
from gyrostat.failures.recovery import ANGLE, RATE
from gyrostat.failures.steps import NextStep
from gyrostat.reports.chart import Chart
from gyrostat.reports.failure_inputs import (
    Inputs,
    say_rows,
    say_steps,
    steps_content,
    unloading_rows,
)
from gyrostat.reports.feasibility import degrees
from gyrostat.reports.page_units import shown_unit, told
from gyrostat.reports.template import render
from gyrostat.reports.time_chart import held, time_chart
from gyrostat.spacecraft import SpacecraftFile

FILES = ("recover.json", "report.html", "run.nc")
LEAST_SHOWN = 1e-7
"""Smallest value drawn, deg or deg/s."""
MOST_POINTS = 1200
"""Largest number of points of a curve."""


def write_recovery(
    file: SpacecraftFile,
    found: Recovery,
    losses: Mapping[int, Loss],
    out: Path,
    *,
    inputs: Inputs,
    steps: Sequence[NextStep] = (),
    command: str,
    say: Callable[[str], None],
    force: bool = False,
) -> str:
    """Write recover.json, report.html and, if simulated, run.nc, and print a summary.

    Args:
        file: Content of the spacecraft file.
        found: The recovery.
        losses: Index of each failed wheel -> its failure.
        out: Output folder.
        inputs: Inputs as they were understood.
        steps: What to do next.
        command: Command line that produced the recovery.
        say: Called with each line of the summary.
        force: Whether to replace files that `recover` did not write; see `gyrostat.core.outputs`.

    Returns:
        Text of recover.json.

    Raises:
        InputError: A file of the user is in the way, or the folder cannot be written.
    """
    names = file.wheel_names
    content: dict[str, Any] = {
        "spacecraft": file.name,
        "failed": {names[k]: loss.kind for k, loss in losses.items()},
        "inputs": inputs.to_dict(),
        **found.to_dict(names),
        "next": steps_content(steps),
    }
    text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
    verdict, rows = verdict_of(found), rows_of(file, found, losses)
    histories = found.histories
    charts = [] if histories is None else recovery_charts(histories.arrays(), names, found.settle)
    page = render(
        "recovery.html",
        file=file,
        found=found,
        verdict=verdict,
        inputs=inputs,
        rows=rows,
        steps=steps,
        charts=charts,
        command=command,
    )
    with new_files(out, by="recover", force=force) as folder:
        if histories is not None:
            histories.write(folder / "run.nc")
        (folder / "report.html").write_text(page, encoding="utf-8")
        (folder / "recover.json").write_text(text + "\n", encoding="utf-8")
    say_rows(inputs.rows(), say)
    for warning in inputs.warnings:
        say(f"warning: {warning}")
    say(verdict)
    say_rows(rows, say)
    files = ["report.html", "recover.json", *([] if histories is None else ["run.nc"])]
    say(f"written: {', '.join(str(out / name) for name in files)}")
    say_steps(steps, say)
    return text


def verdict_of(found: Recovery) -> str:
    """The outcome in one sentence."""
    if found.settle is None:
        return f"NOT recovered: {found.reason}"
    return f"recovered: at rest at a feasible attitude {found.settle:g} s after the failure"


def rows_of(
    file: SpacecraftFile, found: Recovery, losses: Mapping[int, Loss]
) -> list[tuple[str, str]]:
    """The outcome as pairs of name and entry."""
    answer = found.plan.answer
    rows: list[tuple[str, str]] = []
    if answer.attitude is not None:
        rows += [
            ("nearest feasible attitude", f"{degrees(answer.angle)} from the target"),
            ("nearest attitude (scalar first)", triple(answer.attitude, 9)),
            ("nearest attitude in words", turn_and_angles(answer.attitude)),
        ]
    if found.drift is not None:
        rows += drift_rows(found.drift)
    for wheel, time in found.earliest.items():
        bound = f"under any controller, not settled before about {time:.3g} s"
        rows.append((_slowing(file.wheel_names[wheel], losses[wheel]), bound))
    for wheel, gain in found.gains.items():
        name = file.wheel_names[wheel]
        option = f"--brake {name}={gain.torque:g}N·m"
        rows.append((f"if the motor of {name} can brake", f"{_would_bring(gain)} ({option})"))
    if found.without_brakes is not None:
        rows.append(("without the brake", _text_without_brake(found.without_brakes)))
    if found.plan.controller is not None:
        rows.append(("law", type(found.plan.controller).__name__))
    if found.histories is not None:
        flight = found.histories.arrays()
        beyond = " to the end" if found.drift is None else " above the rate of the drift to the end"
        rows += [
            (
                "error at the end" if found.drift is None else "error to what is feasible then",
                degrees(float(flight["error"][-1])),
            ),
            ("criterion for settled", f"below {degrees(ANGLE)} and {told(RATE, 'rad/s')}{beyond}"),
            ("largest wheel torque", told(_largest(flight["torque"]), "N·m", 3)),
            ("largest wheel momentum", told(_largest(flight["wheel_momentum"]), "N·m·s", 3)),
        ]
    return rows + unloading_rows(answer.unload)


def _largest(history: Any) -> float:
    return float(np.max(np.abs(np.asarray(history))))


def drift_rows(drift: MomentumDrift) -> list[tuple[str, str]]:
    """External torque and what it makes of the feasible attitude, as pairs of name and entry."""
    size = float(np.linalg.norm(drift.torque))
    change = f"the total momentum changes by {drift.momentum:.3g} N·m·s in the simulated time"
    if drift.angle is None:
        outcome = "no attitude is feasible at the end"
    else:
        outcome = f"the feasible attitude drifts by about {degrees(drift.angle)} until the end"
    return [
        ("external torque", f"{told(size, 'N·m', 3)}: {change}"),
        ("drift to be expected", outcome),
    ]


def _slowing(name: str, loss: Loss) -> str:
    if loss.brake_torque:
        return f"{name} braked by {told(loss.brake_torque, 'N·m')}"
    if loss.brake_time:
        return f"{name} braked with the time constant {loss.brake_time:g} s"
    return f"{name} runs down"


def _would_bring(gain: BrakeGain) -> str:
    time = "" if gain.earliest is None else f", not settled before about {gain.earliest:.3g} s"
    return f"{_nearest(gain.angle)}{time}"


def _nearest(angle: float | None) -> str:
    if angle is None:
        return "no feasible attitude"
    return f"nearest feasible attitude {degrees(angle)} from the target"


def _text_without_brake(recovery: Recovery) -> str:
    outcome = recovery.reason if recovery.settle is None else f"settled at {recovery.settle:g} s"
    answer = recovery.plan.answer
    return f"{outcome}; {_nearest(None if answer.attitude is None else answer.angle)}"


def recovery_charts(
    flight: Mapping[Any, Any], names: Sequence[str], settle: float | None
) -> list[Chart]:
    """Error, body rate, wheel momenta and torques over the time since the failure.

    Args:
        flight: Histories of the run: name -> array, or what can be converted to one.
        names: Names of the wheels.
        settle: Settling time, s, or None.
    """
    time, momentum, torque = (
        np.asarray(flight[name]) for name in ("time", "wheel_momentum", "torque")
    )
    factor, unit = shown_unit("N·m")
    sizes = np.asarray(flight["error"]), np.linalg.norm(np.asarray(flight["rate"]), axis=1)
    error, rate = (np.maximum(np.degrees(each), LEAST_SHOWN)[:, None] for each in sizes)
    charts = [
        time_chart(time, error, "error (deg)", ["error"], MOST_POINTS, is_log=True),
        time_chart(time, rate, "body rate (deg/s)", ["rate"], MOST_POINTS, is_log=True),
        time_chart(time, momentum, "wheel momentum (N·m·s)", names, MOST_POINTS),
        time_chart(*held(time, factor * torque), f"torque command ({unit})", names, MOST_POINTS),
    ]
    for chart, limit in zip(charts, (ANGLE, RATE), strict=False):
        chart.level(float(np.degrees(limit)), "settled below", "required")
    for k, chart in enumerate(charts):
        chart.attributes["group"] = "recovery"
        if settle is not None:
            chart.level(settle, "settled" if k == 0 else "", "event", across=False)
    return charts
