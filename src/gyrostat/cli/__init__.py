"""Command line. Heavy imports are made inside the verbs, so that --help is fast."""

import atexit
import functools
import gc
import os
import sys
from collections.abc import Callable
from typing import Annotated, Any

import typer

from gyrostat import __version__
from gyrostat.cli.arguments import say
from gyrostat.cli.cache import cache
from gyrostat.cli.campaign import campaign, check, replay, report, simulate, tune
from gyrostat.cli.comparison import compare
from gyrostat.cli.error_budget import budget
from gyrostat.cli.export import export
from gyrostat.cli.feasibility import feasible
from gyrostat.cli.gyro import allan
from gyrostat.cli.lots import lot
from gyrostat.cli.microvibration import jitter, waterfall
from gyrostat.cli.monitoring import monitor
from gyrostat.cli.paper import reproduce
from gyrostat.cli.placement import place
from gyrostat.cli.pools import pool
from gyrostat.cli.recovery import recover
from gyrostat.cli.speed_plan import plan_speeds
from gyrostat.cli.verb import Verb
from gyrostat.cli.wheel import bench, identify, validate
from gyrostat.core.errors import InputError, one_line
from gyrostat.core.instructions import NAME, limit_process
from gyrostat.core.jax_cache import keep_programs

__all__ = ["app", "main"]


def _keeping_programs(verb: Callable[..., None]) -> Callable[..., None]:
    """Verb with a private cache of compiled programs, which is set up before JAX is imported.

    Linear algebra has one thread, unless the environment says otherwise: threads slow down matrices
    as small as ours, and their number changes the last digits.
    """

    @functools.wraps(verb)
    def keeping(*arguments: Any, **options: Any) -> None:
        if "OMP_NUM_THREADS" not in os.environ:
            os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        keep_programs(say)
        verb(*arguments, **options)

    return keeping


app = typer.Typer(
    help="Reaction wheels: identification, simulation, Monte Carlo campaigns and flight code.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # otherwise brackets in help texts are read as markup
)


def _print_version(is_requested: bool) -> None:
    if is_requested:
        typer.echo(f"gyrostat {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version and exit."
        ),
    ] = False,
) -> None:
    pass


for _verb in (
    *(identify, validate, compare, pool, lot, monitor, bench, allan, waterfall, jitter),
    *(feasible, recover, check, place, simulate, campaign, budget, tune, plan_speeds),
    *(replay, report, export, reproduce, cache),
):
    app.command(cls=Verb)(_keeping_programs(_verb))
app.command("holdable", cls=Verb, help="Old name of `feasible`.")(_keeping_programs(feasible))


# the common base class of typer's errors, which typer does not export
_WrongUsage: Any = next(c for c in typer.BadParameter.__mro__ if c.__name__ == "ClickException")


def _help_of(error: Any) -> str:
    """Command that shows the help of the verb that was used wrongly."""
    context = getattr(error, "ctx", None)
    verb = () if context is None or context.parent is None else (context.info_name,)
    return " ".join(("gyrostat", *verb, "--help"))


def main() -> None:
    """Run the command line: 0 done, 1 no valid result, 2 wrong usage or bad input."""
    # imports and tracing create many long-lived objects: scanning them for garbage takes a tenth of
    # the time of a short command, and the interpreter's last scan at its end a fifth
    gc.set_threshold(500_000)
    atexit.register(gc.freeze)
    try:
        limit_process(os.environ.get(NAME))
        code = app(standalone_mode=False)
    except _WrongUsage as error:
        if len(sys.argv) == 1:
            error.show()  # prints the help
        else:
            say(one_line(f"error: {error.format_message()} (see {_help_of(error)})"))
        sys.exit(error.exit_code)
    except InputError as error:
        say(f"error: {error}")
        sys.exit(2)
    except KeyboardInterrupt:
        code = 130
    if code == 130:
        say("interrupted: no incomplete file was left")
    if code:
        sys.exit(code)
