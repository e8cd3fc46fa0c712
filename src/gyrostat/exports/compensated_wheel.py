"""A wheel with its compensator as one unit, for simulators that move the body."""

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
    """What the simulator tells of the body.

    Attributes:
        attitude: about the wheel's axis, rad.
        rate: about it, rad/s.
    """

    attitude: Annotated[Float[Array, ""], "rad"]
    rate: Annotated[Float[Array, ""], "rad/s"]


class CompensatedState(NamedTuple):
    """Between two control periods.

    Attributes:
        memory: of the compensator and the validation of its measurements.
        speed: of the wheel, rad/s; exactly zero while it sticks.
        under_way: (delay,) commanded currents that do not act yet, A.
    """

    memory: GuardedMemory
    speed: Float[Array, ""]
    under_way: Float[Array, " delay"]


class CompensatedOutput(NamedTuple):
    """What a control period gives.

    Attributes:
        torque: mean over the period on the body, which loses what the wheel gains, N·m.
        speed: of the wheel at the end, rad/s.
        current: of the motor, A.
        estimated_torque: external torque on the body, N·m.
        friction_scale: friction of the wheel over friction of the compensator's model.
        resolved: whether the wheel's motion was.
        sample_status: Status of the sample, see SampleStatus.
        samples_missed: Samples since the last one that gave a command; 0 where this one did.
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
    """A wheel under the currents of its compensator, sampled and held.

    The compensator reads the body's attitude and rate and the wheel's own speed. What the body's
    acceleration adds to that speed, a share of the rotor's inertia over the body's, is left out.

    Attributes:
        compensator: gives the currents.
        wheel: that they drive; it need not be as the compensator knows it.
        guard: validates attitude, rate and wheel speed before the compensator uses them.
    """

    compensator: EstimatingCompensator
    wheel: Wheel
    guard: MeasurementGuard = eqx.field(
        default_factory=lambda: MeasurementGuard.of(
            TableMeasurement(*map(jnp.asarray, (0.0, 0.0, 0.0)))
        )
    )

    def start(self, speed: Scalar, period: Scalar) -> CompensatedState:
        """At a wheel speed, rad/s; the control period is in s."""
        under_way = empty_line(jnp.zeros(()), self.compensator.delay)
        memory = Guarded(self.compensator, self.guard).start(period)
        return CompensatedState(memory, jnp.asarray(speed), under_way)

    def __call__(
        self, state: CompensatedState, measurement: BodyMeasurement
    ) -> tuple[CompensatedState, CompensatedOutput]:
        """Carry the wheel over one control period.

        Args:
            state: at its start.
            measurement: of the body there.
        """
        period = state.memory.period
        seen = TableMeasurement(measurement.attitude, measurement.rate, state.speed)
        guarded = Guarded(self.compensator, self.guard)
        memory, command, report = guarded.step(state.memory, seen)
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
