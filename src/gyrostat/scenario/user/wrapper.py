"""Base of the wrappers around the parts of a user."""

from typing import Any

import equinox as eqx

from gyrostat.core.jax64 import jax
from gyrostat.core.user_errors import numbers, reported
from gyrostat.core.validation import check_parts
from gyrostat.scenario.user.live_calls import compare_live
from gyrostat.scenario.user.recording import record


class UserWrapper(eqx.Module):
    """Part of a user in a run.

    Attributes:
        inner: Instance of the user's class, or a function.
        name: Name of the part, for messages.
    """

    inner: Any
    name: str = eqx.field(static=True)

    @property
    def _module(self) -> str:
        """Module of the user's class or function."""
        is_function = isinstance(self.inner, jax.tree_util.Partial)
        return (self.inner.func if is_function else type(self.inner)).__module__

    def check(self) -> None:
        """Validate parameters; raises `InputError`."""
        with reported(self.name, self._module):
            check_parts(self.inner)

    def called(self, method: str, *arguments: Any) -> Any:
        """Result of a method of the part, which is traced again during a trial.

        Raises:
            InputError: The method raised an exception, or the part is not pure; see `record`.
        """
        with reported(self.name, self._module):
            result = getattr(self.inner, method)(*arguments)
        self.tried(method, *arguments)
        return result

    def tried(self, method: str, *arguments: Any, simulated: bool = True) -> None:
        """Trace a method of the part during a trial, and only then.

        During a comparison with the object in memory, its method is traced, too.

        Raises:
            InputError: See `called`.
        """

        def call() -> Any:
            with reported(self.name, self._module):
                return getattr(self.inner, method)(*arguments)

        compare_live(self.name, self.inner, method, arguments, call)
        record(self.name, method, self._module, call, simulated=simulated)

    def begun(self, *arguments: Any) -> Any:
        """Memory that the method `start` of the part returns.

        Raises:
            InputError: The method raised an exception, or the memory is not a tree of numbers.
        """
        memory = self.called("start", *arguments)
        return jax.tree.map(lambda leaf: numbers(self.name, "memory", leaf), memory)
