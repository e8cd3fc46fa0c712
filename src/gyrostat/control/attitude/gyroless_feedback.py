"""Output feedback without a gyro: star tracker, tachometers and conservation of momentum."""

from typing import Annotated, Any, NamedTuple

from gyrostat.control.attitude.output_feedback import estimated_measurement
from gyrostat.control.missing_sample import predicted
from gyrostat.control.recorded import recorded_with
from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked
from gyrostat.core.jax64 import jnp
from gyrostat.estimation import MomentumAttitudeEstimate, MomentumAttitudeFilter


class _Estimated(NamedTuple):
    estimated_attitude: Annotated[Quaternion, "1"]
    estimated_rate: Annotated[Vector3, "rad/s"]
    estimated_momentum: Annotated[Vector3, "N·m·s"]
    rotor_scale: Annotated[PerWheel, "1"]
    attitude_sigma: Annotated[Vector3, "rad"]
    innovation: Annotated[Vector3, "rad"]
    surprise: Scalar


class GyrolessFeedbackMemory(NamedTuple):
    """State of a gyroless feedback controller between two samples.

    Attributes:
        estimate: Estimate of the filter.
        controller: Memory of the state-feedback controller.
        period: Control period, s.
    """

    estimate: MomentumAttitudeEstimate
    controller: Any
    period: Scalar


class GyrolessFeedback(Checked):
    """State-feedback controller with a filter that needs no gyro.

    The following signals are recorded with the command: `estimated_attitude` (4,), `estimated_rate`
    (3,), rad/s, `estimated_momentum` (3,), inertial axes, N·m·s, `rotor_scale` (wheels,),
    `attitude_sigma` (3,), the standard deviation of the attitude error about each body axis as
    estimated by the filter, rad, `innovation` (3,), rad, and `surprise`, see
    `MomentumAttitudeEstimate`. Before the first sample of the star tracker, the rate is zero.

    Attributes:
        filter: Filter of attitude, momentum and rotor inertias.
        controller: Any controller that takes a `SpacecraftMeasurement`. It also gets the fields of
            the measurement that are not in `TrackerGyroMeasurement`, unchanged.
    """

    filter: MomentumAttitudeFilter
    controller: Any

    def start(self, period: Scalar) -> GyrolessFeedbackMemory:
        """Initial memory."""
        return GyrolessFeedbackMemory(
            self.filter.start(), self.controller.start(period), jnp.asarray(period, dtype=float)
        )

    def predicted(
        self, memory: GyrolessFeedbackMemory, measurement: Any, command: Any
    ) -> GyrolessFeedbackMemory:
        """Memory after a period without a sample; the attitude continues at the last wheel speeds.

        Args:
            memory: Memory from the last sample.
            measurement: Last accepted measurement.
            command: Safe command that is sent.
        """
        estimate = self.filter.predict(memory.estimate, measurement.wheel_speed, memory.period)
        estimate = estimate._replace(innovation=jnp.zeros(3), surprise=jnp.zeros(()))
        known = estimated_measurement(measurement, estimate.attitude, self.filter.rate(estimate))
        later = predicted(self.controller, memory.controller, known, command)
        return GyrolessFeedbackMemory(estimate, later, memory.period)

    def __call__(
        self, memory: GyrolessFeedbackMemory, measurement: Any
    ) -> tuple[GyrolessFeedbackMemory, Any]:
        """Update the estimate and compute the command.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with `attitude` (4,), `attitude_measured`, `wheel_speed`
                (wheels,), rad/s, and `wheel_measured` (wheels,). A measured rate is not used.
        """
        estimate = self.filter.predict(memory.estimate, measurement.wheel_speed, memory.period)
        estimate = self.filter.correct(
            estimate, measurement.attitude, measurement.attitude_measured
        )
        rate = self.filter.rate(estimate)
        known = estimated_measurement(measurement, estimate.attitude, rate)
        controller, command = self.controller(memory.controller, known)
        estimated = _Estimated(
            estimate.attitude,
            rate,
            estimate.momentum,
            estimate.scale,
            jnp.sqrt(jnp.diagonal(estimate.covariance)[:3]),
            estimate.innovation,
            estimate.surprise,
        )
        after = GyrolessFeedbackMemory(estimate, controller, memory.period)
        return after, recorded_with("Estimated", command, estimated)
