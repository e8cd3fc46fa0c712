"""Base of the wrappers around the parts of a user."""

from typing import Any

import equinox as eqx

from gyrostat.core.jax64 import jax
from gyrostat.core.user_errors import numbers, reported
from gyrostat.core.validation import check_parts


class Own(eqx.Module):
    """Part of a user in a run.

    Attributes:
        inner: Instance of the user's class, or a function.
        name: Name of the part, for messages.
    """

    inner: Any
    name: str = eqx.field(static=True)

    def check(self) -> None:
        """Validate parameters; raises `InputError`."""
        with reported(self.name):
            check_parts(self.inner)

    def begun(self, *arguments: Any) -> Any:
        """Memory that the method `start` of the part returns.

        Raises:
            InputError: The method raised an exception, or the memory is not a tree of numbers.
        """
        with reported(self.name):
            memory = self.inner.start(*arguments)
        return jax.tree.map(lambda leaf: numbers(self.name, "memory", leaf), memory)
