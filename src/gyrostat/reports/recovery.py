"""Files and text of a recovery."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from gyrostat.core.outputs import new_files
from gyrostat.failures import BrakeGain, Loss, Recovery
from gyrostat.failures.recovery import ANGLE, RATE
from gyrostat.reports.drawing import MARK, STYLE, literal, svg
from gyrostat.reports.feasibility import degrees, triple
from gyrostat.reports.template import render
from gyrostat.spacecraft import SpacecraftFile

if TYPE_CHECKING:
    import xarray as xr

FILES = ("recover.json", "report.html", "run.nc")
LEAST_SHOWN = 1e-7
"""Smallest value drawn, deg or deg/s."""


def write_recovery(
    file: SpacecraftFile,
    found: Recovery,
    losses: Mapping[int, Loss],
    out: Path,
    *,
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
        **found.to_dict(names),
    }
    text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
    verdict, rows = verdict_of(found), rows_of(file, found, losses)
    flight = found.flight
    figure = None if flight is None else svg(recovery_figure(flight, names, found.settle))
    page = render(
        "recovery.html",
        file=file,
        found=found,
        verdict=verdict,
        rows=rows,
        figure=figure,
        command=command,
    )
    with new_files(out, by="recover", force=force) as folder:
        if flight is not None:
            flight.to_netcdf(folder / "run.nc", engine="h5netcdf")
        (folder / "report.html").write_text(page, encoding="utf-8")
        (folder / "recover.json").write_text(text + "\n", encoding="utf-8")
    say(verdict)
    for name, entry in rows:
        say(f"  {name}: {entry}")
    written = ["report.html", "recover.json", *([] if flight is None else ["run.nc"])]
    say(f"written: {', '.join(str(out / name) for name in written)}")
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
    told = (f"{file.wheel_names[k]} {loss.kind}" for k, loss in losses.items())
    rows = [("failed", ", ".join(told))]
    if answer.attitude is not None:
        rows += [
            ("nearest feasible attitude", f"{degrees(answer.angle)} from the target"),
            ("nearest attitude (scalar first)", triple(answer.attitude, 9)),
        ]
    for wheel, time in found.earliest.items():
        rows.append((_slowing(file.wheel_names[wheel], losses[wheel]), _settled_after(time)))
    for wheel, gain in found.gains.items():
        name = file.wheel_names[wheel]
        option = f"--brake {name}={gain.torque:g}N·m"
        rows.append((f"if the motor of {name} can brake", f"{_would_bring(gain)} ({option})"))
    if found.without_brakes is not None:
        rows.append(("without the brake", _without(found.without_brakes)))
    if found.plan.controller is not None:
        rows.append(("law", type(found.plan.controller).__name__))
    if found.flight is not None:
        flight = found.flight
        rows += [
            ("error at the end", degrees(float(flight.error.values[-1]))),
            ("criterion for settled", f"below {degrees(ANGLE)} and {RATE:g} rad/s to the end"),
            ("largest wheel torque", f"{float(np.max(np.abs(flight.torque.values))):.3g} N·m"),
            (
                "largest wheel momentum",
                f"{float(np.max(np.abs(flight.wheel_momentum.values))):.3g} N·m·s",
            ),
        ]
    return rows


def _slowing(name: str, loss: Loss) -> str:
    if loss.brake_torque:
        return f"{name} braked by {loss.brake_torque:g} N·m"
    if loss.brake_time:
        return f"{name} braked with the time constant {loss.brake_time:g} s"
    return f"{name} runs down"


def _settled_after(time: float) -> str:
    return f"under any controller, not settled before about {time:.3g} s"


def _would_bring(gain: BrakeGain) -> str:
    time = "" if gain.earliest is None else f", not settled before about {gain.earliest:.3g} s"
    return f"{_nearest(gain.angle)}{time}"


def _nearest(angle: float | None) -> str:
    if angle is None:
        return "no feasible attitude"
    return f"nearest feasible attitude {degrees(angle)} from the target"


def _without(other: Recovery) -> str:
    settled = other.reason if other.settle is None else f"settled at {other.settle:g} s"
    answer = other.plan.answer
    return f"{settled}; {_nearest(None if answer.attitude is None else answer.angle)}"


def recovery_figure(flight: "xr.Dataset", names: tuple[str, ...], settle: float | None) -> Figure:
    """Plot error, body rate, wheel momenta and torques over the time since the failure.

    Args:
        flight: Histories from `gyrostat.failures.recover`.
        names: Names of the wheels.
        settle: Settling time, s, or None.
    """
    time = flight.time.values
    rate = np.degrees(np.linalg.norm(flight.rate.values, axis=1))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 7.0))
        figure.subplots_adjust(left=0.09, right=0.98, bottom=0.07, top=0.985, hspace=0.14)
        rows = figure.subplots(4, 1, sharex=True, height_ratios=[1.5, 1.0, 1.3, 1.0])
        error = np.degrees(flight.error.values)
        for axes, values, limit, label in (
            (rows[0], error, np.degrees(ANGLE), "error (deg)"),
            (rows[1], rate, np.degrees(RATE), "body rate (deg/s)"),
        ):
            axes.semilogy(time, np.maximum(values, LEAST_SHOWN), lw=1.3)
            axes.axhline(limit, color=MARK, lw=0.9, ls="--", label="settled below")
            axes.set_ylabel(label)
        rows[0].legend(loc="upper right")
        for wheel, name in enumerate(map(literal, names)):
            rows[2].plot(time, flight.wheel_momentum.values[:, wheel], lw=1.2, label=name)
            rows[3].step(time, flight.torque.values[:, wheel], where="post", lw=0.9, label=name)
        rows[2].legend(loc="upper right", ncols=len(names), title="wheel")
        rows[2].set_ylabel("momentum (N·m·s)")
        rows[3].set_ylabel("torque command (N·m)")
        rows[3].set_xlabel("time since the failure (s)")
        if settle is not None:
            for axes in rows:
                axes.axvline(settle, color="#6b7077", lw=0.9, ls=":")
    return figure
