"""Batch identification of a wheel from records of current and speed."""

from collections.abc import Callable, Collection, Mapping, Sequence

from gyrostat.core.errors import InputError
from gyrostat.identification.automatic import AUTO, solve_automatically
from gyrostat.identification.fit.prediction import CurrentHold
from gyrostat.identification.fit.problem import Problem
from gyrostat.identification.fit.stages import Progress
from gyrostat.identification.result.fit import Fit
from gyrostat.identification.uncertainty.posterior_sampler import check_sampler
from gyrostat.identification.unsampled import solve
from gyrostat.telemetry import Record
from gyrostat.wheel.friction_laws import Law


def identify(
    records: Record | Sequence[Record],
    *,
    inertia: float | None = None,
    model: str | Law = "stribeck",
    hold: Mapping[str, float | None] | None = None,
    free: Collection[str] = (),
    prior: Mapping[str, tuple[float, float]] | None = None,
    start: Mapping[str, float] | None = None,
    speed_sigma: float | Sequence[float] | None = None,
    loss: str = "quadratic",
    current_hold: CurrentHold = "zero-order",
    max_iterations: int | None = None,
    on_progress: Progress | None = None,
    tolerance: Mapping[str, float] | None = None,
    white_noise: bool = False,
    include: Collection[str] = (),
    ripple: float | None = None,
    posterior: bool = False,
    current_quantum: float | None = None,
    speed_quantum: float | None = None,
    loop: str | None = None,
    on_draws: Callable[[int], None] = lambda count: None,
) -> Fit:
    """Identify a wheel from one or several records, fitted together.

    Carrara and Kuga, eqs. (3)-(16). By default the motor constant and the friction torques are
    estimated, with the initial speed of each record; inertia, current_bias and the Stribeck speed
    are held.

    The model is linearised at the least-squares fit. Estimates and uncertainty are then averaged
    over hypotheses on effects outside the model (`gyrostat.identification.uncertainty.averaging`).

    Args:
        records: Records of one wheel.
        inertia: Rotor inertia, kg·m²; held unless `free` names it.
        model: Name of the friction model, a class of your own or "FILE.py:CLASS"; or "auto": the
            simplest one, with the effects that the diagnosis finds
            (`gyrostat.identification.automatic`).
        hold: Name -> value at which it is held, SI, or None for its default.
        free: Names of further parameters to estimate.
        prior: Name -> a-priori mean and standard deviation, SI; the parameter is then estimated.
            All other parameters have a very wide a-priori distribution, which keeps the problem
            regular.
        start: Name -> start value, SI; by default the a-priori mean or a value from the records.
        speed_sigma: Standard deviation of the measured speed, rad/s, one for all records or one for
            each. By default it is estimated from the residuals of each record. All sigmas scale
            with it.
        loss: "quadratic", "huber" or "student".
        current_hold: Current between samples, "zero-order" or "linear".
        max_iterations: Largest number of iterations from one start, over all stages; by default
            `gyrostat.identification.solve.DEFAULT_ITERATIONS`.
        on_progress: Called after each iteration with the stage, the iteration count and the cost.
        tolerance: Name -> relative standard deviation of a given value: "inertia", "current_scale",
            "speed_scale", "clock" (true over recorded time).
        white_noise: Whether to assume that the friction model with white noise is exact (plain
            least squares). The resulting uncertainty is too small for real wheels.
        include: Names of further effects to average over, as the diagnosis names them.
        ripple: Torque ripple at breakaways and zero crossings, rms over the dry friction torque. By
            default it is averaged over with the other effects; few crossings hardly tell it.
        posterior: Whether to sample the posterior too
            (`gyrostat.identification.uncertainty.posterior`).
        current_quantum: Step to which the recorded current was rounded, A; 0: not rounded. By
            default it is found.
        speed_quantum: Step to which the recorded speed was rounded, rad/s; 0: not rounded. By
            default it is found.
        loop: "open" or "closed" if it is known whether the current depends on the measured speed;
            by default the residuals are tested for feedback.
        on_draws: Called with the number of draws of the posterior so far.

    Returns:
        The fit; `converged` says whether it is valid.

    Raises:
        InputError: The arguments or the records do not allow an estimate.
    """
    problem = Problem.of(
        records,
        inertia=inertia,
        model=model,
        hold=hold,
        free=free,
        prior=prior,
        start=start,
        speed_sigma=speed_sigma,
        loss=loss,
        current_hold=current_hold,
        max_iterations=max_iterations,
        tolerance=tolerance,
        white_noise=white_noise,
        include=include,
        ripple=ripple,
        posterior=posterior,
        current_quantum=current_quantum,
        speed_quantum=speed_quantum,
        loop=loop,
    )
    return identify_problem(problem, on_progress=on_progress, on_draws=on_draws)


def identify_problem(
    problem: Problem,
    *,
    on_progress: Progress | None = None,
    on_draws: Callable[[int], None] = lambda count: None,
) -> Fit:
    """Identify a wheel; `identify` takes the fields of the problem as arguments.

    Args:
        problem: The problem.
        on_progress: As for `identify`.
        on_draws: As for `identify`.

    Raises:
        InputError: As for `identify`.
    """
    automatic = problem.model == AUTO
    if problem.posterior:
        check_sampler()
        if automatic or problem.loss != "quadratic":
            raise InputError(
                "--posterior: found --model auto or --loss, expected one friction model and the "
                "quadratic loss"
            )
    if automatic:
        return solve_automatically(problem, on_progress=on_progress)
    return solve(problem, on_progress=on_progress, on_draws=on_draws)
