"""Output feedback: a state-feedback controller with an attitude filter."""

from typing import Any, NamedTuple

from gyrostat.control.missing_sample import predicted
from gyrostat.control.recorded import recorded_with
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, declared_units
from gyrostat.core.jax64 import jnp
from gyrostat.core.named_tuples import with_fields
from gyrostat.spacecraft import SpacecraftMeasurement, TrackerGyroMeasurement


class OutputFeedbackMemory(NamedTuple):
    """State of an output feedback controller between two samples.

    Attributes:
        estimate: Estimate of the attitude filter.
        controller: Memory of the state-feedback controller.
        period: Control period, s.
    """

    estimate: Any
    controller: Any
    period: Scalar


class OutputFeedback(Checked):
    """State-feedback controller with an attitude filter for star tracker and gyro, or no gyro.

    The `signals` of the filter are recorded with the command: `estimated_attitude` (4,),
    `estimated_rate` (3,), rad/s, `attitude_sigma` (3,), the standard deviation of the attitude
    error about each body axis as estimated by the filter, rad, `innovation` (3,), rad, `surprise`,
    see `AttitudeEstimate`, and what the filter estimates besides.

    Attributes:
        filter: `gyrostat.estimation.AttitudeFilter` with a gyro, `MomentumAttitudeFilter` without,
            or another filter with these methods.
        controller: Any controller that takes a `SpacecraftMeasurement`. It also gets the fields of
            the measurement that are not in `TrackerGyroMeasurement`, unchanged.
    """

    filter: Any
    controller: Any

    def start(self, period: Scalar) -> OutputFeedbackMemory:
        """Initial memory."""
        return OutputFeedbackMemory(
            self.filter.start(), self.controller.start(period), jnp.asarray(period, dtype=float)
        )

    def predicted(
        self, memory: OutputFeedbackMemory, measurement: Any, command: Any
    ) -> OutputFeedbackMemory:
        """Memory after a period without a sample, propagated by the last one.

        Args:
            memory: Memory from the last sample.
            measurement: Last accepted measurement.
            command: Safe command that is sent.
        """
        sample = self.filter.sample(measurement)
        estimate = self.filter.predict(memory.estimate, sample, memory.period)
        estimate = estimate._replace(innovation=jnp.zeros(3), surprise=jnp.zeros(()))
        rate = self.filter.rate(estimate, sample)
        full_state = estimated_measurement(measurement, estimate.attitude, rate)
        later = predicted(self.controller, memory.controller, full_state, command)
        return OutputFeedbackMemory(estimate, later, memory.period)

    def __call__(
        self, memory: OutputFeedbackMemory, measurement: Any
    ) -> tuple[OutputFeedbackMemory, Any]:
        """Update the estimate and compute the command.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with `attitude` (4,), `attitude_measured`, `wheel_speed`
                (wheels,), rad/s, `wheel_measured` (wheels,) and, for a filter that reads a gyro,
                `rate` (3,), averaged over the last control period, rad/s.
        """
        sample = self.filter.sample(measurement)
        estimate = self.filter.predict(memory.estimate, sample, memory.period)
        estimate = self.filter.correct(
            estimate, measurement.attitude, measurement.attitude_measured
        )
        rate = self.filter.rate(estimate, sample)
        full_state = estimated_measurement(measurement, estimate.attitude, rate)
        controller, command = self.controller(memory.controller, full_state)
        next_memory = OutputFeedbackMemory(estimate, controller, memory.period)
        return next_memory, recorded_with("Estimated", command, self.filter.signals(estimate, rate))


def estimated_measurement(measurement: Any, attitude: Quaternion, rate: Vector3) -> Any:
    """Measurement for a state-feedback controller, with estimated attitude and rate."""
    full_state = SpacecraftMeasurement(
        attitude, rate, measurement.wheel_speed, measurement.wheel_measured
    )
    extras = {
        name: getattr(measurement, name)
        for name in getattr(measurement, "_fields", ())
        if name not in TrackerGyroMeasurement._fields or name == "attitude_measured"
    }
    if not extras:
        return full_state
    units = declared_units(type(measurement))
    return with_fields("Estimated", full_state, extras, {n: units[n] for n in extras if n in units})
