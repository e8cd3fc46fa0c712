"""Messages of a function of Python name its arguments, those of the command line its options."""

from collections.abc import Callable
from functools import wraps
from typing import Any

from gyrostat.core.errors import InputError


def naming_arguments(verb: Callable[..., Any]) -> Callable[..., Any]:
    """Function whose messages have `on_bad` in place of the option `--on-bad`.

    Args:
        verb: Function of the package `gyrostat`, with the options of a command as arguments.
    """

    @wraps(verb)
    def named(*given: Any, **options: Any) -> Any:
        try:
            return verb(*given, **options)
        except InputError as error:
            message, *more = error.args
            error.args = (_with_arguments(verb, message), *more)
            raise

    named.__module__ = "gyrostat"  # where a process that gets the function finds it
    return named


def _with_arguments(verb: Callable[..., Any], message: str) -> str:
    import re  # both are slow to import
    from inspect import signature

    names = signature(verb).parameters

    def argument(option: re.Match[str]) -> str:
        name = option[1].replace("-", "_")
        return next((each for each in (name, f"{name}_") if each in names), option[0])

    return re.sub(r"(?<![\w-])--([a-z][a-z-]*)", argument, message)
