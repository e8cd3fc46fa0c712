"""The command line. Heavy imports are made inside the verbs, so that --help answers at once."""

import gc
import os
import sys
from pathlib import Path

import typer

from gyrostat.arguments import say
from gyrostat.cli.campaign import campaign, replay, report, simulate
from gyrostat.cli.export import export
from gyrostat.cli.paper import reproduce
from gyrostat.cli.recovery import recover
from gyrostat.cli.spacecraft import holdable
from gyrostat.cli.wheel import bench, identify, validate
from gyrostat.errors import InputError

__all__ = ["app", "main"]

app = typer.Typer(
    help="Reaction wheels: from a bench record to a friction model and beyond.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
for _verb in (
    *(identify, validate, bench, holdable, recover),
    *(simulate, campaign, replay, report, export, reproduce),
):
    app.command()(_verb)


def _use_compilation_cache() -> None:
    """Keep compiled code between runs; JAX reads these when it is first imported."""
    root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(root / "gyrostat" / "jax"))
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0.05")


def main() -> None:
    """Run the command line: 0 done, 1 no valid result, 2 wrong usage or bad input."""
    _use_compilation_cache()
    # imports and tracing make many objects that all stay: looking through them again and again
    # takes a tenth of a short command
    gc.set_threshold(200_000)
    try:
        app()
    except InputError as error:
        say(f"error: {error}")
        sys.exit(2)
    except KeyboardInterrupt:
        say("interrupted: nothing half-written was left behind")
        sys.exit(130)
