"""Effects of real wheels and drives that a further record has, with their sizes a priori.

They are those that `identify` averages over (`gyrostat.identification.uncertainty.effects`): ripple
at breakaways, drift of friction over the record, rounding of a held current.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.read.quantisation import held_levels
from gyrostat.identification.uncertainty.averaging import Effect
from gyrostat.identification.uncertainty.current_errors import ROUNDED
from gyrostat.identification.uncertainty.effects import DRIFTING
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import Friction

WAVES = 4
"""Number of cosines of a variation of friction about its drift; further ones change no sigma."""
LEVELS = 8
"""Largest number of levels of a current that count as held, each with one error of rounding."""
DRIFT_SHAPES = 1 + WAVES
RIPPLE, ROUNDING = "crossing_ripple", "current_rounding"
"""Effects of a fit that give the torque ripple, and the rounding of the current."""


Drifts = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class RecordEffects:
    """Sizes of effects in a further record, standard deviations.

    Attributes:
        ripple: Torque ripple, N·m.
        drifts: For viscous and for dry friction, the drift from mid-record to the end and the first
            cosine about it, fractions of the friction.
        current_error: Error of a held current, A.
    """

    ripple: float = 0.0
    drifts: Drifts = ((0.0, 0.0),) * len(DRIFTING)
    current_error: float = 0.0

    def sigmas(self) -> Vector:
        """Prior sigma of each coefficient: drifts, levels of the current, ripple, (c,)."""
        orders = np.arange(1, WAVES + 1)
        drifts = [np.append(line, wave / orders) for line, wave in self.drifts]
        levels = np.full(LEVELS, self.current_error)
        return np.concatenate([*drifts, levels, [self.ripple]])


def found_drifts(effects: Mapping[str, Effect]) -> Drifts:
    """Sizes of the drifts that a fit found, for `RecordEffects`; a further record drifts so too."""
    names = [name for _, name, *_ in DRIFTING]
    return tuple(
        (expected_size(effects, f"{name}_drift"), expected_size(effects, f"{name}_variation"))
        for name in names
    )


def expected_size(effects: Mapping[str, Effect], name: str) -> float:
    """Root mean square of the size of an effect over the posterior of a fit; 0: not a candidate."""
    effect = effects.get(name)
    return 0.0 if effect is None else effect.expected


def drift_shapes(time: Vector) -> Matrix:
    """Change of a drifting friction in each interval, (N - 1, 1 + WAVES): a line, and cosines.

    Args:
        time: Sample times, (N,), s, from zero.
    """
    share = 0.5 * (time[1:] + time[:-1]) / time[-1]
    waves = np.cos(np.pi * np.arange(1, WAVES + 1) * share[:, None])
    return np.column_stack([2.0 * share - 1.0, waves])


def drifting_torques(model: type[Friction], names: tuple[str, ...]) -> Matrix:
    """Whether each parameter drifts with the viscous or with the dry friction, (2, m)."""
    dimensions = model.dimensions()
    rows = [[dimensions.get(n) == dimension for n in names] for dimension, *_ in DRIFTING]
    return np.array(rows, dtype=float)


def level_shapes(currents: Matrix, error: float) -> Vector:
    """Intervals of each held level of the currents (b, N), (b, N - 1, LEVELS).

    A current that changes has errors of rounding that average out.

    Args:
        currents: Currents, (b, N), A.
        error: Standard deviation of the error of a held current, A; 0: not rounded.
    """
    shapes = np.zeros((len(currents), currents.shape[1] - 1, LEVELS))
    if error == 0.0:
        return shapes
    time = np.arange(float(currents.shape[1]))
    for shape, current in zip(shapes, currents, strict=True):
        record = Record("design", time, current, time, time >= 0.0)
        ((index,), _, _) = held_levels([record], error / ROUNDED)
        kept = (index >= 0) & (index < LEVELS) & (current[:-1] != 0.0)
        shape[np.flatnonzero(kept), index[kept]] = 1.0
    return shapes
