"""Two-stage iteration of a batch identification from one start.

The first stage estimates viscous and Coulomb friction with T_s = c, where the iteration cannot get
trapped. The second stage estimates everything. A trial step is refused if the modelled wheel rests
while the real one turns, because from there the gradient does not lead back. The final fit has no
bounds: an estimate T_s < c is legitimate noise.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.identification.fit.least_squares import Evaluation, Prior, Solution, minimise
from gyrostat.identification.fit.loss import Loss
from gyrostat.identification.fit.prediction import SpeedPrediction
from gyrostat.identification.fit.selection import Selection
from gyrostat.wheel.friction import Friction

Progress = Callable[[str, int, float], None]

STAGE_TOLERANCE = 50.0
"""Tolerance of the first stage, in standard deviations."""


class Measurements:
    """Whitened residuals of all records as a function of all parameters."""

    def __init__(self, prediction: SpeedPrediction, sigmas: Sequence[float]) -> None:
        """Prepare whitening.

        Args:
            prediction: Prediction of the records.
            sigmas: Standard deviation of the measured speed of each record, rad/s.
        """
        self.prediction = prediction
        self.sigmas = tuple(sigmas)

    def __call__(self, values: Vector) -> Evaluation | None:
        """Whitened residuals (m,) and Jacobian (m, n); None if the modelled wheel sticks."""
        predictions = self.prediction(values)
        if predictions is None or self.prediction.stuck(predictions, self.sigmas):
            return None
        parts = list(zip(self.prediction.records, predictions, self.sigmas, strict=True))
        residual = [(r.speed - speed)[r.valid] / sigma for r, (speed, _), sigma in parts]
        jacobian = [rows[r.valid] / sigma for r, (_, rows), sigma in parts]
        return np.concatenate(residual), np.vstack(jacobian)

    def along(self, base: Vector, index: list[int]) -> Callable[[Vector], Evaluation | None]:
        """Whitened residuals as a function of some parameters only.

        Args:
            base: All parameters, (n,).
            index: Indices of the varied parameters.
        """

        def evaluate(x: Vector) -> Evaluation | None:
            values = base.copy()
            values[index] = x
            point = self(values)
            return None if point is None else (point[0], point[1][:, index])

        return evaluate

    def by_record(self, residual: Vector) -> list[Vector]:
        """Split stacked residuals, (m,), by record."""
        counts = [int(r.valid.sum()) for r in self.prediction.records]
        return np.split(residual, np.cumsum(counts)[:-1])


@dataclass(frozen=True)
class Outcome:
    """End of the stages.

    Attributes:
        values: All parameters of the prediction, (n,), SI.
        solution: Solution for the free parameters.
    """

    values: Vector
    solution: Solution


class _CoulombStage:
    """All friction parameters as functions of one viscous coefficient and one Coulomb torque."""

    def __init__(self, prediction: SpeedPrediction, selection: Selection) -> None:
        model: type[Friction] = prediction.model
        zero, per_viscous, per_coulomb = (
            np.array(list(model.start_values(*point).values()))
            for point in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
        )
        self.prediction, self.selection = prediction, selection
        friction = list(model.dimensions())
        non_friction = [n for n in selection.free if n not in friction]
        columns = [np.eye(len(prediction.names))[prediction.names.index(n)] for n in non_friction]
        start = [selection.values[prediction.names.index(n)] for n in non_friction]
        mean = [selection.prior.mean[selection.free.index(n)] for n in non_friction]
        sigma = [selection.prior.sigma[selection.free.index(n)] for n in non_friction]
        self.offset = selection.values.copy()
        for tie in (per_viscous - zero, per_coulomb - zero):
            ratios = {n: t for n, t in zip(friction, tie, strict=True) if t != 0.0}
            leading = [n for n in ratios if n not in model.vanishing_at]
            if not leading:
                continue
            column = np.zeros(len(prediction.names))
            column[[prediction.names.index(n) for n in ratios]] = list(ratios.values())
            leading_places = np.array([prediction.names.index(n) for n in leading])
            first = float(np.mean(selection.values[leading_places] / column[leading_places]))
            free = [n for n in leading if n in selection.free]
            self.offset = np.where(column != 0.0, 0.0 if free else first * column, self.offset)
            if free:
                places = [selection.free.index(n) for n in free]
                per = np.array([ratios[n] for n in free])
                columns.append(column)
                start.append(first)
                mean.append(float(np.mean(selection.prior.mean[places] / per)))
                sigma.append(float(np.min(selection.prior.sigma[places] / np.abs(per))))
        self.map = np.column_stack(columns) if columns else np.zeros((len(self.offset), 0))
        self.start = np.array(start)
        self.prior = Prior(np.array(mean), np.array(sigma))

    def values(self, reduced: Vector) -> Vector:
        """All parameters of the prediction."""
        return self.offset + self.map @ reduced

    def final_start(self, reduced: Vector) -> Vector:
        """Start of the second stage: held parameters unchanged, free ones from this stage."""
        constant = np.array([name not in self.selection.free for name in self.prediction.names])
        return np.where(constant, self.selection.values, self.values(reduced))


def _rises_at_rest(selection: Selection, prediction: SpeedPrediction) -> bool:
    """Whether the user gave a static torque above the Coulomb torque."""
    value = dict(zip(prediction.names, selection.values, strict=True))
    vanishing = prediction.model.vanishing_at.items()
    return any(n in selection.told and value[n] > value[reference] for n, reference in vanishing)


def run_stages(
    selection: Selection,
    measure: Measurements,
    loss: Loss,
    max_iterations: int,
    on_progress: Progress | None,
) -> Outcome | None:
    """Run both stages, or only the second one if the user gave a static torque.

    Args:
        selection: Estimated parameters and start values.
        measure: Whitened residuals.
        loss: Loss of one residual.
        max_iterations: Largest number of corrections in both stages together.
        on_progress: Function called with the stage, the count and the cost after each correction.

    Returns:
        The outcome; None if the modelled wheel sticks at the start values.
    """

    def report(stage: str):
        return None if on_progress is None else partial(on_progress, stage)

    final = report("all parameters")
    if _rises_at_rest(selection, measure.prediction):
        # the first stage would discard the user's static torque
        return refine(selection, measure, selection.values, loss, max_iterations, 0, final)
    stage = _CoulombStage(measure.prediction, selection)

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
    values = stage.final_start(first.x)
    return refine(selection, measure, values, loss, max_iterations, first.iterations, final)


def refine(
    selection: Selection,
    measure: Measurements,
    values: Vector,
    loss: Loss,
    max_iterations: int,
    before: int,
    on_iteration: Callable[[int, float], None] | None = None,
) -> Outcome | None:
    """Iterate over all free parameters.

    Args:
        selection: Estimated parameters.
        measure: Whitened residuals.
        values: Start values of all parameters, (n,), SI.
        loss: Loss of one residual.
        max_iterations: Largest number of corrections, including earlier ones.
        before: Number of earlier corrections.
        on_iteration: Function called with the count and the cost after each correction.

    Returns:
        The outcome; None if the modelled wheel sticks at the start values.
    """
    index = selection.index(measure.prediction)
    solution = minimise(
        measure.along(values, index),
        values[index],
        selection.prior,
        loss,
        max_iterations=max_iterations - before,
        on_iteration=on_iteration,
    )
    if solution is None:
        return None
    values = values.copy()
    values[index] = solution.x
    return Outcome(values, replace(solution, iterations=before + solution.iterations))
