"""Verbs on scenarios: simulate, campaign, replay."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.engines import engine_named
from gyrostat.core.errors import InputError
from gyrostat.core.instructions import check_instructions
from gyrostat.verbs.arguments import (
    Say,
    check_device,
    folder_name,
    refuse_given,
    silent,
    to_stderr,
    whole_numbers,
)
from gyrostat.verbs.scenario_check import scenario_of

if TYPE_CHECKING:
    import xarray as xr

    from gyrostat.campaigns import Scenario
    from gyrostat.simulation.labelled import Labelled

BLOCK = 64
"""Default number of runs in a block of a campaign."""


def simulate(
    scenario: "Scenario | str | Path",
    out: "str | Path | None" = None,
    *,
    seed: int = 0,
    device: str = "cpu",
    engine: str = "auto",
    force: bool = False,
    verify: bool = False,
    say: Say = silent,
    command: str = "gyrostat.simulate",
    **changes: Any,
) -> "xr.Dataset":
    """Simulate one run of a scenario with its nominal values.

    Args:
        scenario: Scenario, or path of scenario.toml.
        out: netCDF file RUN.nc for the histories, and RUN.html beside it; None writes no file.
        seed: Seed of the noise.
        device: "cpu", or "gpu" if JAX finds one.
        engine: "native" (compiled C), "jax", or "auto": native if there is a C compiler.
        force: Whether to replace files that gyrostat did not write, and to take wheels that are
            marked as impossible.
        verify: Whether to make the compiled program again and compare it with the stored one.
        say: Function that receives each message for the user.
        command: Text that the page names as its origin.
        changes: Changes of the scenario, see `gyrostat.campaigns.Scenario.replace`: own parts as
            objects, `controller=EarthPointer(kp=0.02)`, or other values.

    Returns:
        Histories over `time`: state, measurements, commands and `error` (pointing error, rad), with
        units. `status` is 0 if the run reached its end; attributes: `scenario`, `ended` (s) and
        every metric.

    Raises:
        InputError: A scenario, device or engine cannot be used, or existing files would be
            replaced.
    """
    options = {"seed": seed, "device": device, "engine": engine, "force": force, "verify": verify}
    made = simulated(scenario, out, **options, say=say, command=command, changes=changes)
    return made.dataset()


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
    changes: Mapping[str, Any] | None = None,
) -> "Labelled":
    """Labelled histories of `simulate`, which has the same arguments, without xarray."""
    from gyrostat.campaigns.fingerprint import FLAGS, engine_record, use_engine
    from gyrostat.campaigns.metrics.results import metrics_of
    from gyrostat.core.outputs import check_outputs
    from gyrostat.core.validation import check_seed

    check_seed(seed)  # check before compiling
    path = None if out is None else Path(out)
    if path is not None:
        if path.suffix != ".nc":
            raise InputError(f"--out: found {str(path)!r}, expected a name that ends in .nc")
        names = (path.name, path.with_suffix(".html").name)
        check_outputs(path.parent, names, by="simulate", force=force)
    engine = engine_named(engine, say, "--engine")
    check_device(device)
    use_engine(engine_record(device, FLAGS[device]))
    from gyrostat.campaigns.engine import fly
    from gyrostat.campaigns.execute import chosen_engine
    from gyrostat.campaigns.own.trial import say_bad_commands

    found = scenario_of(scenario, force=force, changes=changes or {})
    say(f"simulating {found.name}: {found.duration:g} s")
    engine = chosen_engine(engine, found, device, say, verify=verify)
    flown = fly(found, seed, None, keep=[0], engine=engine)
    say_bad_commands(found, flown.columns, say)
    if path is not None:
        from gyrostat.reports.campaign_run import write_run

        write_run(found, flown, path, command=command, say=say, force=force)
    assert flown.histories is not None
    names = ("ended", *metrics_of(found))
    values = {name: flown.columns[name][0].item() for name in names}
    return replace(flown.histories.of_run(0), attributes={"scenario": found.name, **values})


def campaign(
    scenario: "Scenario | str | Path",
    runs: int,
    out: "str | Path | None" = None,
    *,
    seed: int = 0,
    workers: int | None = None,
    scheduler: str | None = None,
    device: str = "cpu",
    engine: str = "auto",
    instructions: str | None = None,
    block: int = BLOCK,
    keep: str | Iterable[int] = (),
    worst: int = 3,
    worst_by: str | None = None,
    rare: str | None = None,
    worst_case: str | None = None,
    within: str | None = None,
    force: bool = False,
    verify: bool = False,
    on_progress: Callable[[int, int], None] | None = None,
    say: Say = silent,
    command: str = "gyrostat.campaign",
    **changes: Any,
) -> "xr.Dataset":
    """Simulate a scenario many times, each run with its own draws; resume an interrupted campaign.

    Args:
        scenario: Scenario with dispersions, or path of scenario.toml.
        runs: Number of runs.
        out: Folder of the campaign. None: a folder in the current one, named after scenario, runs
            and seed, as "cubesat-1000-runs-seed-1"; reported to `say`, or on stderr without it.
        seed: Seed of all draws.
        workers: Number of worker processes; None: one for each core, or threads of this process
            for a small campaign of the native engine.
        scheduler: Address of a Dask scheduler, which replaces the local processes.
        device: "cpu", or "gpu" if JAX finds one.
        engine: "native" (compiled C), "jax", or "auto": native if there is a C compiler.
        instructions: Name of an instruction set that all processors of a cluster have, "x86-64-v3"
            (AVX2) or "x86-64-v4" (AVX-512), for results with the same bits on each; None: that of
            this process. It must be in the environment before Python imports NumPy; the error names
            the variables.
        block: Runs in a block; results do not depend on it.
        keep: Numbers of runs whose histories are kept.
        worst: Number of worst runs whose histories are kept too.
        worst_by: Metric that ranks them; None: the last percentile of the error.
        rare: Condition of a failure, "error_max > 0.5 deg": its probability is estimated by a
            search for such runs. `runs` is then the largest number of runs.
        worst_case: Metric whose worst case is searched, with at most `runs` runs.
        within: Bounds of the dispersions of the worst case: "3sigma" (default), with any number, or
            "box": the ends of uniform distributions and 3 sigma of the others.
        force: Whether to start although the folder has files that gyrostat did not write, which
            are renamed NAME.changed, and to accept wheels that are marked as impossible.
        verify: Whether to make the compiled program again and compare it with the stored one.
        on_progress: Function called with the number of runs done and the total number.
        say: Function that receives each message for the user.
        command: Text that the report names as its origin.
        changes: Changes of the scenario, as for `simulate`.

    Returns:
        The dataset that `campaign_runs` reads: every drawn parameter and metric, one value per
        run. The folder also has report.html, report.json and the histories of the worst runs. With
        `rare` or `worst_case`, the runs are not independent; the attributes `probability`, `low`,
        `high` and `doubts`, or `run`, `worst` and `noise_share`, are the result.

    Raises:
        InputError: The scenario has no dispersions, the folder has another campaign, or options
            cannot be used.
    """
    from gyrostat.campaigns import campaign_runs, cluster, run_campaign
    from gyrostat.campaigns.own.trial import say_bad_commands
    from gyrostat.campaigns.pointing.text import requirement_lines
    from gyrostat.core.files import check_writable
    from gyrostat.reports.campaign import write_campaign

    if out is not None:
        check_writable(Path(out))
    if worst < 0:
        raise InputError(f"--worst: found {worst}, expected 0 or more")
    check_device(device)
    check_instructions(instructions)
    engine = engine_named(engine, say, "--engine")
    found = scenario_of(scenario, force=force, changes=changes)
    if not found.dispersions:
        place = scenario if isinstance(scenario, str | Path) else found.name
        raise InputError(f"{place}: key dispersion: found none, expected at least one dispersion")
    folder = Path(folder_name(found.name, runs, seed) if out is None else out)
    if out is None:
        check_writable(folder)
        # the chosen folder is always reported
        (to_stderr if say is silent else say)(f"the files of the campaign are written to {folder}")
    if rare is not None or worst_case is not None:
        from gyrostat.verbs.searches import Search

        other = {"--scheduler": scheduler, "--keep": keep, "--worst-by": worst_by}
        is_rare = rare is not None
        other |= {"--worst-case": worst_case if is_rare else None}
        other |= {"--block": None if block == BLOCK else block}
        other |= {"--within": within if is_rare else None}
        refuse_given(other, "--rare" if is_rare else "--worst-case", "a campaign")
        asked = Search(
            *(found, folder, runs, seed, workers, worst, force, verify),
            *(device, engine, on_progress, say, command),
        )
        if rare is not None:
            return asked.failures(rare)
        return asked.worst_case(worst_case or "", within or "3sigma")
    refuse_given({"--within": within}, "campaign", "--worst-case")
    for line in requirement_lines(found, runs):
        say(line)
    run_campaign(
        found,
        folder,
        runs=runs,
        seed=seed,
        device=device,
        engine=engine,
        opener=None if scheduler is None else cluster(scheduler),
        workers=workers,
        block=block,
        keep=whole_numbers(keep, "--keep"),
        worst=worst,
        worst_by=worst_by,
        force=force,
        verify=verify,
        on_progress=on_progress,
        say=say,
    )
    write_campaign(folder, command=command, say=say)
    made = campaign_runs(folder)
    say_bad_commands(found, {name: made[name].values for name in ("run", "status", "ended")}, say)
    return made


def replay(
    folder: "str | Path | xr.Dataset",
    run: int,
    *,
    say: Say = silent,
    command: str = "gyrostat.replay",
) -> "xr.Dataset":
    """Simulate one run of a campaign again, bit for bit; write its history and its page.

    Args:
        folder: Folder of a finished campaign, or the dataset that `campaign` returned; the files
            are runs/run_NNNNNN.nc and .html in the folder.
        run: Number of the run.
        say: Function that receives each message for the user.
        command: Text that the page names as its origin.

    Returns:
        Histories over `time`, as `simulate` returns them.

    Raises:
        InputError: There is no finished campaign or no such run, or this software or hardware gives
            other numbers than those of the table.
    """
    import xarray as xr

    written = replayed(folder, run, say=say, command=command)
    with xr.open_dataset(written, engine="h5netcdf") as history:
        return history.load()


def replayed(folder: "str | Path | xr.Dataset", run: int, *, say: Say, command: str) -> Path:
    """Path of the history that `replay` writes, which has the same arguments, without xarray."""
    from gyrostat.campaigns import Store
    from gyrostat.campaigns import replay as simulate_again
    from gyrostat.campaigns.fingerprint import refuse_other
    from gyrostat.campaigns.jobs import executor_for
    from gyrostat.reports.campaign import write_replay

    path = Path(folder if isinstance(folder, str | Path) else folder.attrs["folder"])
    store = Store(path, say)
    known = store.known()
    runs = known.runs if known.search is None else store.read_table().num_rows
    if run not in range(runs):
        raise InputError(f"run: found {run}, expected 0 to {runs - 1}")
    refuse_other(known.engine, str(path))
    with store.locked():
        store.mend(known)
        opener, _, fly_job = executor_for(known, 1)
        written = simulate_again(store, known, [run], opener, fly_job)[0]
    write_replay(known, written, run, command=command, say=say)
    return written
