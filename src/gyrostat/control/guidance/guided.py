"""Controller that follows a reference."""

from dataclasses import fields, replace
from typing import Annotated, Any, NamedTuple

import equinox as eqx

from gyrostat.control.guidance.attitude_reference import AttitudeReference
from gyrostat.control.guidance.guide import Guide
from gyrostat.control.guidance.mode_changes import Mode
from gyrostat.control.guidance.reference import Reference
from gyrostat.control.missing_sample import predicted
from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.delay_line import is_delay
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.named_tuples import with_fields

UNITS = {
    **{"mode": "1", "mode_start": "s", "mode_change": "1", "target": "1"},
    **{"turn_blocked": "1", "turn_from": "1", "turn_rate": "rad/s"},
}
"""Units of the signals that are recorded with the command."""


def toward(controller: Any, guide: Guide) -> Any:
    """Controller with the reference of a sample.

    Args:
        controller: Controller with a method `toward(guide)`, as the laws of this package; or one
            with a field `reference`, which gets the reference as a function of time, s ->
            `AttitudeReference`.
        guide: Reference at the sample.

    Raises:
        InputError: The controller has neither.
    """
    method = getattr(controller, "toward", None)
    if method is not None:
        return method(guide)
    if "reference" not in {field.name for field in fields(controller)}:
        raise InputError(
            f"{type(controller).__name__}: found a controller that cannot follow a reference, "
            "expected a field `reference` or a method `toward`"
        )
    return replace(controller, reference=guide.at)


class GuidedMemory(NamedTuple):
    """State of a guided controller between two samples.

    Attributes:
        controller: Memory of the controller.
        mode: Active mode of the reference.
        sample: Index of the next sample.
        period: Control period, s.
    """

    controller: Any
    mode: Mode
    sample: Scalar
    period: Scalar


class Guided(Checked):
    """Controller that follows a reference: attitude, rate and acceleration over time.

    At each sample, the mode of the reference is updated and the controller gets the reference, see
    `toward`. The clock also advances at missing samples. Mode, start of the mode and target
    attitude are recorded with the command as `mode`, `mode_start` and `target`; of a reference with
    changes, `mode_change` is the number of that to the mode, from 1, or 0 before the first one. Of
    one that keeps instruments from bright bodies, `turn_blocked` says whether a body may come too
    near in the turn to the mode, see `gyrostat.control.guidance.way_around.Way`; where a turn can
    start at the measured attitude, `turn_from` and `turn_rate` are that attitude and its rate.

    Attributes:
        controller: Controller that can follow a reference.
        reference: Reference.
        delay: Number of control periods from a sample to the start of its command.
    """

    controller: Any
    reference: Reference
    delay: Annotated[int, is_delay] = eqx.field(static=True, default=0)

    def _guide(self, mode: Mode, now: AttitudeReference, time: Scalar, period: Scalar) -> Guide:
        return Guide.of(self.reference.bound(mode), now, time, period, self.delay)

    def start(self, period: Scalar) -> GuidedMemory:
        """Initial memory, in the first mode.

        Raises:
            InputError: The controller cannot follow a reference.
        """
        mode, zero = self.reference.start(), jnp.zeros(())
        period = jnp.asarray(period, dtype=float)
        guide = self._guide(mode, self.reference.at(mode, zero), zero, period)
        return GuidedMemory(toward(self.controller, guide).start(period), mode, zero, period)

    def predicted(self, memory: GuidedMemory, measurement: Any, command: Any) -> GuidedMemory:
        """Memory after a period without a sample; time advances, also that of the modes.

        Args:
            memory: Memory from the last sample.
            measurement: Last accepted measurement.
            command: Safe command that is sent.
        """
        time = memory.sample * memory.period
        mode, now = self.reference.advance(memory.mode, None, time)
        controller = toward(self.controller, self._guide(mode, now, time, memory.period))
        inner = predicted(controller, memory.controller, measurement, command)
        return GuidedMemory(inner, mode, memory.sample + 1.0, memory.period)

    def __call__(self, memory: GuidedMemory, measurement: Any) -> tuple[GuidedMemory, Any]:
        """Compute the command.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with the fields that the controller and the conditions of the
                reference need.
        """
        time = memory.sample * memory.period
        mode, now = self.reference.advance(memory.mode, measurement, time)
        guide = self._guide(mode, now, time, memory.period)
        inner, command = toward(self.controller, guide)(memory.controller, measurement)
        signals: dict[str, Any] = {"mode": mode.number, "mode_start": mode.start}
        if mode.watch is not None:
            signals["mode_change"] = mode.watch.taken
        if mode.transition is not None and mode.transition.first is not None:
            signals["turn_blocked"] = mode.transition.first.blocked
        if self.reference.around is not None and any(self.reference.around.measured):
            signals |= {"turn_from": now.attitude, "turn_rate": now.rate}
        if "target" not in command._fields:
            signals["target"] = guide.now.attitude
        units = {name: UNITS[name] for name in signals}
        works = getattr(command, "works", None)
        if mode.watch is not None and works is not None:
            lost = jnp.sum(jnp.logical_not(works), dtype=float)
            mode = mode._replace(watch=mode.watch._replace(lost=lost))
        next_memory = GuidedMemory(inner, mode, memory.sample + 1.0, memory.period)
        return next_memory, with_fields("Guided", command, signals, units)
