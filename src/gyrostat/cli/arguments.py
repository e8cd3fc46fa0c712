"""Interface between command line and verbs: pass options, print JSON."""

import shlex
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from gyrostat.verbs.arguments import to_stderr as say

__all__ = ["call", "print_json", "say"]


def call(verb: Callable[..., Any], options: Mapping[str, Any], **further: Any) -> Any:
    """Call a verb with the options of the command line.

    Args:
        verb: Function of `gyrostat.verbs` with these options.
        options: Name -> value; `json_output` is not passed on.
        further: Arguments that are not options.
    """
    arguments = {name: value for name, value in options.items() if name != "json_output"}
    return verb(**arguments, **further, say=say)


def command_line() -> str:
    """Command typed by the user, quoted for a shell."""
    return shlex.join(["gyrostat", *sys.argv[1:]])


def print_json(file: Path) -> None:
    """Print a JSON file that a verb has written."""
    sys.stdout.write(file.read_text(encoding="utf-8"))
