"""What the heads of a star tracker see along the reference of a scenario."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.text import plain
from gyrostat.runs.blind_windows import percent
from gyrostat.runs.build import Setup
from gyrostat.runs.reference_path import (
    ReferencePath,
    longest_outage,
    nominal_setup,
    reference_path,
    waits_for_measurement,
)
from gyrostat.scenario.metrics.tracker_view import HEADS, LEAST, heads_of
from gyrostat.scenario.scenario import Scenario
from gyrostat.spacecraft import BodyMotion
from gyrostat.spacecraft.sensors.keep_out import BODIES
from gyrostat.spacecraft.sensors.star_tracker_heads import (
    Blinding,
    StarTrackerHead,
    StarTrackerHeads,
)

CAUSES = {**BODIES, "rate": "the body rate"}
"""Field of `Blinding` -> its name in a sentence."""


class TrackerForecast(NamedTuple):
    """View of a star tracker along the reference, in a window or in the whole run.

    Attributes:
        window: Name of the window; None: whole run.
        availability: Fraction of time in which a head is not blind.
        outage: Longest time in which all are blind, s; counted from its start in the window.
        heads: Name of a head -> fraction of time in which it is not blind.
        causes: Name of a head -> cause -> fraction of time in which it blinds the head.
    """

    window: str | None
    availability: float
    outage: float
    heads: dict[str, float]
    causes: dict[str, dict[str, float]]


def tracker_forecasts(scenario: Scenario) -> list[TrackerForecast]:
    """View of the star tracker in the run and in each window that the reference enters.

    Args:
        scenario: Scenario; without star tracker heads, there is no forecast.
    """
    if not heads_of(scenario.parts):
        return []
    path = reference_path(scenario)
    blinding = _blinding(path, heads_of_run(nominal_setup(scenario)))
    blind = np.any(np.array(blinding), axis=0)
    names = [part.name for part in scenario.parts if part.section == HEADS]
    intervals = {None: np.ones(len(path.time), bool), **path.windows}
    return [
        _forecast(window, rows, names, blinding, blind, path.step)
        for window, rows in intervals.items()
        if np.any(rows)
    ]


def tracker_lines(scenario: Scenario) -> tuple[list[str], list[str]]:
    """Lines on what the star tracker sees along the reference: a list, and warnings."""
    lines, warnings = [], []
    forecasts = tracker_forecasts(scenario)
    if forecasts and waits_for_measurement(nominal_setup(scenario)):
        lines.append(
            "star tracker along the reference: modes that wait for a measured rate, error or "
            "momentum end early here, and those after them begin early; `simulate` flies them"
        )
    for each in forecasts:
        interval = "the run" if each.window is None else f"window {each.window}"
        shares = ", ".join(f"{name} {percent(share)}" for name, share in each.heads.items())
        lines.append(
            f"star tracker along the reference, {interval}: {percent(each.availability)} of the "
            f"time, longest outage {plain(each.outage)} s; heads: {shares}"
        )
        least = scenario.values[LEAST]
        if each.window is not None and each.availability < least:
            worst = ", ".join(
                f"{name} by {CAUSES[cause]} in {percent(share)}"
                for name, causes in each.causes.items()
                for cause, share in causes.items()
                if share > 0.0
            )
            warnings.append(
                f"warning: window {each.window}: found a star tracker that sees in "
                f"{percent(each.availability)} of the time along the reference, expected "
                f"{percent(least)} (metrics.least_availability); blinded: {worst}"
            )
    return lines, warnings


def heads_of_run(setup: Setup) -> tuple[StarTrackerHead, ...]:
    """Heads of the star tracker of a run; empty without any.

    Args:
        setup: Parts of the run.
    """

    def is_tracker(part: object) -> bool:
        return isinstance(part, StarTrackerHeads)

    parts = jax.tree.leaves(setup.sensor, is_leaf=is_tracker)
    return next((part.heads for part in parts if isinstance(part, StarTrackerHeads)), ())


def _blinding(path: ReferencePath, heads: tuple[StarTrackerHead, ...]) -> Blinding:
    """What blinds each head along the path, (heads, rows) each."""
    motion = BodyMotion(jnp.asarray(path.attitude), jnp.asarray(path.rate))
    each = [jax.jit(jax.vmap(head.blinding))(motion, path.time) for head in heads]
    return Blinding(*(jnp.stack(rows) for rows in zip(*each, strict=True)))


def _forecast(
    window: str | None,
    rows: Bool[np.ndarray, " rows"],
    names: list[str],
    blinding: Blinding,
    blind: Bool[np.ndarray, "heads rows"],
    step: float,
) -> TrackerForecast:
    is_out = np.all(blind, axis=0)
    return TrackerForecast(
        window,
        1.0 - float(np.mean(is_out[rows])),
        longest_outage(~(is_out & rows), step),
        {name: 1.0 - float(np.mean(blind[k][rows])) for k, name in enumerate(names)},
        {
            name: {cause: float(np.mean(getattr(blinding, cause)[k][rows])) for cause in CAUSES}
            for k, name in enumerate(names)
        },
    )
