"""Messages of a function of Python name its arguments, those of the command line its options."""

import inspect
import re
from collections.abc import Callable
from functools import wraps
from typing import Any

from gyrostat.core.errors import InputError

_OPTION = re.compile(r"(?<![\w-])--([a-z][a-z-]*)")


def naming_arguments(verb: Callable[..., Any]) -> Callable[..., Any]:
    """Function whose messages have `on_bad` in place of the option `--on-bad`.

    Args:
        verb: Function of the package `gyrostat`, with the options of a command as arguments.
    """
    names = inspect.signature(verb).parameters

    def argument(option: re.Match[str]) -> str:
        name = option[1].replace("-", "_")
        return next((each for each in (name, f"{name}_") if each in names), option[0])

    @wraps(verb)
    def named(*given: Any, **options: Any) -> Any:
        try:
            return verb(*given, **options)
        except InputError as error:
            message, *more = error.args
            error.args = (_OPTION.sub(argument, message), *more)
            raise

    named.__module__ = "gyrostat"  # where a process that gets the function finds it
    return named
