"""Further sensors beside those of a spacecraft."""

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol
from zlib import crc32

from jaxtyping import PRNGKeyArray

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.named_tuples import with_fields
from gyrostat.core.validation import check_parts, check_period

_KEYS = 0xADDED
"""Number that separates the random keys of added sensors from all others."""


class AddedSensor(Protocol):
    """Protocol of a further sensor.

    The optional attribute `unit` is the unit of the value, shown in histories.
    """

    def start(self, state: Any, period: Scalar) -> Any:
        """Memory before the first sample.

        Args:
            state: State of the plant at time 0.
            period: Control period, s.
        """
        ...

    def __call__(self, memory: Any, state: Any, key: PRNGKeyArray) -> tuple[Any, Any]:
        """Measure.

        Args:
            memory: Memory from the last sample.
            state: State of the plant.
            key: Random key of the noise of this sample.

        Returns:
            The new memory, and the value: a number or an array.
        """
        ...


class _Memory(NamedTuple):
    sensor: Any
    added: dict[str, Any]


class AddedSensors(Checked):
    """Sensor with further fields in its measurement, each from a sensor of its own.

    The random key of an added sensor depends on its name only: the noise of the other sensors does
    not change when one is added.

    Attributes:
        sensor: Any sensor whose measurement is a named tuple.
        added: Name of the additional field -> its sensor.
    """

    sensor: Any
    added: Mapping[str, AddedSensor]

    def check_own(self) -> None:
        """Validate the added sensors; raises `InputError`."""
        check_parts(*self.added.values())

    def check_own_period(self, period: float) -> None:
        """Validate the control period, s, for the added sensors; raises `InputError`."""
        check_period(period, *self.added.values())

    def start(self, state: Any, period: Scalar) -> _Memory:
        """Memory before the first sample."""
        added = {name: sensor.start(state, period) for name, sensor in self.added.items()}
        return _Memory(self.sensor.start(state, period), added)

    def __call__(self, memory: _Memory, state: Any, key: PRNGKeyArray) -> tuple[_Memory, Any]:
        """Measure.

        Raises:
            InputError: An added field has the name of another field, or a name by which a flag of
                the measurement would apply to it.
        """
        inner, measurement = self.sensor(memory.sensor, state, key)
        memories, values, units = {}, {}, {}
        for name in sorted(self.added):
            _check_name(name, measurement._fields)
            sensor_key = jax.random.fold_in(jax.random.fold_in(key, _KEYS), crc32(name.encode()))
            memories[name], value = self.added[name](memory.added[name], state, sensor_key)
            values[name] = jnp.asarray(value)
            unit = getattr(self.added[name], "unit", None)
            if isinstance(unit, str):
                units[name] = unit
        return _Memory(inner, memories), with_fields("Added", measurement, values, units)


def _check_name(name: str, fields: tuple[str, ...]) -> None:
    if name in fields:
        raise InputError(
            f"sensor {name}: found the name of another sensor, expected a name other than "
            f"{', '.join(fields)}"
        )
    for flag in fields:
        prefix = flag.removesuffix("_measured")
        if prefix != flag and name.startswith(f"{prefix}_"):
            raise InputError(
                f"sensor {name}: found a name that begins with {prefix}_, expected another name: "
                f"{flag} states whether such fields are measured"
            )
