"""Output feedback: a state-feedback controller behind an attitude filter."""

from typing import Annotated, Any, NamedTuple

from gyrostat.control.missing_sample import predicted
from gyrostat.control.recorded import recorded_with
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked
from gyrostat.core.jax64 import jnp
from gyrostat.estimation import AttitudeEstimate, AttitudeFilter
from gyrostat.spacecraft import SpacecraftMeasurement


class _Estimated(NamedTuple):
    estimated_attitude: Annotated[Quaternion, "1"]
    estimated_rate: Annotated[Vector3, "rad/s"]
    estimated_bias: Annotated[Vector3, "rad/s"]
    attitude_sigma: Annotated[Vector3, "rad"]
    innovation: Annotated[Vector3, "rad"]
    surprise: Scalar


class OutputFeedbackMemory(NamedTuple):
    """Between two samples.

    Attributes:
        estimate: of the attitude filter.
        controller: what the controller remembers.
        period: control period, s.
    """

    estimate: AttitudeEstimate
    controller: Any
    period: Scalar


class OutputFeedback(Checked):
    """State-feedback controller behind a filter of star tracker and gyro.

    Recorded beside the command of the controller: `estimated_attitude` (4,), `estimated_rate` and
    `estimated_bias` (3,), rad/s, `attitude_sigma` (3,), standard deviation of the attitude error
    about each body axis as the filter estimates it, rad, `innovation` (3,), rad, and `surprise`,
    see `AttitudeEstimate`.

    Attributes:
        filter: of attitude and gyro bias.
        controller: any controller of a `SpacecraftMeasurement`.
    """

    filter: AttitudeFilter
    controller: Any

    def start(self, period: Scalar) -> OutputFeedbackMemory:
        """Nothing measured yet."""
        return OutputFeedbackMemory(
            self.filter.start(), self.controller.start(period), jnp.asarray(period, dtype=float)
        )

    def predicted(
        self, memory: OutputFeedbackMemory, measurement: Any, command: Any
    ) -> OutputFeedbackMemory:
        """Memory one period later without a sample: the attitude goes on at the last rate.

        Args:
            memory: from the last sample.
            measurement: last one that was accepted.
            command: that is sent.
        """
        estimate = self.filter.predict(memory.estimate, measurement.rate, memory.period)
        estimate = estimate._replace(innovation=jnp.zeros(3), surprise=jnp.zeros(()))
        known = SpacecraftMeasurement(
            estimate.attitude,
            measurement.rate - estimate.bias,
            measurement.wheel_speed,
            measurement.wheel_measured,
        )
        later = predicted(self.controller, memory.controller, known, command)
        return OutputFeedbackMemory(estimate, later, memory.period)

    def __call__(
        self, memory: OutputFeedbackMemory, measurement: Any
    ) -> tuple[OutputFeedbackMemory, Any]:
        """Estimate, and command.

        Args:
            memory: from the last sample.
            measurement: has `attitude` (4,), `attitude_measured`, `rate` (3,) over the last control
                period, rad/s, `wheel_speed` (wheels,), rad/s, and `wheel_measured` (wheels,).
        """
        estimate = self.filter.predict(memory.estimate, measurement.rate, memory.period)
        estimate = self.filter.correct(
            estimate, measurement.attitude, measurement.attitude_measured
        )
        rate = measurement.rate - estimate.bias
        known = SpacecraftMeasurement(
            estimate.attitude, rate, measurement.wheel_speed, measurement.wheel_measured
        )
        controller, command = self.controller(memory.controller, known)
        sigma = jnp.sqrt(jnp.diagonal(estimate.covariance)[:3])
        estimated = _Estimated(
            estimate.attitude, rate, estimate.bias, sigma, estimate.innovation, estimate.surprise
        )
        after = OutputFeedbackMemory(estimate, controller, memory.period)
        return after, recorded_with("Estimated", command, estimated)
