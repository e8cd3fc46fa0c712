"""Predict the speed of a record and its derivatives with respect to each parameter."""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.stored_function import stored_function
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.read.slopes import (
    at_temperature,
    slope_dimensions,
    temperature_offsets,
)
from gyrostat.telemetry import Record
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import Friction
from gyrostat.wheel.response import advance, sample_intervals, slope_within

CurrentHold = Literal["zero-order", "linear"]

BLOCKED_SHARE = 0.2
"""Largest fraction of the moving samples at which a model may rest before it counts as stuck."""


def wheel_dimensions(model: type[Friction]) -> dict[str, str]:
    """Parameters of a wheel with this friction: name -> dimension, in order."""
    return {"motor_constant": "motor_constant", "inertia": "inertia", **model.dimensions()}


def build_wheel(model: type[Friction], values: Mapping[str, float]) -> Wheel:
    """Wheel from named parameters, SI, which are not validated; other names are ignored."""
    return Wheel(
        inertia=values["inertia"],
        motor_constant=values["motor_constant"],
        friction=model.of(**{name: values[name] for name in model.dimensions()}),
    )


class Linearisation(NamedTuple):
    """Modelled speed and its derivatives, over the record and over each sample interval.

    Attributes:
        speed: Speed at the samples, (N,), rad/s.
        jacobian: Derivative with respect to all n parameters of the prediction, (N, n), SI.
        transition: Derivative of the speed at the end of each interval with respect to that at its
            start, (N - 1,).
        local: Derivative of the speed at the end of each interval with respect to the shared
            parameters, if they change in this interval alone, (N - 1, s), SI.
        averaged: Whether speed and jacobian are means over the interval before each sample.
    """

    speed: Vector
    jacobian: Matrix
    transition: Vector
    local: Matrix
    averaged: bool = False


def over_intervals(values: Matrix) -> Matrix:
    """Mean value over the interval before each sample, by the trapezoidal rule, (N, ...)."""
    return np.concatenate([values[:1], 0.5 * (values[1:] + values[:-1])])


@lru_cache
def compiled_response(model: type[Friction], hold: CurrentHold):
    """Compile theta -> speeds and their derivatives, for theta = wheel parameters, bias, w(0).

    At a sample that starts a segment, the speed is the given initial one, and the last derivative
    is that with respect to this speed. The arrays may be longer than the record; what is after its
    samples is not computed.

    The derivatives of each interval are chained: S_{k+1} = (dw_{k+1}/dw_k) S_k + dw_{k+1}/dtheta.
    """
    names = tuple(wheel_dimensions(model))

    def respond(theta, time, current, restart, first, count):
        duration, slope = sample_intervals(time, current, hold)
        # the motion in a gap is unknown
        duration = jnp.where(restart[1:], 0.0, duration)

        def interval(carry, sample):
            speed, sensitivity, resolved = carry
            start, change, length, anew, initial = sample
            change = slope_within(change, hold)

            def move(at):
                wheel = build_wheel(model, dict(zip(names, at[1:-1], strict=True)))
                step = advance(wheel, at[0], start + at[-1], change, length)
                return step.speed, step

            at = jnp.concatenate([speed[None], theta[:-1]])
            slopes, step = jax.jacfwd(move, has_aux=True)(at)
            slopes = jnp.where(anew, 0.0, slopes)
            speed = jnp.where(anew, initial, step.speed)
            sensitivity = slopes[0] * sensitivity + jnp.append(slopes[1:], 0.0)
            sensitivity = jnp.where(anew, direction, sensitivity)
            resolved = resolved & step.resolved
            return (speed, sensitivity, resolved), (speed, sensitivity, slopes)

        def sample(k, carry):
            state, outputs = carry
            entry = (current[k], slope[k], duration[k], restart[k + 1], first[k + 1])
            state, new = interval(state, entry)
            put = jax.lax.dynamic_update_index_in_dim
            return state, tuple(put(*pair, k, 0) for pair in zip(outputs, new, strict=True))

        direction = jnp.zeros_like(theta).at[-1].set(1.0)
        each = jnp.zeros((len(time) - 1, len(theta)))
        empty = (each[:, 0], each, each)
        start = (theta[-1], direction, jnp.array(True))
        state, outputs = jax.lax.fori_loop(0, count - 1, sample, (start, empty))
        speeds, rows, slopes = outputs
        speeds = jnp.concatenate([theta[-1:], speeds])
        return speeds, jnp.concatenate([direction[None], rows]), slopes, state[-1]

    return stored_function(respond, model, hold)


def padded(values: Vector, *, repeat: bool = False, lengths: float = 4.0) -> Vector:
    """Append zeros, or repeat the last value, up to a rounded length: few lengths are compiled.

    Args:
        values: Values, (n,).
        repeat: Whether to repeat the last one.
        lengths: Number of lengths from one power of two to the next.
    """
    size = int(np.ceil(2.0 ** (np.ceil(lengths * np.log2(max(len(values), 256))) / lengths)))
    return np.pad(values, (0, size - len(values)), mode="edge" if repeat else "constant")


class SpeedPrediction:
    """Prediction of the wheel speed in some records.

    Viscous and dry friction have temperature coefficients as further parameters if the records
    differ in temperature.

    Attributes:
        names: All parameters in order: those of the wheel, current_bias, then one initial speed for
            each record and one for each further segment of the records.
        dimensions: Name -> dimension.
        initial_speeds: Names of the initial speeds.
        hold: Interpolation of the current between samples.
        shared: Number of leading parameters that all records share.
        inputs: Time, current and segment starts of each record, padded.
        columns: Index of the initial speed of each segment, for each record.
        at_temperature: Map of the parameters to those at the temperature of each record.
    """

    def __init__(
        self,
        records: Sequence[Record],
        model: type[Friction],
        hold: CurrentHold,
        corrections: Sequence[Vector] | None = None,
    ) -> None:
        """Prepare the records for one friction model.

        Args:
            records: Records, at least one.
            model: Friction model.
            hold: Interpolation of the current between samples.
            corrections: Current to add to that of each record, (N,), A; None for none.
        """
        self.records = tuple(records)
        self.model = model
        self.hold: CurrentHold = hold
        self.shared = len(wheel_dimensions(model)) + 1
        endings = [""] if len(records) == 1 else [f"_{k + 1}" for k in range(len(records))]
        restarts = sum(len(r.segments) - 1 for r in records)
        endings += [f"_restart_{k + 1}" for k in range(restarts)]
        self.initial_speeds = tuple(f"initial_speed{ending}" for ending in endings)
        offsets = temperature_offsets(self.records)
        slopes = slope_dimensions(model) if offsets else {}
        self.dimensions = {
            **wheel_dimensions(model),
            "current_bias": "current",
            **dict.fromkeys(self.initial_speeds, "speed"),
            **slopes,
        }
        self.names = tuple(self.dimensions)
        self.at_temperature = [
            at_temperature(model, self.names, offset)
            for offset in offsets or (0.0,) * len(self.records)
        ]
        self._respond = compiled_response(model, hold)
        self._last: tuple[bytes, list[Linearisation] | None] = (b"", None)
        self.inputs, self.columns = [], []
        restart = self.shared + len(records)
        added = [0.0] * len(self.records) if corrections is None else corrections
        for k, (record, correction) in enumerate(zip(self.records, added, strict=True)):
            again = np.zeros(len(record.time), dtype=bool)
            again[[part.start for part in record.segments[1:]]] = True
            parts = (record.time - record.time[0], record.current + correction)
            inputs = [jnp.asarray(padded(part, repeat=True, lengths=1.0)) for part in parts]
            flags = np.pad(again, (0, len(inputs[0]) - len(again)))
            self.inputs.append((*inputs, jnp.asarray(flags)))
            further = range(restart, restart + len(record.segments) - 1)
            self.columns.append([self.shared + k, *further])
            restart += len(further)

    def admissible(self, values: Vector) -> bool:
        """Whether a wheel can have these parameters: finite values, positive inertia and scales."""
        positive = [n for n in ("inertia", *self.model.scales()) if n in self.names]
        return bool(np.all(np.isfinite(values))) and all(
            values[self.names.index(n)] > 0.0 for n in positive
        )

    def linearise(self, values: Vector) -> list[Linearisation] | None:
        """Predict every record, with the derivatives over each sample interval.

        Args:
            values: Parameters in the order of `names`, (n,), SI.

        Returns:
            One linearisation for each record; None if the parameters are not admissible or the
            friction curve cannot be resolved. With the values of the last call, its result.
        """
        # every stage of a fit starts where the one before has ended
        point = np.asarray(values, dtype=float).tobytes()
        if self._last[0] != point:
            self._last = (b"", None)
            self._last = (point, self._predict(values))
        return self._last[1]

    def _predict(self, values: Vector) -> list[Linearisation] | None:
        if not self.admissible(values):
            return None
        linearisations = []
        for record, inputs, columns, at in zip(
            self.records, self.inputs, self.columns, self.at_temperature, strict=True
        ):
            values_of_run = at @ values
            first = np.zeros(len(inputs[0]))
            first[[part.start for part in record.segments]] = values_of_run[columns]
            theta = values_of_run[[*range(self.shared), columns[0]]]
            count = len(record.time)
            response = self._respond(jnp.asarray(theta), *inputs, jnp.asarray(first), count)
            speed, slim, slopes = (np.asarray(part) for part in response[:3])
            speed, slopes = speed[:count], slopes[: count - 1]
            jacobian = np.zeros((count, len(values)))
            jacobian[:, : self.shared] = slim[:count, :-1]
            for column, part in zip(columns, record.segments, strict=True):
                jacobian[part, column] = slim[part, -1]
            finite = all(np.isfinite(array).all() for array in (speed, jacobian, slopes))
            if not (bool(response[3]) and finite):
                return None
            if record.averaged:
                speed = speed.copy()
                for part in record.segments:
                    speed[part] = over_intervals(speed[part])
                    jacobian[part] = over_intervals(jacobian[part])
            if np.any(at != np.eye(len(at))):
                jacobian = jacobian @ at
            linearisations.append(
                Linearisation(speed, jacobian, slopes[:, 0], slopes[:, 1:], record.averaged)
            )
        return linearisations

    def __call__(self, values: Vector) -> list[tuple[Vector, Matrix]] | None:
        """Predict every record.

        Args:
            values: Parameters in the order of `names`, (n,), SI.

        Returns:
            For each record the speed at its samples, rad/s, and the Jacobian (samples, n); None if
            the parameters are not admissible or the friction curve cannot be resolved.
        """
        linear = self.linearise(values)
        return None if linear is None else [(each.speed, each.jacobian) for each in linear]

    def stuck(self, predicted: Sequence[tuple[Vector, Matrix]], noise: Sequence[float]) -> bool:
        """Whether the model rests while the measured wheel turns, so that its gradient is no help.

        Args:
            predicted: Result of a call of this object.
            noise: Standard deviation of the measured speed of each record, rad/s.
        """
        turning = resting = 0
        for record, (speed, _), level in zip(self.records, predicted, noise, strict=True):
            moves = record.valid & (np.abs(np.nan_to_num(record.speed)) > 5.0 * level)
            turning += int(moves.sum())
            resting += int((moves & (speed == 0.0)).sum())
        return resting > BLOCKED_SHARE * turning
