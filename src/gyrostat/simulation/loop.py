"""The control loop: continuous plant, sampled sensor and sampled controller, as one scan."""

from collections.abc import Callable
from enum import IntEnum
from typing import Any, NamedTuple, Protocol

from jaxtyping import Array, Bool, Int, PRNGKeyArray

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.simulation.delay_line import delay_line, delayed


class Plant(Protocol):
    """What is controlled. It owns its physics and its dry friction.

    A plant, sensor or controller may have `check()`, which refuses parameters by `InputError`, and
    a plant `check_state(state)`, which refuses a start that is none of its states; any of them
    `check_period(period)`, which refuses them at a control period.
    """

    def __call__(self, state: Any, command: Any, time: Scalar, duration: Scalar) -> tuple[Any, Any]:
        """Carry the state over an interval of held command: the new state; whether resolved.

        The fields of the command on which either depends are those that go to actuators.
        """
        ...

    def diverged(self, state: Any) -> Any:
        """Whether the state is beyond what any controller could mean."""
        ...

    def record(self, state: Any, command: Any) -> Any:
        """What is worth recording beside state and command."""
        ...


class Sensor(Protocol):
    """What measures the plant, once in each control period."""

    def start(self, state: Any, period: Scalar) -> Any:
        """Memory before the first sample."""
        ...

    def __call__(self, memory: Any, state: Any, key: PRNGKeyArray) -> tuple[Any, Any]:
        """Measure: the new memory; the measurement, a named tuple."""
        ...


class Controller(Protocol):
    """What turns measurements into commands, once in each control period."""

    def start(self, period: Scalar) -> Any:
        """Memory before the first measurement."""
        ...

    def __call__(self, memory: Any, measurement: Any) -> tuple[Any, Any]:
        """Command: the new memory; the command, a named tuple.

        Fields that the plant's motion depends on go to actuators, after the command delay if there
        is one. The others, such as a target or an estimate, are recorded at this sample.
        """
        ...


class Status(IntEnum):
    """How a run ended."""

    COMPLETE = 0
    DIVERGED = 1
    UNRESOLVED = 2
    BAD_COMMAND = 3


class Histories(NamedTuple):
    """Signals of one run at the control times, first axis time.

    Attributes:
        state: State of the plant.
        measurement: Measurement made at each time.
        command: Fields that go to actuators: the values that act from each time on. Other fields:
            the values made at each time.
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
    """One run as its beginning and one control period.

    Attributes:
        begin: () -> carry before the first sample.
        tick: (carry, k) -> (carry, what is recorded at sample k), which is `Histories` unless the
            loop is folded.
    """

    begin: Callable[[], Any]
    tick: Callable[[Any, Any], tuple[Any, Any]]

    def folded(self, fold: Callable[[Any, Any, Any], tuple[Any, Any]], first: Any) -> "Loop":
        """The loop with a function that takes in its samples, for runs too long to record.

        Args:
            fold: (kept so far, what is recorded at sample k, k) -> (kept, recorded instead).
            first: Kept before the first sample.

        Returns:
            A loop whose carry is (carry of this one, kept).
        """

        def begin() -> tuple[Any, Any]:
            return self.begin(), first

        def tick(carry: tuple[Any, Any], k: Any) -> tuple[tuple[Any, Any], Any]:
            inner, kept = carry
            inner, row = self.tick(inner, k)
            kept, row = fold(kept, row, k)
            return (inner, kept), row

        return Loop(begin, tick)

    def scan(self, carry: Any, first: Any, length: int) -> tuple[Any, Any]:
        """Some control periods.

        Args:
            carry: Of `begin`, or of the scan before.
            first: Number of the first sample.
            length: Number of samples.

        Returns:
            The carry after them, and what was recorded, with a leading axis of samples.
        """

        def step(counted, _):
            k, carry = counted
            carry, row = self.tick(carry, k)
            return (k + 1, carry), row

        (_, carry), rows = jax.lax.scan(step, (first, carry), length=length)
        return carry, rows


def control_loop(
    plant: Plant,
    controller: Controller,
    sensor: Sensor,
    state: Any,
    key: PRNGKeyArray,
    period: Scalar,
    *,
    substeps: int = 1,
    command_delay: int = 0,
) -> Loop:
    """The loop of plant, sensor and controller; pure, for `jit`, `vmap` and `jvp`.

    Args:
        plant: what is controlled.
        controller: gives the commands.
        sensor: gives the measurements.
        state: of the plant at time 0.
        key: of the noise; that of sample k comes from its number alone.
        period: control period, s.
        substeps: integration steps in each.
        command_delay: Control periods from a sample to the start of the command made from it; until
            the first command arrives, actuators get zero. Fields of the command that do not move
            the plant are not delayed.

    Returns:
        The loop. After a run has failed its state is frozen.
    """

    def stepped(state, command, time, length):
        step = length / substeps

        def substep(carry, k):
            state, resolved = carry
            state, fine = plant(state, command, time + k * step, step)
            return (state, resolved & fine), None

        if substeps == 1:  # one scan less to compile
            return plant(state, command, time, length)
        return jax.lax.scan(substep, (state, jnp.array(True)), jnp.arange(substeps))[0]

    def commanded(memory, measurement):
        memory, command = controller(memory, measurement)
        # a controller may command plain numbers
        return memory, jax.tree.map(jnp.asarray, command)

    def judged(state, status):
        # beside the measurement, which may need the same of the state
        diverged = ~_finite(state) | plant.diverged(state)
        return jnp.where((status == 0) & diverged, int(Status.DIVERGED), status)

    def begin():
        sensed = sensor(sensor.start(state, period), state, jax.random.fold_in(key, 0))
        memory = controller.start(period)
        _, command = jax.eval_shape(commanded, memory, sensed[1])
        line = delay_line(plant, state, command, period, command_delay)
        return state, sensed, memory, line, judged(state, jnp.array(int(Status.COMPLETE)))

    def tick(carry, k):
        # the measurement is carried from tick to tick: XLA would else compute it, noise and all,
        # anew for everything that is made from it
        state, sensed, memory, line, status = carry
        sensor_memory, measurement = sensed
        memory, command = commanded(memory, measurement)
        status = jnp.where((status == 0) & ~_finite(command), int(Status.BAD_COMMAND), status)
        line, command = delayed(line, command)
        goes_on = status == 0
        # what ended beyond all bounds needs many steps: a batch would wait for it to the end
        length = jnp.where(goes_on, period, 0.0)
        after, resolved = stepped(state, command, k * period, length)
        row = Histories(state, measurement, command, plant.record(state, command), status)
        state = jax.tree.map(lambda new, old: jnp.where(goes_on, new, old), after, state)
        status = judged(state, jnp.where(goes_on & ~resolved, int(Status.UNRESOLVED), status))
        sensed = sensor(sensor_memory, state, jax.random.fold_in(key, k + 1))
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
    """Run the loop for `count` control periods; for the other arguments see `control_loop`.

    Returns:
        Histories of `count` + 1 samples.
    """
    options = {"substeps": substeps, "command_delay": command_delay}
    loop = control_loop(plant, controller, sensor, state, key, period, **options)
    return loop.scan(loop.begin(), jnp.array(0), count + 1)[1]
