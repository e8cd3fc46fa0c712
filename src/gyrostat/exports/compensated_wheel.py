"""Wheel with its compensator as one unit, for simulators that compute the motion of the body."""

from typing import Annotated, NamedTuple

import equinox as eqx
from jaxtyping import Array, Bool, Float, Int

from gyrostat.control import EstimatingCompensator, Guarded, MeasurementGuard
from gyrostat.control.guarded import GuardedMemory
from gyrostat.control.measurement_guard import SampleReport
from gyrostat.core.arrays import Scalar
from gyrostat.core.delay_line import empty_line, pushed
from gyrostat.core.jax64 import jnp
from gyrostat.spacecraft import TableMeasurement
from gyrostat.wheel import Wheel, advance


class BodyMeasurement(NamedTuple):
    """Measured motion of the body about the wheel's axis.

    Attributes:
        attitude: Rotation angle about the wheel's axis, rad.
        rate: Body rate about the wheel's axis, rad/s.
    """

    attitude: Annotated[Float[Array, ""], "rad"]
    rate: Annotated[Float[Array, ""], "rad/s"]


class CompensatedState(NamedTuple):
    """State between two control periods.

    Attributes:
        memory: Memory of the compensator and state of the validation of its measurements.
        speed: Wheel speed, rad/s; exactly zero while the wheel sticks.
        under_way: Commanded currents that do not act yet (delay line), (delay,), A.
    """

    memory: GuardedMemory
    speed: Float[Array, ""]
    under_way: Float[Array, " delay"]


class CompensatedOutput(NamedTuple):
    """Output of a control period.

    Attributes:
        torque: Mean reaction torque of the wheel on the body over the period, N·m.
        speed: Wheel speed at the end of the period, rad/s.
        current: Motor current, A.
        estimated_torque: Estimated external torque on the body, N·m.
        friction_scale: Friction of the wheel divided by that of the compensator's model.
        resolved: Whether the wheel's motion was resolved.
        sample_status: Status of the sample, see SampleStatus.
        samples_missed: Samples since the last one that gave a command; 0 if this one did.
    """

    torque: Annotated[Scalar, "N·m"]
    speed: Annotated[Scalar, "rad/s"]
    current: Annotated[Scalar, "A"]
    estimated_torque: Annotated[Scalar, "N·m"]
    friction_scale: Annotated[Scalar, "1"]
    resolved: Bool[Array, ""]
    sample_status: Int[Array, ""]
    samples_missed: Int[Array, ""]

    ENUMS = SampleReport.ENUMS


class CompensatedWheel(eqx.Module):
    """Wheel driven by the sampled and held current of its compensator.

    The compensator reads the body's attitude and rate and the wheel speed. The effect of the body's
    acceleration on the wheel speed is neglected; it is smaller by the ratio of the inertias of
    rotor and body.

    Attributes:
        compensator: Compensator, which commands the current.
        wheel: Simulated wheel; it may differ from the compensator's model.
        guard: Validation of attitude, rate and wheel speed before the compensator uses them.
    """

    compensator: EstimatingCompensator
    wheel: Wheel
    guard: MeasurementGuard = eqx.field(
        default_factory=lambda: MeasurementGuard.of(
            TableMeasurement(*map(jnp.asarray, (0.0, 0.0, 0.0)))
        )
    )

    def start(self, speed: Scalar, period: Scalar) -> CompensatedState:
        """State at a wheel speed, rad/s; the control period is in s."""
        under_way = empty_line(jnp.zeros(()), self.compensator.delay)
        memory = Guarded(self.compensator, self.guard).start(period)
        return CompensatedState(memory, jnp.asarray(speed), under_way)

    def __call__(
        self, state: CompensatedState, measurement: BodyMeasurement
    ) -> tuple[CompensatedState, CompensatedOutput]:
        """Propagate the wheel over one control period.

        Args:
            state: State at the start of the period.
            measurement: Measured motion of the body at the start of the period.
        """
        period = state.memory.period
        sample = TableMeasurement(measurement.attitude, measurement.rate, state.speed)
        guarded = Guarded(self.compensator, self.guard)
        memory, command, report = guarded.step(state.memory, sample)
        under_way, current = pushed(state.under_way, command.current)
        speed, resolved = advance(self.wheel, state.speed, current, 0.0, period)
        output = CompensatedOutput(
            torque=self.wheel.inertia * (state.speed - speed) / period,
            speed=speed,
            current=current,
            estimated_torque=command.estimated_torque,
            friction_scale=command.friction_scale,
            resolved=resolved,
            sample_status=report.sample_status,
            samples_missed=report.samples_missed,
        )
        return CompensatedState(memory, speed, under_way), output
