"""Control loop: continuous plant, sampled sensor and sampled controller, as one scan."""

from collections.abc import Callable
from enum import IntEnum
from functools import partial
from typing import Any, NamedTuple, Protocol

from jaxtyping import Array, Bool, Int, PRNGKeyArray

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.simulation.command_delay import delay_line, delayed


class Plant(Protocol):
    """Protocol of the controlled system: dynamics, including dry friction.

    Optional methods validate by `InputError`: `check()` the parameters of a plant, sensor or
    controller, `check_period(period)` their parameters for a control period, and
    `check_state(state)` the initial state of a plant.
    """

    def __call__(self, state: Any, command: Any, time: Scalar, duration: Scalar) -> tuple[Any, Any]:
        """Integrate over an interval of constant command.

        Fields of the command on which the result depends are those that go to actuators.

        Args:
            state: State at the start.
            command: Command, constant during the interval.
            time: Time at the start, s.
            duration: Length of the interval, s.

        Returns:
            The state at the end, and whether the interval was resolved.
        """
        ...

    def diverged(self, state: Any) -> Any:
        """Whether the state is outside the range of valid operation."""
        ...

    def record(self, state: Any, command: Any) -> Any:
        """Signals to record in addition to state and command, a named tuple."""
        ...


class Sensor(Protocol):
    """Protocol of a sensor, sampled once in each control period."""

    def start(self, state: Any, period: Scalar) -> Any:
        """Memory before the first sample."""
        ...

    def __call__(self, memory: Any, state: Any, key: PRNGKeyArray) -> tuple[Any, Any]:
        """Measure; returns the new memory and the measurement, a named tuple."""
        ...


class Controller(Protocol):
    """Protocol of a controller, sampled once in each control period."""

    def start(self, period: Scalar) -> Any:
        """Memory before the first measurement."""
        ...

    def __call__(self, memory: Any, measurement: Any) -> tuple[Any, Any]:
        """Compute a command; returns the new memory and the command, a named tuple.

        Fields on which the plant's motion depends go to actuators, after the command delay if there
        is one. The others, such as a target or an estimate, are recorded at this sample.
        """
        ...


class Status(IntEnum):
    """Status at the end of a run."""

    COMPLETE = 0
    DIVERGED = 1
    UNRESOLVED = 2
    BAD_COMMAND = 3


class Histories(NamedTuple):
    """Signals of one run at the sample times; the first axis is time.

    Attributes:
        state: State of the plant.
        measurement: Measurement at each time.
        command: Command. Fields that go to actuators: the values that act from each time. Other
            fields: the values computed at each time.
        record: Record of the plant.
        status: Status of the run up to each time.
    """

    state: Any
    measurement: Any
    command: Any
    record: Any
    status: Int[Array, " time"]


def _finite(tree: Any) -> Bool[Array, ""]:
    leaves = [jnp.all(jnp.isfinite(leaf)) for leaf in jax.tree.leaves(tree)]
    return jnp.all(jnp.stack(leaves)) if leaves else jnp.array(True)


class Loop(NamedTuple):
    """One run as two functions: its initialisation and one control period.

    Attributes:
        begin: Initialisation, () -> carry before the first sample.
        tick: Control period, (carry, k) -> (carry, record of sample k). The record is `Histories`
            unless the loop is folded.
    """

    begin: Callable[[], Any]
    tick: Callable[[Any, Any], tuple[Any, Any]]

    def folded(self, fold: Callable[[Any, Any, Any], tuple[Any, Any]], first: Any) -> "Loop":
        """Reduce the samples by a function during the run, for runs too long to record.

        Args:
            fold: (accumulator, record of sample k, k) -> (accumulator, record that replaces it).
            first: Accumulator before the first sample.

        Returns:
            A loop whose carry is (carry of this loop, accumulator).
        """

        def begin() -> tuple[Any, Any]:
            return self.begin(), first

        def tick(carry: tuple[Any, Any], k: Any) -> tuple[tuple[Any, Any], Any]:
            inner, accumulator = carry
            inner, row = self.tick(inner, k)
            accumulator, row = fold(accumulator, row, k)
            return (inner, accumulator), row

        return Loop(begin, tick)

    def scan(self, carry: Any, first: Any, length: int) -> tuple[Any, Any]:
        """Run several control periods.

        Args:
            carry: Carry from `begin` or from the previous scan.
            first: Index of the first sample.
            length: Number of samples.

        Returns:
            The carry after them, and their records with a leading axis of samples.
        """

        def step(pair, _):
            k, carry = pair
            carry, row = self.tick(carry, k)
            return (k + 1, carry), row

        (_, carry), rows = jax.lax.scan(step, (first, carry), length=length)
        return carry, rows


def control_loop(
    plant: Plant,
    controller: Controller,
    sensor: Sensor,
    state: Any,
    key: PRNGKeyArray | Callable[[Any], PRNGKeyArray],
    period: Scalar,
    *,
    substeps: int = 1,
    command_delay: int = 0,
) -> Loop:
    """Closed loop of plant, sensor and controller; pure, for `jit`, `vmap` and `jvp`.

    Args:
        plant: Controlled system.
        controller: Controller.
        sensor: Sensor.
        state: State of the plant at time 0.
        key: Random key of the noise, and the key of sample k depends only on this key and k; or a
            function of k that gives the key of a sample.
        period: Control period, s.
        substeps: Integration steps in each control period.
        command_delay: Control periods from a sample to the start of the command computed from it.
            Until the first command arrives, actuators get zero, or the command of the plant's
            optional method `steady_command(state, zeros)`, under which its motion goes on as
            before, such as the present speeds of wheels that are commanded by speed. Fields of the
            command on which the plant's motion does not depend are not delayed.

    Returns:
        The loop. The state of a run that has failed stays constant.
    """
    key_of = key if callable(key) else partial(jax.random.fold_in, key)

    def integrate(state, command, time, length):
        step = length / substeps

        def substep(carry, k):
            state, resolved = carry
            state, fine = plant(state, command, time + k * step, step)
            return (state, resolved & fine), None

        if substeps == 1:  # avoids the compilation of a scan
            return plant(state, command, time, length)
        return jax.lax.scan(substep, (state, jnp.array(True)), jnp.arange(substeps))[0]

    def control(memory, measurement):
        memory, command = controller(memory, measurement)
        # a controller may return Python numbers
        return memory, jax.tree.map(jnp.asarray, command)

    def classify(state, status):
        # computed together with the measurement, which may share intermediate results
        diverged = ~_finite(state) | plant.diverged(state)
        return jnp.where((status == 0) & diverged, int(Status.DIVERGED), status)

    def begin():
        sensed = sensor(sensor.start(state, period), state, key_of(0))
        memory, line = controller.start(period), ()
        if command_delay:  # without one, no command is traced for its shapes
            _, command = jax.eval_shape(control, memory, sensed[1])
            line = delay_line(plant, state, command, period, command_delay)
        return state, sensed, memory, line, classify(state, jnp.array(int(Status.COMPLETE)))

    def tick(carry, k):
        # the measurement is part of the carry: otherwise XLA would recompute it, including its
        # noise, for each of its uses
        state, sensed, memory, line, status = carry
        sensor_memory, measurement = sensed
        memory, command = control(memory, measurement)
        status = jnp.where((status == 0) & ~_finite(command), int(Status.BAD_COMMAND), status)
        line, command = delayed(line, command)
        goes_on = status == 0
        # a diverged state would need many integration steps, which would delay the whole batch
        length = jnp.where(goes_on, period, 0.0)
        next_state, resolved = integrate(state, command, k * period, length)
        row = Histories(state, measurement, command, plant.record(state, command), status)
        state = jax.tree.map(lambda new, old: jnp.where(goes_on, new, old), next_state, state)
        status = classify(state, jnp.where(goes_on & ~resolved, int(Status.UNRESOLVED), status))
        sensed = sensor(sensor_memory, state, key_of(k + 1))
        return (state, sensed, memory, line, status), row

    return Loop(begin, tick)


def run(
    plant: Plant,
    controller: Controller,
    sensor: Sensor,
    state: Any,
    key: PRNGKeyArray,
    period: Scalar,
    *,
    count: int,
    substeps: int = 1,
    command_delay: int = 0,
) -> Histories:
    """Run the closed loop for `count` control periods; for other arguments see `control_loop`.

    Returns:
        Histories of `count` + 1 samples.
    """
    options = {"substeps": substeps, "command_delay": command_delay}
    loop = control_loop(plant, controller, sensor, state, key, period, **options)
    return loop.scan(loop.begin(), jnp.array(0), count + 1)[1]
