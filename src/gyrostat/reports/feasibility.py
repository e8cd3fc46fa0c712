"""Files and text of the answer to a feasibility query."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gyrostat.core.outputs import new_files
from gyrostat.core.text import plain, triple
from gyrostat.core.types import Vector
from gyrostat.failures import Holdable, SkyMap, holdable_sky
from gyrostat.failures.attitude_words import turn_and_angles
from gyrostat.failures.attitudes import matrix_of
from gyrostat.failures.steps import NextStep
from gyrostat.reports.failure_inputs import (
    Inputs,
    Row,
    say_rows,
    say_steps,
    steps_content,
    unloading_rows,
)
from gyrostat.reports.sky_map import sky_chart
from gyrostat.reports.template import render
from gyrostat.spacecraft import SpacecraftFile

FILES = ("holdable.json", "report.html")


@dataclass(frozen=True)
class Question:
    """Feasibility query of a spacecraft.

    Attributes:
        file: Content of the spacecraft file.
        momentum: Total momentum, (3,), inertial axes, N·m·s.
        failed: Index of each failed wheel -> its momentum, N·m·s.
        target: Target attitude, (4,), or None if `towards` is given.
        towards: Inertial direction to point the boresight at, (3,), or None.
        boresight: Body direction of the sky map, (3,), or None for those of all axes.
        tolerance: Pointing tolerance, rad, or None.
        inputs: Inputs as they were understood.
    """

    file: SpacecraftFile
    momentum: Vector
    failed: Mapping[int, float]
    target: Vector | None
    towards: Vector | None
    boresight: Vector | None
    tolerance: float | None
    inputs: Inputs


@dataclass(frozen=True)
class Drawn:
    """Sky map with the inertial directions to mark on it, (3,) or None."""

    sky: SkyMap
    target: Vector | None
    nearest: Vector | None


def write_holdable(
    answer: Holdable,
    out: Path,
    *,
    steps: Sequence[NextStep] = (),
    fly: Mapping[str, Any] | None = None,
    command: str,
    say: Callable[[str], None],
    force: bool = False,
) -> str:
    """Write holdable.json and report.html, and print a summary.

    Args:
        answer: Answer with its question.
        out: Output folder.
        steps: What to do next.
        fly: What the page needs to be dragged, see `gyrostat.reports.sky_fly`; None: it is not.
        command: Command line that produced the answer.
        say: Called with each line of the summary.
        force: Whether to replace files that `holdable` did not write; see `gyrostat.core.outputs`.

    Returns:
        Text of holdable.json.

    Raises:
        InputError: A file of the user is in the way, or the folder cannot be written.
    """
    question, maps = answer.question, sky_maps(answer)
    content = {**_content(question, answer, maps), "next": steps_content(steps)}
    text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
    verdict, rows = verdict_of(question, answer), rows_of(question, answer)
    page = render(
        "holdable.html",
        question=question,
        answer=answer,
        verdict=verdict,
        inputs=question.inputs,
        rows=rows,
        steps=steps,
        fly=fly,
        wheels=_wheels(question, answer),
        maps=[
            (
                triple(sky_map.sky.boresight),
                sky_chart(sky_map.sky, target=sky_map.target, nearest=sky_map.nearest),
                share(sky_map.sky.fraction),
            )
            for sky_map in maps
        ],
        command=command,
    )
    with new_files(out, by="holdable", force=force) as folder:
        (folder / "report.html").write_text(page, encoding="utf-8")
        (folder / "holdable.json").write_text(text + "\n", encoding="utf-8")
    say_rows(question.inputs.rows(), say)
    for warning in question.inputs.warnings:
        say(f"warning: {warning}")
    say(verdict)
    say_rows(rows, say)
    for name, entry, limit in _wheels(question, answer):
        say(f"  wheel {name}: {entry}{limit and f', {limit}'}")
    for sky_map in maps:
        boresight = triple(sky_map.sky.boresight)
        say(f"  body direction {boresight} can be held at {share(sky_map.sky.fraction)} of the sky")
    say(f"written: {out / 'report.html'}, {out / 'holdable.json'}")
    say_steps(steps, say)
    return text


def sky_maps(answer: Holdable) -> list[Drawn]:
    """Sky map of the boresight, or of each body axis without one; none without the question."""
    question: Question | None = answer.question
    if answer.sky is not None:
        towards = None if question is None else question.towards
        return [Drawn(answer.sky, towards, answer.direction)]
    if question is None:
        return []
    axes = np.eye(3) if question.boresight is None else [question.boresight]
    craft, total, momenta = question.file.spacecraft, question.momentum, question.failed
    return [
        Drawn(
            holdable_sky(craft, total, failed=momenta, boresight=axis),
            _to_inertial(question.target, axis),
            _to_inertial(answer.attitude, axis),
        )
        for axis in axes
    ]


def _to_inertial(attitude: Vector | None, body: Vector) -> Vector | None:
    """Direction in inertial axes, from body axes."""
    return None if attitude is None else matrix_of(attitude) @ body


def answer_lines(answer: Holdable) -> list[str]:
    """The answer as lines of a terminal."""
    question: Question = answer.question
    lines = [verdict_of(question, answer)]
    lines += [f"  {name}: {entry}" for name, entry in rows_of(question, answer)]
    return lines + [
        f"  body direction {triple(drawn.sky.boresight)} can be held at "
        f"{share(drawn.sky.fraction)} of the sky"
        for drawn in sky_maps(answer)
    ]


def verdict_of(question: Question, answer: Holdable) -> str:
    """The answer in one sentence."""
    subject = "the target" if question.towards is None else "the direction"
    if answer.reason is not None:
        return f"NO attitude is feasible: {answer.reason}"
    if answer.holdable:
        return f"{subject} is feasible"
    near = "attitude" if question.towards is None else "direction"
    return f"{subject} is NOT feasible: the nearest feasible {near} is {degrees(answer.angle)} away"


def rows_of(question: Question, answer: Holdable) -> list[Row]:
    """The answer as pairs of name and entry."""
    names = question.file.wheel_names
    working = [name for k, name in enumerate(names) if k not in question.failed]
    rows = [
        (
            "working wheels",
            f"{', '.join(working) or 'none'}; their axes span {answer.rank} of 3 dimensions",
        ),
        ("total momentum", f"{triple(question.momentum)} N·m·s, inertial"),
    ]
    if answer.dimension is not None:
        note = "" if answer.dimension == 3 else ": rotation about the total momentum is always free"
        rows.append(("feasible attitudes", f"a set of dimension {answer.dimension}{note}"))
    if answer.attitude is not None:
        rows.append(("nearest attitude (scalar first)", triple(answer.attitude, 9)))
        rows.append(("nearest attitude in words", turn_and_angles(answer.attitude)))
    if answer.direction is not None:
        rows.append(("boresight direction there, inertial", triple(answer.direction, 6)))
    if answer.margin is not None:
        rows.append(("margin of the most loaded wheel", share(answer.margin)))
    if answer.controllable is not None:
        controllability = "yes" if answer.controllable else "NO: not to first order"
        rows.append(("attitude controllable there", controllability))
    for name, proof in (
        ("lower bound of the body rate, at the target", answer.at_target),
        ("lower bound of the body rate, at any attitude", answer.for_ever),
    ):
        if proof.rate > 0.0:
            along = f" along body {triple(proof.direction)}" if np.any(proof.direction) else ""
            excess = f"{plain(proof.excess)} N·m·s that the wheels cannot absorb{along}"
            rows.append((name, f"{degrees(proof.rate)}/s: {excess}"))
    if question.tolerance is not None and not answer.holdable:
        bound = f"at most {plain(answer.dwell)} s" if answer.dwell is not None else "no known bound"
        rows.append((f"stays within {degrees(question.tolerance)} of the target", bound))
    return rows + unloading_rows(answer.unload)


def _wheels(question: Question, answer: Holdable) -> list[tuple[str, str, str]]:
    """Name, momentum and remark for every wheel at the nearest feasible attitude."""
    if answer.wheel_momentum is None:
        return []
    array = question.file.spacecraft.wheels
    limits = np.broadcast_to(np.asarray(array.momentum_limit), len(question.file.wheel_names))
    rows = []
    for k, (name, value) in enumerate(
        zip(question.file.wheel_names, answer.wheel_momentum, strict=True)
    ):
        note = f"{share(abs(value) / limits[k])} of its limit" if np.isfinite(limits[k]) else ""
        rows.append((name, f"{value:.4f} N·m·s", "failed" if k in question.failed else note))
    return rows


def _content(question: Question, answer: Holdable, maps: Sequence[Drawn]) -> dict[str, Any]:
    """Content of holdable.json, SI units and radians."""
    names = question.file.wheel_names
    content = answer.to_dict()
    if answer.wheel_momentum is not None:
        content["wheel_momentum"] = dict(zip(names, answer.wheel_momentum.tolist(), strict=True))
    content["sky"] = [
        {
            "boresight": sky_map.sky.boresight.tolist(),
            "momentum_direction": sky_map.sky.momentum_direction.tolist(),
            "bands": sky_map.sky.bands.tolist(),
            "fraction": sky_map.sky.fraction,
        }
        for sky_map in maps
    ]
    return {
        "spacecraft": question.file.name,
        "momentum": question.momentum.tolist(),
        "failed": {names[k]: value for k, value in question.failed.items()},
        "target": None if question.target is None else question.target.tolist(),
        "towards": None if question.towards is None else question.towards.tolist(),
        "tolerance": question.tolerance,
        "inputs": question.inputs.to_dict(),
        **content,
    }


def degrees(angle: float | None) -> str:
    """Format an angle given in rad as degrees."""
    return "–" if angle is None else f"{plain(float(np.degrees(angle)))} deg"


def share(value: float) -> str:
    """Format a fraction in per cent."""
    return f"{100.0 * value:.1f} %"
