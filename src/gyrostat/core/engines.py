"""Names of the engines that simulate."""

from collections.abc import Callable

from gyrostat.core.errors import InputError

ENGINES = ("auto", "native", "jax")
"""Compiled C where that is possible; compiled C with one run in each SIMD lane; JAX."""


def engine_named(name: str, say: Callable[[str], None], option: str = "engine") -> str:
    """The engine of a name; says so where the name is a former one.

    Args:
        name: Name of the engine.
        say: Takes a line about a former name.
        option: For messages.

    Raises:
        InputError: There is no such engine.
    """
    if name == "lanes":
        say(f"{option}: lanes is now called native")
        return "native"
    if name not in ENGINES:
        raise InputError(f"{option}: found {name!r}, expected one of {', '.join(ENGINES)}")
    return name
