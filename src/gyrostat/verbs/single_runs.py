"""Verbs on one run: simulate, replay."""

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.engines import engine_named
from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Say, check_device, figure_names, silent
from gyrostat.verbs.scenario_check import (
    say_momentum,
    say_unlikely,
    scenario_of,
)

if TYPE_CHECKING:
    import xarray as xr

    from gyrostat.core.pictured_datasets import Run
    from gyrostat.scenario import Scenario
    from gyrostat.scenario_files.run_file import RunFile
    from gyrostat.simulation.labelled import Labelled


def simulate(
    scenario: "Scenario | str | Path",
    out: "str | Path | None" = None,
    *,
    seed: int = 0,
    device: str = "cpu",
    engine: str = "auto",
    force: bool = False,
    verify: bool = False,
    fly: bool = False,
    figures: str | None = None,
    say: Say = silent,
    command: str = "gyrostat.simulate",
    **changes: Any,
) -> "xr.Dataset":
    """Simulate one run of a scenario with its nominal values.

    Args:
        scenario: Scenario, or path of scenario.toml; or of a file of one run, run.json, that a page
            gives which flies (`fly`): it names its seed itself.
        out: netCDF file RUN.nc for the histories, and RUN.html beside it; None writes no file.
        seed: Seed of the noise.
        device: "cpu", or "gpu" if JAX finds one.
        engine: "native" (compiled C), "jax", or "auto": native if there is a C compiler.
        force: Whether to replace files that gyrostat did not write, and to take wheels that are
            marked as impossible.
        verify: Whether to make the compiled program again and compare it with the stored one.
        fly: Whether RUN.html has the compiled program, to fly the run again with other values.
        figures: "pdf", "svg" or "png": write the figures for papers too; None: none.
        say: Function that receives each message for the user.
        command: Text that the page names as its origin.
        changes: Changes of the scenario, see `gyrostat.scenario.Scenario.replace`: user-defined
            parts as objects, `controller=EarthPointer(kp=0.02)`, or other values.

    Returns:
        Histories over `time`: state, measurements, commands and `error` (pointing error, rad), with
        units. `status` is 0 if the run reached its end; attributes: `scenario`, `ended` (s) and
        every metric. `plot()` draws them, `print` gives the summary.

    Raises:
        InputError: A scenario, device or engine cannot be used, or existing files would be
            replaced.
    """
    options: dict[str, Any] = {
        "seed": seed,
        "device": device,
        "engine": engine,
        "force": force,
        "verify": verify,
    }
    options |= {"fly": fly, "figures": figures}
    history, flown = simulated(scenario, out, **options, say=say, command=command, changes=changes)
    return _run_of(history.dataset(), flown)


def _run_of(dataset: "xr.Dataset", scenario: "Scenario", **values: Any) -> "Run":
    """Dataset of a run with its picture; values: its row in the table of runs."""
    from gyrostat.core.pictured_datasets import SCENARIO, VALUES, Run, mark_whole

    run = Run(dataset.data_vars, dataset.coords, dataset.attrs)
    run.encoding = {**dataset.encoding, SCENARIO: scenario, VALUES: values}
    mark_whole(run)
    return run


def simulated(
    scenario: "Scenario | str | Path",
    out: "str | Path | None",
    *,
    seed: int,
    device: str,
    engine: str,
    force: bool,
    verify: bool,
    say: Say,
    command: str,
    fly: bool = False,
    figures: str | None = None,
    changes: Mapping[str, Any] | None = None,
) -> "tuple[Labelled, Scenario]":
    """Labelled histories of `simulate`, which has the same arguments, and what was simulated."""
    from gyrostat.core.outputs import check_outputs
    from gyrostat.core.validation import check_seed
    from gyrostat.runs.fingerprint import FLAGS, engine_record, use_engine
    from gyrostat.scenario.metrics.results import metrics_of

    check_seed(seed)  # check before compiling
    path = None if out is None else Path(out)
    if path is not None:
        if path.suffix != ".nc":
            raise InputError(f"--out: found {str(path)!r}, expected a name that ends in .nc")
        names = [path.name, path.with_suffix(".html").name, *figure_names(figures, path.stem)]
        check_outputs(path.parent, names, by="simulate", force=force)
    engine = engine_named(engine, say, "--engine")
    check_device(device)
    use_engine(engine_record(device, FLAGS[device]))
    from gyrostat.campaigns.engine import fly as fly_runs
    from gyrostat.campaigns.engine import fly_changed
    from gyrostat.campaigns.execute import chosen_engine
    from gyrostat.runs.blind_windows import blind_windows
    from gyrostat.runs.jitter_lines import unknown_jitter
    from gyrostat.runs.keep_out_times import flown_violations
    from gyrostat.runs.slew_lines import blocked_turns
    from gyrostat.runs.user.trial import say_bad_commands

    run = _run_file(scenario, seed, path, fly=fly, changes=changes or {}, say=say)
    definition = run.scenario if run else scenario_of(scenario, force=force, changes=changes or {})
    flown = run.flown if run else definition
    say_unlikely(flown, say)
    say_momentum(replace(flown, dispersions=()), say)
    say(f"simulating {definition.name}: {definition.duration:g} s")
    if run:
        say(run.line())
    engine = chosen_engine(engine, definition, device, say, verify=verify)
    if run is None:
        results = fly_runs(definition, seed, None, keep=[0], engine=engine)
    else:
        results = fly_changed(definition, run.values, run.seed, run.run or 0, engine)
    say_bad_commands(definition, results.columns, say)
    if path is not None:
        from gyrostat.reports.campaign_run import write_run

        assert results.histories is not None
        content = None
        if fly:
            from gyrostat.reports.fly import fly_content

            content = fly_content(definition, seed, {"nominal": (0, None)}, say)
        write_run(flown, results, path, command=command, say=say, force=force, fly=content)
        if figures:
            from gyrostat.reports.datasets import flown_figure
            from gyrostat.reports.paper_figures import write_figures

            drawn = {path.stem: flown_figure(flown, results)}
            write_figures(drawn, path.parent, figures, by="simulate", say=say, force=force)
    assert results.histories is not None
    names = ("ended", *metrics_of(definition))
    values = {name: results.columns[name][0].item() for name in names}
    for line in blind_windows(flown, values):
        say(f"warning: {line}")
    for line in unknown_jitter(flown, {"status": results.columns["status"], **values}):
        say(line)
    history = results.histories.of_run(0)
    arrays = history.arrays()
    for line in (*blocked_turns(flown, arrays), *flown_violations(flown, arrays)):
        say(line)
    return replace(history, attributes={"scenario": definition.name, **values}), flown


def _run_file(
    scenario: "Scenario | str | Path",
    seed: int,
    out: Path | None,
    *,
    fly: bool,
    changes: Mapping[str, Any],
    say: Say,
) -> "RunFile | None":
    """Content of a file of one run; None of a scenario.

    Raises:
        InputError: It cannot be read, an option belongs to a scenario alone, or `out` is missing
            for `fly`.
    """
    if fly and out is None:
        raise InputError("fly: found it without out, expected RUN.nc, beside which the page is")
    if not isinstance(scenario, str | Path) or Path(scenario).suffix != ".json":
        return None
    from gyrostat.scenario_files.run_file import read_run

    options = {"a seed": seed, "changes": changes, "--fly": fly}
    given = [name for name, value in options.items() if value]
    if given:
        raise InputError(f"{scenario}: found {given[0]}, which the file of a run cannot have")
    return read_run(scenario, say)


def replay(
    folder: "str | Path | xr.Dataset",
    run: int,
    *,
    fly: bool = False,
    say: Say = silent,
    command: str = "gyrostat.replay",
) -> "xr.Dataset":
    """Simulate one run of a campaign again, bit for bit; write its history and its page.

    Args:
        folder: Folder of a finished campaign, or the dataset that `campaign` returned; the files
            are runs/run_NNNNNN.nc and .html in the folder.
        run: Number of the run.
        fly: Whether the page has the compiled program, to fly the run again with other values.
        say: Function that receives each message for the user.
        command: Text that the page names as its origin.

    Returns:
        Histories over `time`, as `simulate` returns them.

    Raises:
        InputError: There is no finished campaign or no such run, or this software or hardware gives
            other numbers than those of the table.
    """
    import xarray as xr

    from gyrostat.campaigns import Store
    from gyrostat.scenario import Scenario

    with (
        _replay(folder, run, fly=fly, say=say, command=command) as path,
        xr.open_dataset(path, engine="h5netcdf") as history,
    ):
        store = Store(path.parents[1])
        scenario = Scenario.from_text(store.known().scenario)
        return _run_of(history.load(), scenario, **store.columns().row(run))


def replayed(
    folder: "str | Path | xr.Dataset", run: int, *, fly: bool, say: Say, command: str
) -> None:
    """Write what `replay` writes, which has the same arguments, without xarray."""
    with _replay(folder, run, fly=fly, say=say, command=command):
        pass


@contextlib.contextmanager
def _replay(
    folder: "str | Path | xr.Dataset", run: int, *, fly: bool, say: Say, command: str
) -> Iterator[Path]:
    """Replay a run; gives the path of its history."""
    from gyrostat.core.remote_folder import local_folder

    address = folder if isinstance(folder, str | Path) else folder.attrs["folder"]
    with local_folder(address, say, "FOLDER") as (path, tell):
        yield _replayed_in(path, run, fly=fly, say=tell, command=command)


def _replayed_in(path: Path, run: int, *, fly: bool, say: Say, command: str) -> Path:
    """Replay a run of the campaign in a folder; returns the path of its history."""
    from gyrostat.campaigns import Store
    from gyrostat.campaigns import replay as simulate_again
    from gyrostat.campaigns.jobs import executor_for
    from gyrostat.reports.campaign import write_replay
    from gyrostat.runs.fingerprint import refuse_other
    from gyrostat.runs.user.packages import other_packages
    from gyrostat.scenario.scenario import Scenario
    from gyrostat.search.error_budget import BUDGET

    store = Store(path, say)
    campaign = store.known()
    if fly and campaign.search is not None:
        raise InputError(f"--fly: found a search in {path}, expected a campaign")
    if campaign.search is not None and BUDGET in campaign.search:
        raise InputError(
            f"{path}: found an error budget, expected a campaign: its runs differ by sources"
        )
    runs = campaign.runs if campaign.search is None else store.read_table().num_rows
    if run not in range(runs):
        raise InputError(f"run: found {run}, expected 0 to {runs - 1}")
    refuse_other(campaign.engine, str(path))
    for package in other_packages(Scenario.from_text(campaign.scenario)):
        say(f"warning: {path}: found {package}, with which the campaign was started")
    with store.locked():
        store.mend(campaign)
        opener, _, fly_job = executor_for(campaign, 1)
        history = simulate_again(store, campaign, [run], opener, fly_job)[0]
    write_replay(campaign, history, run, command=command, say=say, fly=fly)
    return history
