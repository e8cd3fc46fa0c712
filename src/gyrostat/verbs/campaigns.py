"""The verb `campaign`."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.engines import ACCELERATED, ENGINES, engine_named
from gyrostat.core.errors import InputError
from gyrostat.core.instructions import check_instructions
from gyrostat.verbs import searches
from gyrostat.verbs.arguments import (
    Say,
    check_device,
    folder_name,
    opener_of,
    refuse_given,
    silent,
    to_stderr,
    whole_numbers,
)
from gyrostat.verbs.progress import shown
from gyrostat.verbs.scenario_check import (
    say_momentum,
    say_unlikely,
    scenario_of,
)

if TYPE_CHECKING:
    import xarray as xr

    from gyrostat.scenario import Scenario


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
    block: int | None = None,
    keep: str | Iterable[int] = (),
    worst: int = 3,
    worst_by: str | None = None,
    rare: str | None = None,
    worst_case: str | None = None,
    within: str | None = None,
    force: bool = False,
    verify: bool = False,
    plan: bool = False,
    on_progress: Callable[[int, int], None] | None = None,
    say: Say = silent,
    command: str = "gyrostat.campaign",
    **changes: Any,
) -> "xr.Dataset":
    """Simulate a scenario many times, each run with its own draws; resume an interrupted campaign.

    Args:
        scenario: Scenario with dispersions, or path of scenario.toml.
        runs: Number of runs.
        out: Folder of the campaign, or an address of fsspec, "s3://bucket/prefix". None: a folder
            in the current one, named after scenario, runs and seed, as
            "cubesat-1000-runs-seed-1"; reported to `say`, or on stderr without it.
        seed: Seed of all draws.
        workers: Number of worker processes; None: one for each core, or threads of this process
            for a small campaign of the native engine.
        scheduler: Address of a Dask scheduler, which replaces the local processes.
        device: "cpu", or "gpu" if JAX finds one.
        engine: "native" (compiled C), "jax", "opencl" or "cuda" (an accelerator with double
            precision), or "auto": native if there is a C compiler.
        instructions: Name of an instruction set that all processors of a cluster have, "x86-64-v3"
            (AVX2) or "x86-64-v4" (AVX-512), for results with the same bits on each; None: that of
            this process. It must be in the environment before Python imports NumPy; the error names
            the variables.
        block: Runs in a block; results do not depend on it. None: 64, or 16384 for an accelerator.
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
        plan: Whether only to estimate what the campaign takes, from 64 of its runs; `out` is not
            written.
        on_progress: Function called with the number of runs done and the total number; None: a bar
            in a terminal or notebook.
        say: Function that receives each message for the user.
        command: Text that the report names as its origin.
        changes: Changes of the scenario, as for `simulate`.

    Returns:
        The dataset that `campaign_runs` reads: every drawn parameter and metric, one value per
        run. The folder also has report.html, report.json and the histories of the worst runs. With
        `rare` or `worst_case`, the runs are not independent; the attributes `probability`, `low`
        and `high`, or `below` without a probability, or `run`, `worst` and `noise_share`, are the
        result, and `doubts` has the reasons not to trust it. With `plan`, the dataset has one
        number for each quantity: `seconds`, `core_hours`, `memory`, `command_memory`,
        `worker_memory`, `disk` (bytes) and `workers`.

    Raises:
        InputError: The scenario has no dispersions, the folder has another campaign, or options
            cannot be used.
    """
    from gyrostat.core.files import check_writable
    from gyrostat.core.remote_folder import is_remote, local_folder

    if out is not None and not is_remote(out):
        check_writable(Path(out))
    if worst < 0:
        raise InputError(f"--worst: found {worst}, expected 0 or more")
    check_device(device)
    check_instructions(instructions)
    engine = engine_named(engine, say, "--engine", (*ENGINES, *ACCELERATED))
    definition = scenario_of(scenario, force=force, changes=changes)
    if not definition.dispersions:
        source = scenario if isinstance(scenario, str | Path) else definition.name
        raise InputError(f"{source}: key dispersion: found none, expected at least one dispersion")
    say_unlikely(definition, say)
    say_momentum(definition, say, seed, runs)
    if plan:
        from gyrostat.verbs.campaign_plan import campaign_plan

        searching = {"--rare": rare, "--worst-case": worst_case, "--within": within}
        refuse_given({"--scheduler": scheduler, **searching}, "--plan", "a campaign")
        if device != "cpu" or engine in ACCELERATED:
            found = f"--device {device}" if device != "cpu" else f"--engine {engine}"
            raise InputError(f"--plan: found {found}, expected the engine native or jax on a cpu")
        given = {"engine": engine, "workers": workers, "block": block}
        return campaign_plan(definition, runs, seed, **given, say=say)
    question = None
    if rare is not None or worst_case is not None:
        campaign_options = {"--keep": keep, "--worst-by": worst_by}
        is_rare = rare is not None
        campaign_options |= {"--worst-case": worst_case if is_rare else None}
        campaign_options |= {"--block": block}
        campaign_options |= {"--within": within if is_rare else None}
        option = "--rare" if is_rare else "--worst-case"
        refuse_given(campaign_options, option, "a campaign")
        question = searches.question_of(definition, runs, seed, rare, worst_case or "", within, say)
        searches.check_native(option, device, engine)
    folder = folder_name(definition.name, runs, seed) if out is None else out
    if out is None:
        check_writable(Path(folder))
        # the chosen folder is always reported
        (to_stderr if say is silent else say)(f"the files of the campaign are written to {folder}")
    if question is not None:
        from gyrostat.search.execute import Options

        opener = opener_of(scheduler, say)
        options = Options(runs, seed, workers, worst, force, verify, opener)
        with local_folder(folder, say) as (copy, tell):
            about = options, tell, shown(on_progress), command
            found = searches.search(question, definition, copy, *about, address=str(folder))
            return _read(found, folder)
    from gyrostat.campaigns import campaign_runs, run_campaign
    from gyrostat.campaigns.pointing.text import requirement_lines
    from gyrostat.reports.campaign import write_campaign
    from gyrostat.runs.jitter_lines import unknown_jitter
    from gyrostat.runs.slew_lines import blocked_runs
    from gyrostat.runs.user.trial import say_bad_commands

    refuse_given({"--within": within}, "campaign", "--worst-case")
    for line in requirement_lines(definition, runs):
        say(line)
    with local_folder(folder, say) as (copy, tell):
        run_campaign(
            definition,
            copy,
            runs=runs,
            seed=seed,
            device=device,
            engine=engine,
            opener=opener_of(scheduler, say),
            workers=workers,
            block=block,
            keep=whole_numbers(keep, "--keep"),
            worst=worst,
            worst_by=worst_by,
            force=force,
            verify=verify,
            on_progress=shown(on_progress),
            say=tell,
        )
        write_campaign(copy, command=command, say=tell, address=str(folder))
        dataset = _read(campaign_runs(copy), folder)
    columns = {name: dataset[name] for name in ("run", "status", "ended")}
    say_bad_commands(definition, columns, say)
    if "keep_out_time" in dataset:
        for line in blocked_runs(definition, dataset["keep_out_time"].to_numpy()):
            say(line)
    for line in unknown_jitter(definition, dataset):
        say(line)
    return dataset


def _read(dataset: "xr.Dataset", folder: "str | Path") -> "xr.Dataset":
    """Dataset of a folder; that of one on an object store is read as a whole."""
    from gyrostat.core.remote_folder import is_remote

    if is_remote(folder):
        dataset = dataset.load()
    return dataset.assign_attrs(folder=str(folder))
