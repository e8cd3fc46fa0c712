"""Batch identification of a wheel from records of current and speed, in stages.

First viscous and Coulomb friction with T_s = c, which has no trap to fall into; then everything.
A trial in which the modelled wheel rests while the real one turns is refused: from there no
gradient leads back. The final fit has no bound: an estimate T_s < c is legitimate noise.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from gyrostat._types import Vector
from gyrostat.errors import InputError
from gyrostat.friction import Friction
from gyrostat.identify.checks import check_excitation, check_signals
from gyrostat.identify.conclude import conclude
from gyrostat.identify.deterministic import integral_regression
from gyrostat.identify.fit import Fit
from gyrostat.identify.least_squares import WALL, Evaluation, Prior, Solution, minimise
from gyrostat.identify.loss import Loss, Quadratic, loss_named
from gyrostat.identify.prediction import CurrentHold, SpeedPrediction, friction_model
from gyrostat.identify.selection import Selection, select
from gyrostat.identify.statistics import NORMAL_MAD, noise_level
from gyrostat.telemetry import Record

Progress = Callable[[str, int, float], None]

STAGE_TOLERANCE = 50.0
"""Standard deviations: the first stage only has to come this close."""

DEFAULT_ITERATIONS = 50
NUMERICAL_NOISE = 1e-6
"""Of the modelled speed, as a share of its level: no record is taken to be more exact."""


class _Measurements:
    """Whitened residuals of all records as a function of all parameters."""

    def __init__(self, prediction: SpeedPrediction, sigma: float) -> None:
        self.prediction = prediction
        self.sigma = sigma

    def __call__(self, values: Vector) -> Evaluation | None:
        predicted = self.prediction(values)
        if predicted is None or self.prediction.stuck(predicted, self.sigma):
            return None
        pairs = list(zip(self.prediction.records, predicted, strict=True))
        residual = np.concatenate([(r.speed - speed)[r.valid] for r, (speed, _) in pairs])
        jacobian = np.vstack([rows[r.valid] for r, (_, rows) in pairs])
        return residual / self.sigma, jacobian / self.sigma


class _CoulombStage:
    """All friction parameters as functions of one viscous coefficient and one Coulomb torque."""

    def __init__(self, prediction: SpeedPrediction, selection: Selection) -> None:
        model: type[Friction] = prediction.model
        zero, per_viscous, per_coulomb = (
            np.array([float(v) for v in model.from_coulomb(*point).parameters().values()])
            for point in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
        )
        self.prediction, self.selection = prediction, selection
        friction = list(model.dimensions())
        rest = [n for n in selection.free if n not in friction]
        columns = [np.eye(len(prediction.names))[prediction.names.index(n)] for n in rest]
        start = [selection.values[prediction.names.index(n)] for n in rest]
        mean = [selection.prior.mean[selection.free.index(n)] for n in rest]
        sigma = [selection.prior.sigma[selection.free.index(n)] for n in rest]
        self.offset = selection.values.copy()
        for tie in (per_viscous - zero, per_coulomb - zero):
            tied = [n for n, t in zip(friction, tie, strict=True) if t != 0.0]
            leading = [n for n in tied if n not in model.vanishing_at]
            column = np.zeros(len(prediction.names))
            column[[prediction.names.index(n) for n in tied]] = 1.0
            places = [selection.free.index(n) for n in leading if n in selection.free]
            first = float(np.mean(selection.values[[prediction.names.index(n) for n in leading]]))
            self.offset[column != 0.0] = 0.0 if places else first
            if places:
                columns.append(column)
                start.append(first)
                mean.append(float(np.mean(selection.prior.mean[places])))
                sigma.append(float(np.min(selection.prior.sigma[places])))
        self.map = np.column_stack(columns) if columns else np.zeros((len(self.offset), 0))
        self.start = np.array(start)
        self.prior = Prior(np.array(mean), np.array(sigma))

    def values(self, reduced: Vector) -> Vector:
        """All parameters of the prediction."""
        return self.offset + self.map @ reduced

    def final_start(self, reduced: Vector) -> Vector:
        """All parameters to go on from: held ones as held, free ones as this stage left them."""
        held = np.array([name not in self.selection.free for name in self.prediction.names])
        return np.where(held, self.selection.values, self.values(reduced))


def _restricted(measure: _Measurements, base: Vector, index: list[int]):
    def evaluate(x: Vector) -> Evaluation | None:
        values = base.copy()
        values[index] = x
        point = measure(values)
        return None if point is None else (point[0], point[1][:, index])

    return evaluate


def _staged(
    prediction: SpeedPrediction,
    selection: Selection,
    measure: _Measurements,
    loss: Loss,
    max_iterations: int,
    on_progress: Progress | None,
) -> tuple[Vector, Solution] | None:
    """Run both stages; all parameters and the last solution, or None from a stuck start."""

    def report(stage: str):
        return None if on_progress is None else partial(on_progress, stage)

    stage = _CoulombStage(prediction, selection)

    def coulomb(x: Vector) -> Evaluation | None:
        point = measure(stage.values(x))
        return None if point is None else (point[0], point[1] @ stage.map)

    first = minimise(
        coulomb,
        stage.start,
        stage.prior,
        loss,
        tolerance=STAGE_TOLERANCE,
        max_iterations=max_iterations,
        on_iteration=report("viscous and Coulomb"),
    )
    if first is None:
        return None
    base = stage.final_start(first.x)
    index = selection.index(prediction)
    last = minimise(
        _restricted(measure, base, index),
        base[index],
        selection.prior,
        loss,
        max_iterations=max_iterations - first.iterations,
        on_iteration=report("all parameters"),
    )
    if last is None:
        return None
    values = base.copy()
    values[index] = last.x
    return values, replace(last, iterations=first.iterations + last.iterations)


def _residual_sigma(solution: Solution, sigma: float, loss: Loss) -> float:
    """Noise that the residuals of a fit show, rad/s."""
    residual = solution.residual
    if isinstance(loss, Quadratic):
        freedom = max(len(residual) - len(solution.x), 1)
        level = float(np.sqrt(residual @ residual / freedom))
    else:
        level = NORMAL_MAD * float(np.median(np.abs(residual)))
    return sigma * level


def _refined(
    selection: Selection, measure: _Measurements, values: Vector, last: Solution, loss: Loss
) -> tuple[Vector, Solution]:
    """Iterate again from a solution, with the noise that its residuals showed."""
    index = selection.index(measure.prediction)
    again = minimise(_restricted(measure, values, index), values[index], selection.prior, loss)
    if again is None:
        return values, replace(last, reason=WALL)
    values = values.copy()
    values[index] = again.x
    return values, replace(
        again,
        iterations=last.iterations + again.iterations,
        reason=last.reason or again.reason,
    )


def identify(
    records: Record | Sequence[Record],
    *,
    inertia: float | None = None,
    model: str = "stribeck",
    hold: Mapping[str, float | None] | None = None,
    free: Collection[str] = (),
    prior: Mapping[str, tuple[float, float]] | None = None,
    start: Mapping[str, float] | None = None,
    speed_sigma: float | None = None,
    loss: str = "quadratic",
    current_hold: CurrentHold = "zero-order",
    max_iterations: int | None = None,
    on_progress: Progress | None = None,
) -> Fit:
    """Identify a wheel from one or several records fitted together.

    Carrara and Kuga, eqs. (3)-(16). By default motor_constant and the friction torques are
    estimated, with the initial speed of each record; inertia, current_bias and the Stribeck speed
    are held.

    Args:
        records: of one wheel.
        inertia: kg·m²; held unless `free` names it.
        model: name of the friction model.
        hold: name -> value to hold it at, SI, or None for its default.
        free: further names to estimate.
        prior: name -> a-priori mean and sigma, SI; without one only a very wide a-priori keeps the
            problem regular.
        start: name -> first value, SI; otherwise the a-priori mean, otherwise from the record.
        speed_sigma: standard deviation of the measured speed, rad/s. Without it the residuals give
            it, and all sigmas scale with it.
        loss: "quadratic", "huber" or "student".
        current_hold: "zero-order" or "linear": the current between samples.
        max_iterations: corrections at most, both stages together; by default `DEFAULT_ITERATIONS`.
        on_progress: called with the stage, the count and the cost after each correction.

    Returns:
        The fit; its `converged` says whether it is one.

    Raises:
        InputError: the request or the records cannot give an estimate.
    """
    records = [records] if isinstance(records, Record) else list(records)
    chosen_loss = loss_named(loss)
    if speed_sigma is not None and not (np.isfinite(speed_sigma) and speed_sigma > 0.0):
        raise InputError(f"speed sigma: found {speed_sigma}, expected more than 0 rad/s")
    prediction = SpeedPrediction(records, friction_model(model), current_hold)
    check_signals(records)
    deterministic = integral_regression(records)
    selection = select(
        prediction,
        deterministic,
        inertia=inertia,
        hold=hold or {},
        free=free,
        prior=prior or {},
        start=start or {},
    )
    seen = max(noise_level(r.speed[r.valid]) for r in records)
    check_excitation(records, selection.free, seen)
    smallest = NUMERICAL_NOISE * deterministic.speed_level
    sigma = speed_sigma or max(seen, smallest)

    measure = _Measurements(prediction, sigma)
    most = DEFAULT_ITERATIONS if max_iterations is None else max_iterations
    outcome = _staged(prediction, selection, measure, chosen_loss, most, on_progress) or _staged(
        prediction,
        replace(selection, values=selection.fallback),
        measure,
        chosen_loss,
        most,
        on_progress,
    )
    if outcome is None:
        raise InputError(
            f"{records[0].name}: found no start from which the modelled wheel turns as the record "
            "does, expected start or held values closer to this wheel"
        )
    values, solution = outcome
    if speed_sigma is None:
        seen = _residual_sigma(solution, sigma, chosen_loss)
        measure = _Measurements(prediction, max(seen, smallest))
        values, solution = _refined(selection, measure, values, solution, chosen_loss)
    return conclude(
        prediction,
        selection,
        values,
        solution,
        chosen_loss,
        deterministic,
        speed_sigma=measure.sigma,
        sigma_given=speed_sigma is not None,
    )
