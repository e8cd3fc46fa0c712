"""Solution of a problem whose current may step between two samples.

Slow telemetry does not tell when a current has stepped. If a record shows that its steps did not
happen at its samples, the motion in these intervals is unknown: the record is cut there, and every
segment has an initial speed of its own.
"""

from collections.abc import Callable
from dataclasses import replace

from gyrostat.core.errors import InputError
from gyrostat.identification.fit.problem import Problem
from gyrostat.identification.fit.stages import Progress
from gyrostat.identification.read.current_steps import cut_at_steps
from gyrostat.identification.result.fit import Fit
from gyrostat.identification.solve import LONG, solve_as_sampled
from gyrostat.identification.uncertainty.current_errors import STEPS
from gyrostat.telemetry import cut


def solve(
    problem: Problem,
    *,
    on_progress: Progress | None = None,
    on_draws: Callable[[int], None] = lambda count: None,
) -> Fit:
    """Solve a problem with one friction model.

    Args:
        problem: The problem.
        on_progress: As for `identify`.
        on_draws: As for `identify`.

    Returns:
        The fit; `converged` says whether it is valid.

    Raises:
        InputError: The problem or its records do not allow an estimate.
    """

    def attempt(each: Problem) -> Fit | InputError:
        try:
            return solve_as_sampled(each, on_progress=on_progress, on_draws=on_draws)
        except InputError as fault:
            return fault

    first = attempt(problem)
    held = problem.current_hold == "zero-order" and not problem.white_noise
    # slow telemetry has few samples
    held = held and all(len(record.time) <= LONG for record in problem.records)
    records = cut_at_steps([cut(record) for record in problem.records]) if held else None
    if records is not None and _shows_steps(first):
        again = attempt(replace(problem, records=records))
        if not isinstance(again, InputError) and again.converged and not again.impossible:
            count = sum(len(r.segments) for r in records)
            text = (
                f"the current steps between the samples: the record is cut there, into {count} "
                "segments with their own initial speed"
            )
            return replace(again, warnings=(*again.warnings, text))
    if isinstance(first, InputError):
        raise first
    return first


def _shows_steps(fit: Fit | InputError) -> bool:
    """Whether steps of the current at the samples do not explain a record."""
    if isinstance(fit, InputError) or not fit.converged or fit.impossible:
        return True
    return any(effect.name == STEPS and effect.likely for effect in fit.effects)
