"""Controller with validated measurements."""

from typing import Any, NamedTuple

import equinox as eqx

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
"""Fields of a command that go to actuators. The safe command "zero" sets them to zero."""
SMALL = 16
"""Largest number of elements of an array that is tested to be finite in one sum with others."""


class GuardedMemory(NamedTuple):
    """State of a guarded controller between two samples.

    Attributes:
        controller: Memory of the controller.
        guard: Memory of the validation.
        command: Last command that the controller computed from an accepted sample.
        period: Control period, s.
    """

    controller: Any
    guard: GuardMemory
    command: Any
    period: Scalar


class Guarded(Checked):
    """Controller that tolerates invalid samples.

    The controller computes a command from each sample that the guard accepts. If the guard rejects
    a sample, the command is the safe one (the last accepted command, or zero), and the method
    `predicted` of the controller gives its next memory. The same happens if an accepted sample
    leads to a command or a memory that is not finite. Memory and command therefore always stay
    finite, and rejected samples do not affect how the next valid sample is used.

    Two signals are recorded with the command: `sample_status`, a `SampleStatus`, and
    `samples_missed`, the number of samples since the last accepted one.

    Attributes:
        controller: Any controller of the loop. It may offer `predicted(memory, measurement,
            command)`, which gives its memory one period later without a sample, from the last
            accepted measurement and the safe command that is sent. By default its memory is
            unchanged.
        guard: Limits of the measurement, and the choice of the safe command.
        actuators: Fields of the command that go to actuators, in addition to `ACTUATED`.
    """

    controller: Any
    guard: MeasurementGuard
    actuators: tuple[str, ...] = eqx.field(static=True, default=())

    def check_own_period(self, period: float) -> None:
        """Check that the controller can give a command at a control period, s.

        Raises:
            InputError: The initial memory of the controller is not finite.
        """
        if not _starts_finite(self.controller, period):
            raise InputError(
                f"{type(self.controller).__name__}: found a memory that is not finite at the "
                "start, expected finite numbers"
            )

    def start(self, period: Scalar) -> GuardedMemory:
        """Initial memory; the safe command is zero until a sample has been accepted.

        Args:
            period: Control period, s.

        Raises:
            InputError: The safe command is zero, but the command has no field for an actuator.
        """
        inner, guard = self.controller.start(period), self.guard.start()
        _, command = jax.eval_shape(self.controller, inner, guard.last)
        actuated = (*ACTUATED, *self.actuators)
        fields = getattr(command, "_fields", actuated)
        if self.guard.on_bad == "zero" and not set(fields) & set(actuated):
            raise InputError(
                f"{type(self.controller).__name__}: found a command of {', '.join(fields)}, "
                f"expected one of {', '.join(actuated)} for the safe command zero"
            )
        zero = jax.tree.map(lambda shape: jnp.zeros(shape.shape, shape.dtype), command)
        return GuardedMemory(inner, guard, zero, jnp.asarray(period, dtype=float))

    def __call__(self, memory: GuardedMemory, measurement: Any) -> tuple[GuardedMemory, Any]:
        """Compute the command, with the status of the sample as additional fields.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement as the sensors give it.
        """
        memory, command, report = self.step(memory, measurement)
        if not hasattr(command, "_fields"):
            return memory, command
        return memory, recorded_with("Guarded", command, report)

    def step(
        self, memory: GuardedMemory, measurement: Any
    ) -> tuple[GuardedMemory, Any, SampleReport]:
        """Compute memory, command and status of the sample, with the status as a separate result.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement as the sensors give it.
        """
        sample = self.guard(memory.guard, measurement, memory.period)
        like = jax.tree.map(jnp.asarray, (memory.controller, memory.command, jnp.array(False)))

        def compute() -> tuple[Any, Any, Any]:
            # without barriers XLA computes the controller again for every result that needs it
            measurement = jax.lax.optimization_barrier(sample.measurement)
            outputs = self.controller(memory.controller, measurement)
            inner, command = jax.lax.optimization_barrier(outputs)
            return inner, command, finite(_new(outputs, (inner, command), memory.controller))

        inner, command, computed = jax.lax.cond(sample.good, _as(like, compute), lambda: like)

        def accept() -> tuple[Any, GuardMemory, Any]:
            return inner, sample.used, command

        def predict() -> tuple[Any, GuardMemory, Any]:
            previous, safe = memory.controller, self._safe(memory.command, jnp.array(False))
            later = predicted(self.controller, previous, memory.guard.last, safe)
            is_finite = finite(later, previous)
            later = jax.tree.map(lambda new, old: jnp.where(is_finite, new, old), later, previous)
            return later, sample.missed, memory.command

        like = jax.tree.map(jnp.asarray, (memory.controller, memory.guard, memory.command))
        inner, guard, last = jax.lax.cond(computed, _as(like, accept), _as(like, predict))
        status = jnp.where(sample.good & ~computed, int(SampleStatus.NOT_COMPUTED), sample.status)
        report = SampleReport(status, guard.samples_missed)
        memory = GuardedMemory(inner, guard, last, memory.period)
        return memory, self._safe(last, computed), report

    def _safe(self, command: Any, computed: Any) -> Any:
        """Last accepted command; if this sample was not used, the safe command."""
        if self.guard.on_bad == "hold":
            return command

        def gate(value: Any) -> Any:
            return jnp.where(computed, value, jnp.zeros_like(value))

        if not hasattr(command, "_fields"):
            return jax.tree.map(gate, command)
        actuated = (*ACTUATED, *self.actuators)
        names = [name for name in command._fields if name in actuated]
        return command._replace(**{name: gate(getattr(command, name)) for name in names})


def _new(outputs: Any, after: Any, before: Any) -> list[Any]:
    """Leaves of a tree that a controller has computed, each once.

    Args:
        outputs: Outputs of the controller.
        after: The same numbers behind a barrier, whose leaves are returned.
        before: Memory before; a leaf that the controller has passed on is left out.
    """
    given = {id(leaf) for leaf in jax.tree.leaves(before)}
    pairs = zip(jax.tree.leaves(outputs), jax.tree.leaves(after), strict=True)
    return list({id(output): leaf for output, leaf in pairs if id(output) not in given}.values())


def finite(tree: Any, known: Any = ()) -> Any:
    """Whether all real numbers of a tree, and some sums of them, are finite.

    Args:
        tree: Tree of arrays.
        known: Tree of arrays that are known to be finite. They are not tested if they are also in
            `tree`.
    """
    # in flight code, one test of a sum is smaller and faster than a test of each number
    every = {id(leaf): leaf for leaf in jax.tree.leaves(tree)}
    for leaf in jax.tree.leaves(known):
        every.pop(id(leaf), None)
    leaves = [x for x in every.values() if jnp.issubdtype(jnp.result_type(x), jnp.floating)]
    small = [jnp.ravel(leaf) for leaf in leaves if jnp.size(leaf) <= SMALL]
    arrays = [leaf for leaf in leaves if jnp.size(leaf) > SMALL]
    arrays += [jnp.concatenate([jnp.zeros(1), *small])] if small else []
    is_finite = jnp.array(True)
    for array in arrays:
        is_finite &= jnp.isfinite(jnp.sum(array))
    return is_finite


@eqx.filter_jit
def _starts_finite(controller: Any, period: float) -> Any:
    """Whether the initial memory is finite; as one program, which compiles in less time."""
    return finite(controller.start(period))


def _as(like: Any, function: Any) -> Any:
    """Function with its results converted to the types of an example."""
    return lambda: jax.tree.map(lambda x, y: jnp.asarray(x, y.dtype), function(), like)
