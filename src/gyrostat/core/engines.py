"""Names of the engines that simulate, and the message that JAX replaces the native engine."""

from collections.abc import Callable, Sequence

from gyrostat.core.errors import InputError
from gyrostat.core.messages import silent, to_stderr

ACCELERATED = ("opencl", "cuda")
"""Engines that use an accelerator, with one run in each work item."""
ENGINES = ("auto", "native", "jax")
"""auto: native if possible; native: compiled C with one run in each SIMD lane; jax: JAX."""


def engine_named(
    name: str,
    say: Callable[[str], None],
    option: str = "engine",
    engines: Sequence[str] = ENGINES,
) -> str:
    """Validate the name of an engine; former names are replaced and reported.

    Args:
        name: Name of the engine.
        say: Called with a message about a former name.
        option: Name of the option, for messages.
        engines: Names of the engines that can be used.

    Raises:
        InputError: No engine has this name.
    """
    if name == "lanes":
        say(f"{option}: lanes is now called native")
        return "native"
    if name not in engines:
        raise InputError(f"{option}: found {name!r}, expected one of {', '.join(engines)}")
    return name


def say_slower(reason: object, say: Callable[[str], None]) -> None:
    """Say in one line why JAX computes although nobody asked for it; on stderr if `say` is silent.

    The factor is that of three wheels with dry friction, 64 runs (docs/benchmarks.md): 761 against
    27.6 times the speed of Basilisk.

    Args:
        reason: Why the native engine cannot.
        say: Function that receives a message for the user.
    """
    line = f"{reason}; using the engine JAX, which is some 30 times slower"
    (to_stderr if say is silent else say)(line)
