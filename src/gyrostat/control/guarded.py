"""A controller behind the validation of its measurements."""

from typing import Any, NamedTuple

from gyrostat.control.measurement_guard import (
    GuardMemory,
    MeasurementGuard,
    SampleReport,
    SampleStatus,
)
from gyrostat.control.missing_sample import predicted
from gyrostat.control.recorded import recorded_with
from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

ACTUATED = ("current", "torque", "external_torque", "fading_torque", "speed")
"""Fields of a command that go to actuators: zero in the safe command "zero"."""


class GuardedMemory(NamedTuple):
    """State of a guarded controller between two samples.

    Attributes:
        controller: Memory of the controller.
        guard: Memory of the validation.
        command: Last command that the controller gave from an accepted sample.
        period: Control period, s.
    """

    controller: Any
    guard: GuardMemory
    command: Any
    period: Scalar


class Guarded(Checked):
    """Controller that survives bad samples.

    A sample that the guard accepts goes to the controller. One that it rejects does not: the
    command is the safe one (the last accepted command, or zero), and the memory of the controller
    is what `predicted` makes of it. The same follows if an accepted sample leads to a command or
    a memory that is not finite. Whatever the samples, memory and command stay finite, and the next
    good sample is used as if the rejected ones had never come.

    Recorded beside the controller's command: `sample_status`, a `SampleStatus`, and
    `samples_missed`, the number of samples since the last accepted one.

    Attributes:
        controller: Any controller of the loop. It may offer
            `predicted(memory, measurement, command)`, its memory one period later without a
            sample, from the last accepted measurement and the safe command that is sent; by default
            its memory stays as it was.
        guard: Limits of the measurement, and the safe command.
    """

    controller: Any
    guard: MeasurementGuard

    def check_own_period(self, period: float) -> None:
        """Refuse a control period, s, at which the controller would never give a command.

        Raises:
            InputError: Its memory is not finite at the start.
        """
        if not finite(self.controller.start(period)):
            raise InputError(
                f"{type(self.controller).__name__}: found a memory that is not finite at the "
                "start, expected finite numbers behind a guard"
            )

    def start(self, period: Scalar) -> GuardedMemory:
        """Memory before the first sample; the safe command is zero until one was accepted.

        Args:
            period: Control period, s.

        Raises:
            InputError: the safe command is zero and the command has no field for an actuator.
        """
        inner, guard = self.controller.start(period), self.guard.start()
        _, command = jax.eval_shape(self.controller, inner, guard.last)
        fields = getattr(command, "_fields", ACTUATED)
        if self.guard.on_bad == "zero" and not set(fields) & set(ACTUATED):
            raise InputError(
                f"{type(self.controller).__name__}: found a command of {', '.join(fields)}, "
                f"expected one of {', '.join(ACTUATED)} for the safe command zero"
            )
        none = jax.tree.map(lambda shape: jnp.zeros(shape.shape, shape.dtype), command)
        return GuardedMemory(inner, guard, none, jnp.asarray(period, dtype=float))

    def __call__(self, memory: GuardedMemory, measurement: Any) -> tuple[GuardedMemory, Any]:
        """Command, with the status of the sample beside it.

        Args:
            memory: From the last sample.
            measurement: As the sensors give it.
        """
        memory, command, report = self.step(memory, measurement)
        if not hasattr(command, "_fields"):
            return memory, command
        return memory, recorded_with("Guarded", command, report)

    def step(
        self, memory: GuardedMemory, measurement: Any
    ) -> tuple[GuardedMemory, Any, SampleReport]:
        """The same with the report by itself.

        Args:
            memory: From the last sample.
            measurement: As the sensors give it.
        """
        seen = self.guard(memory.guard, measurement, memory.period)
        stays = memory.controller, memory.command, jnp.array(False)

        def stepped() -> tuple[Any, Any, Any]:
            # without barriers XLA computes the controller anew for every result that needs it
            measurement = jax.lax.optimization_barrier(seen.measurement)
            after = self.controller(memory.controller, measurement)
            inner, command = jax.lax.optimization_barrier(after)
            return inner, command, finite((inner, command), memory.controller)

        like = jax.tree.map(jnp.asarray, stays)
        inner, command, computed = jax.lax.cond(seen.good, _as(like, stepped), lambda: like)

        def taken() -> tuple[Any, GuardMemory, Any]:
            return inner, seen.used, command

        def missing() -> tuple[Any, GuardMemory, Any]:
            before, safe = memory.controller, self._safe(memory.command, jnp.array(False))
            later = predicted(self.controller, before, memory.guard.last, safe)
            stays = finite(later, before)
            later = jax.tree.map(lambda new, old: jnp.where(stays, new, old), later, before)
            return later, seen.missed, memory.command

        like = jax.tree.map(jnp.asarray, (memory.controller, memory.guard, memory.command))
        inner, guard, last = jax.lax.cond(computed, _as(like, taken), _as(like, missing))
        status = jnp.where(seen.good & ~computed, int(SampleStatus.NOT_COMPUTED), seen.status)
        report = SampleReport(status, guard.samples_missed)
        memory = GuardedMemory(inner, guard, last, memory.period)
        return memory, self._safe(last, computed), report

    def _safe(self, last: Any, used: Any) -> Any:
        """The last accepted command, or that in its place unless this sample was used."""
        if self.guard.on_bad == "hold":
            return last

        def gated(value: Any) -> Any:
            return jnp.where(used, value, jnp.zeros_like(value))

        if not hasattr(last, "_fields"):
            return jax.tree.map(gated, last)
        sent = [name for name in last._fields if name in ACTUATED]
        return last._replace(**{name: gated(getattr(last, name)) for name in sent})


def finite(tree: Any, known: Any = ()) -> Any:
    """Whether all real numbers of a tree, and their sum, are finite.

    Args:
        tree: Of arrays.
        known: Tree of arrays that are finite; where they are in the tree too, they are not tested.
    """
    # one test of a sum: it is smaller and faster in flight code than a test of each
    every = {id(leaf): leaf for leaf in jax.tree.leaves(tree)}
    for leaf in jax.tree.leaves(known):
        every.pop(id(leaf), None)
    sums = [
        jnp.sum(leaf)
        for leaf in every.values()
        if jnp.issubdtype(jnp.result_type(leaf), jnp.floating) and jnp.size(leaf)
    ]
    while len(sums) > 1:
        odd = sums[-1:] if len(sums) % 2 else []
        sums = [a + b for a, b in zip(sums[::2], sums[1::2], strict=False)] + odd
    return jnp.isfinite(sums[0]) if sums else jnp.array(True)


def _as(like: Any, function: Any) -> Any:
    """The function, its results of the types of an example."""
    return lambda: jax.tree.map(lambda x, y: jnp.asarray(x, y.dtype), function(), like)
