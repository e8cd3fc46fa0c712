"""Verbs on scenarios: simulate, campaign, replay, report."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gyrostat.cli.arguments import command_line, say
from gyrostat.cli.options import ForceModel, Json, Out
from gyrostat.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

Device = Annotated[str, typer.Option(help="cpu, or gpu where JAX sees one.")]
Engine = Annotated[
    str,
    typer.Option(help="lanes (compiled C), jax, or auto: lanes where there is a C compiler."),
]
Workers = Annotated[
    int | None, typer.Option(min=1, max=1024, help="Processes; by default one a core.")
]
Scheduler = Annotated[
    str | None, typer.Option(help="Address of a Dask scheduler that has workers.")
]


def simulate(
    scenario: Annotated[Path, typer.Argument(help="scenario.toml.")],
    out: Annotated[Path, typer.Option(help="netCDF file of the run; its report stands beside it.")],
    seed: Annotated[int, typer.Option(min=0, help="Of the noise.")] = 0,
    device: Device = "cpu",
    engine: Engine = "auto",
    force: ForceModel = False,
    json_output: Json = False,
) -> None:
    """Fly a scenario once, with its nominal values: RUN.nc and RUN.html."""
    from gyrostat.campaigns.fingerprint import FLAGS, engine_record, use_engine
    from gyrostat.core.outputs import check_outputs
    from gyrostat.core.validation import check_seed

    check_seed(seed)  # before anything is compiled
    if out.suffix != ".nc":
        raise InputError(f"--out: found {str(out)!r}, expected a name that ends in .nc")
    names = (out.name, out.with_suffix(".html").name)
    check_outputs(out.parent, names, by="simulate", force=force)
    _engine(engine)
    use_engine(engine_record(_device(device), FLAGS[device]))
    from gyrostat.campaigns.engine import fly
    from gyrostat.campaigns.execute import chosen_engine
    from gyrostat.campaigns.scenario_file import read_scenario
    from gyrostat.reports.campaign_run import write_run

    found = read_scenario(scenario, force=force)
    say(f"flying {found.name}: {found.duration:g} s")
    text = found.text()
    flown = fly(text, seed, None, keep=[0], engine=chosen_engine(engine, text, device, say))
    summary = write_run(found, flown, out, command=command_line(), say=say, force=force)
    if json_output:
        print(summary)
    if int(flown.columns["status"][0]) != 0:
        raise typer.Exit(1)


def campaign(
    scenario: Annotated[Path, typer.Argument(help="scenario.toml with [[dispersion]].")],
    runs: Annotated[int, typer.Option(min=1, help="How many.")],
    out: Out,
    seed: Annotated[int, typer.Option(min=0, help="Of everything that is drawn.")] = 0,
    workers: Workers = None,
    scheduler: Scheduler = None,
    device: Device = "cpu",
    engine: Engine = "auto",
    block: Annotated[
        int, typer.Option(min=1, max=2**32, help="Runs in a block; a multiple of 64 is best.")
    ] = 64,
    keep: Annotated[str, typer.Option(help="Runs whose histories are kept: 0,5,17.")] = "",
    worst: Annotated[int, typer.Option(min=0, help="So many worst runs are kept too.")] = 3,
    worst_by: Annotated[
        str | None, typer.Option(help="Metric; by default the last percentile of the error.")
    ] = None,
    force: Annotated[
        bool,
        typer.Option(
            "--force",
            help="Begin beside files of its names: renamed NAME.changed; take wheels marked as "
            "impossible.",
        ),
    ] = False,
) -> None:
    """Fly a scenario many times, each with its own draws; run again to go on after a stop."""
    from gyrostat.campaigns import cluster, run_campaign
    from gyrostat.campaigns.scenario_file import read_scenario
    from gyrostat.core.files import check_writable
    from gyrostat.reports.campaign import write_campaign

    check_writable(out)
    _device(device)
    _engine(engine)
    found = read_scenario(scenario, force=force)
    if not found.dispersions:
        raise InputError(f"{scenario}: key dispersion: found none, expected what shall scatter")
    opener = None if scheduler is None else cluster(scheduler)
    with _Progress() as told:
        run_campaign(
            found,
            out,
            runs=runs,
            seed=seed,
            device=device,
            engine=engine,
            opener=opener,
            workers=workers,
            block=block,
            keep=_numbers(keep),
            worst=worst,
            worst_by=worst_by,
            force=force,
            on_progress=told,
            say=say,
        )
    write_campaign(out, command=command_line(), say=say)


def replay(
    folder: Annotated[Path, typer.Argument(help="Of a finished campaign.")],
    run: Annotated[int, typer.Argument(min=0, help="Number of the run.")],
) -> None:
    """Fly one run of a campaign again, bit for bit: its history and a report of it."""
    from gyrostat.campaigns import Store, processes
    from gyrostat.campaigns import replay as fly_again
    from gyrostat.campaigns.fingerprint import refuse_other
    from gyrostat.reports.campaign import write_replay

    store = Store(folder, say)
    known = store.known()
    if run >= known.runs:
        raise InputError(f"run: found {run}, expected 0 to {known.runs - 1}")
    refuse_other(known.engine, str(folder))
    with store.locked():
        store.mend(known)
        path = fly_again(store, known, [run], processes(1))[0]
    write_replay(known, path, run, command=command_line(), say=say)


def report(
    folder: Annotated[Path, typer.Argument(help="Of a finished campaign.")],
    json_output: Json = False,
) -> None:
    """Say what a campaign has shown: report.html and report.json."""
    from gyrostat.reports.campaign import write_campaign

    text = write_campaign(folder, command=command_line(), say=say)
    if json_output:
        print(text)


def _device(name: str) -> str:
    from gyrostat.campaigns.fingerprint import FLAGS

    if name not in FLAGS:
        raise InputError(f"--device: found {name!r}, expected one of {', '.join(FLAGS)}")
    return name


def _engine(name: str) -> None:
    from gyrostat.campaigns.execute import ENGINES

    if name not in ENGINES:
        raise InputError(f"--engine: found {name!r}, expected one of {', '.join(ENGINES)}")


def _numbers(text: str) -> list[int]:
    try:
        return [int(part) for part in text.split(",") if part.strip()]
    except ValueError:
        raise InputError(f"--keep: found {text!r}, expected numbers with commas between") from None


class _Progress:
    """Runs done, their rate and the time left: a bar in a terminal, lines elsewhere."""

    def __enter__(self) -> "Callable[[int, int], None]":
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TaskID,
            TextColumn,
            TimeRemainingColumn,
        )

        console = Console(stderr=True)
        self._bar = Progress(
            TextColumn("runs"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            console=console,
            disable=not console.is_terminal,
        )
        self._bar.__enter__()
        self._task: TaskID | None = None
        return self._told

    def _told(self, done: int, total: int) -> None:
        import time

        now = time.monotonic()
        if self._task is None:
            self._begun, self._before, self._said = now, done, now
            self._task = self._bar.add_task("runs", total=total, completed=done, rate="")
            return
        rate = (done - self._before) / max(now - self._begun, 1e-9)
        self._bar.update(self._task, completed=done, rate=f"{rate:.1f} a second")
        if self._bar.disable and (now - self._said > 10.0 or done == total):
            self._said = now
            left = (total - done) / max(rate, 1e-9)
            say(f"{done} of {total} runs, {rate:.1f} a second, {left:.0f} s left")

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        self._bar.__exit__(kind, *rest)  # pyright: ignore[reportArgumentType]
        if kind is KeyboardInterrupt:
            say("stopped: the blocks that are done are kept; the same command goes on")
