"""Part of a page on which target and momentum of a sky map are dragged, and wheels fail."""

import base64
import gzip
import json
from collections.abc import Callable
from typing import Any

import numpy as np

from gyrostat.codegen.numpy_tracing import with_jax
from gyrostat.codegen.simd.batch import traced
from gyrostat.codegen.simd.web import require_web_compiler, web_assembly
from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.failures.held_bands import MOST_BANDS, held_bands, nearest_on_bands, padded
from gyrostat.failures.query import Case
from gyrostat.failures.roll_certificate import roll_certificate
from gyrostat.reports.feasibility import Question
from gyrostat.reports.sky_map import ACROSS, MIDDLE, UP

MOST_WHEELS = 6
"""Largest number of wheels: the page has the feasible directions of each set of them."""


def check_sky_fly(question: Question, body: Vector | None) -> Vector:
    """Boresight of a question whose page can be dragged.

    Raises:
        InputError: There is no boresight with a direction, too many wheels, or no momentum.
    """
    count = len(question.file.wheel_names)
    if body is None or question.towards is None:
        raise InputError("--fly: found no --boresight with --towards, expected both")
    if count > MOST_WHEELS:
        raise InputError(f"--fly: found {count} wheels, expected at most {MOST_WHEELS}")
    if Case.of(question.file.spacecraft, question.momentum, question.failed).radius == 0.0:
        raise InputError("--fly: found no momentum, with which every direction is alike")
    return body


def sky_fly_content(
    question: Question, body: Vector, spacecraft: str, say: Callable[[str], None]
) -> dict[str, Any]:
    """What the template of such a page needs; without a compiler, only the text why not, "lacking".

    Args:
        question: Query of a boresight; see `check_sky_fly`.
        body: Boresight, unit vector (3,).
        spacecraft: Path of the spacecraft file, for commands.
        say: Called with a line if there is no compiler.
    """
    try:
        require_web_compiler()
        module = web_assembly({"nearest": _nearest(), "certificate": _certificate(question, body)})
    except InputError as error:
        say(f"warning: the page cannot fly: {error}")
        return {"lacking": str(error)}
    craft, kept = question.file.spacecraft, question.failed
    sets = held_bands(craft, question.momentum, kept, body)
    if any(len(each.sky.bands) > MOST_BANDS for each in sets):
        raise InputError(f"--fly: found more than {MOST_BANDS} bands, expected fewer")
    wheels = craft.wheels
    axes, count = np.asarray(wheels.axes, dtype=float), wheels.count
    limits = np.broadcast_to(np.asarray(wheels.momentum_limit, dtype=float), count)
    rows = {
        sum(1 << k for k in each.failed): {
            "edges": edges.ravel().tolist(),
            "points": points.ravel().tolist(),
            "bands": len(each.sky.bands),
            "fraction": each.sky.fraction,
            "reason": each.reason,
            # JSON has no infinity: none is no limit
            "limits": [
                0.0 if k in each.failed else None if np.isinf(limits[k]) else limits[k]
                for k in range(count)
            ],
            "frozen": sum(
                (axes[:, k] * kept.get(k, 0.0) for k in each.failed), np.zeros(3)
            ).tolist(),
        }
        for each, (edges, points) in zip(sets, map(padded, sets), strict=True)
    }
    towards = question.towards
    assert towards is not None
    about = {
        "names": question.file.wheel_names,
        "kept": [kept.get(k, 0.0) for k in range(count)],
        "failed": sum(1 << k for k in kept),
        "body": body.tolist(),
        "momentum": question.momentum.tolist(),
        "towards": (towards / np.linalg.norm(towards)).tolist(),
        "sets": [rows[k] for k in range(len(rows))],
        "spacecraft": spacecraft,
        "map": [*MIDDLE, ACROSS, UP],
    }
    return {
        "about": json.dumps(about, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c"),
        "module": base64.b64encode(gzip.compress(module, 9, mtime=0)).decode(),
        "wheels": question.file.wheel_names,
    }


def _certificate(question: Question, body: Vector) -> str:
    """C of `roll_certificate` for a spacecraft."""
    craft = question.file.spacecraft
    axes = np.asarray(craft.wheels.axes, dtype=float)
    function = roll_certificate(np.asarray(craft.inertia, dtype=float), axes, body)
    arguments = [np.zeros((1, size)) for size in (3, 3, craft.wheels.count, 3)]
    return traced(function, (True,) * len(arguments), arguments).text


def _nearest() -> str:
    """C of `nearest_on_bands`."""
    shapes = [(3,), (3,), (3,), (MOST_BANDS, 2), (MOST_BANDS, 2, 3)]
    arguments = [np.zeros((1, *shape)) for shape in shapes]
    return traced(with_jax(nearest_on_bands), (True,) * len(shapes), arguments).text
