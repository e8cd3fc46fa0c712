"""Verbs on scenarios: check, simulate, campaign, replay, report."""

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gyrostat import verbs
from gyrostat.cli.arguments import call, command_line, print_json, say
from gyrostat.cli.options import Figures, ForceModel, Json, Out, Scheduler, Verify, Workers
from gyrostat.cli.progress import Progress
from gyrostat.core.errors import InputError
from gyrostat.core.instructions import limit_process, recorded
from gyrostat.verbs.single_runs import replayed, simulated

if TYPE_CHECKING:
    import xarray as xr

    from gyrostat.simulation.labelled import Labelled

Device = Annotated[str, typer.Option(help="cpu, or gpu if JAX finds one.")]
Engine = Annotated[
    str, typer.Option(help="native (compiled C), jax, or auto: native if there is a C compiler.")
]
Fly = Annotated[
    bool,
    typer.Option(
        "--fly",
        help="Put the compiled program into the page, which flies the run again as values change. "
        "It needs clang with lld and wasi-libc, or zig (ziglang).",
    ),
]
CampaignEngine = Annotated[
    str,
    typer.Option(
        help="native (compiled C), jax, opencl or cuda (an accelerator with double precision), or "
        "auto: native if there is a C compiler."
    ),
]


def simulate(
    scenario: Annotated[
        Path,
        typer.Argument(
            help="Scenario file, file of a run, run.json, or safe_mode, a scenario of this package."
        ),
    ],
    out: Annotated[Path, typer.Option(help="netCDF file RUN.nc; RUN.html is written next to it.")],
    seed: Annotated[int, typer.Option(min=0, help="Seed of the noise.")] = 0,
    device: Device = "cpu",
    engine: Engine = "auto",
    force: ForceModel = False,
    verify: Verify = False,
    fly: Fly = False,
    figures: Figures = None,
    json_output: Json = False,
) -> None:
    """Simulate a scenario once, with its nominal values: RUN.nc and RUN.html."""
    run, _ = call(simulated, locals(), command=command_line())
    if json_output:
        print(_run_json(run))
    if int(run.variables["status"].values) != 0:
        raise typer.Exit(1)


def _run_json(run: "Labelled") -> str:
    """JSON text with status, end time and metrics of a run."""
    from gyrostat.simulation import Status

    metrics = {
        name: value if math.isfinite(value) else None
        for name, value in run.attributes.items()
        if name not in ("scenario", "ended")
    }
    content = {
        "scenario": run.attributes["scenario"],
        "status": Status(int(run.variables["status"].values)).name.lower(),
        "ended": run.attributes["ended"],
        "metrics": metrics,
    }
    return json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)


def check(
    scenario: Annotated[
        Path, typer.Argument(help="Scenario file, or safe_mode, a scenario of this package.")
    ],
    force: Annotated[
        bool, typer.Option("--force", help="Accept a wheel model that is marked as impossible.")
    ] = False,
    json_output: Json = False,
) -> None:
    """Check a scenario and the parts of yours that it names, without a simulation."""
    result = call(verbs.check, locals())
    if json_output:
        parts = {name: part.content() for name, part in result.parts.items()}
        content = {"components": result, "parts": parts, "unlikely": result.unlikely}
        print(json.dumps(content, indent=1, ensure_ascii=False))


def campaign(
    scenario: Annotated[Path, typer.Argument(help="scenario.toml with [[dispersion]] tables.")],
    runs: Annotated[int, typer.Option(min=1, help="Number of runs.")],
    out: Annotated[
        str | None,
        typer.Option(
            help="Folder for the results, or s3://BUCKET/PREFIX [default: named after scenario, "
            "runs and seed]."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all random draws.")] = 0,
    workers: Workers = None,
    scheduler: Scheduler = None,
    device: Device = "cpu",
    engine: CampaignEngine = "auto",
    instructions: Annotated[
        str | None,
        typer.Option(
            help="Instruction set that all processors of a cluster have: x86-64-v3 (AVX2) or "
            "x86-64-v4 (AVX-512) [default: that of this processor]."
        ),
    ] = None,
    block: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=2**32,
            help="Runs in a block [default: 64, on accelerators 16384].",
        ),
    ] = None,
    keep: Annotated[str, typer.Option(help="Indices of runs whose histories are kept: 0,5.")] = "",
    worst: Annotated[int, typer.Option(min=0, help="Number of worst runs to keep too.")] = 3,
    worst_by: Annotated[
        str | None, typer.Option(help="Metric that ranks them [default: last error percentile].")
    ] = None,
    rare: Annotated[
        str | None,
        typer.Option(
            help='Estimate the probability of a failure, "error_max > 0.5 deg", in --runs or less: '
            "at least 4100, which suit 1e-2; 20000 suit 1e-6."
        ),
    ] = None,
    worst_case: Annotated[
        str | None,
        typer.Option(
            help="Search for the worst case of this metric in --runs or less: at least 640, and 2 "
            "more for each dispersed value."
        ),
    ] = None,
    within: Annotated[
        str | None,
        typer.Option(help="Bounds of the worst case: 3sigma (default), 2.5sigma, ..., or box."),
    ] = None,
    force: Annotated[
        bool,
        typer.Option(
            "--force",
            help="Start despite files with the names of results, which are renamed NAME.changed; "
            "accept wheels marked as impossible.",
        ),
    ] = False,
    verify: Verify = False,
    plan: Annotated[
        bool,
        typer.Option(
            "--plan",
            help="Only estimate time, memory and disk of so many runs, from 64 of them.",
        ),
    ] = False,
    json_output: Json = False,
) -> None:
    """Simulate a scenario many times with dispersed values; run again to resume after a stop."""
    options = locals()
    limit_process(instructions)
    with Progress() as on_progress:
        dataset = call(verbs.campaign, options, on_progress=on_progress, command=command_line())
    if json_output:
        _print_campaign(dataset, plan=plan)
    if dataset.attrs.get("doubts"):
        raise typer.Exit(1)


def _print_campaign(dataset: "xr.Dataset", *, plan: bool) -> None:
    """Print the plan of a campaign, or its report.json."""
    if not plan:
        _print_report(dataset.attrs["folder"])
        return
    from gyrostat.verbs.campaign_plan import plan_content

    print(json.dumps(plan_content(dataset), indent=1, ensure_ascii=False, allow_nan=False))


def _print_report(folder: str) -> None:
    """Print the report.json of a folder, or of an address."""
    from gyrostat.core.remote_folder import text_of

    print(text_of(folder, "report.json"), end="")


def tune(
    scenario: Annotated[Path, typer.Argument(help="scenario.toml with [[dispersion]] tables.")],
    free: Annotated[
        str, typer.Option(help="Free keys: controller.rate_gain,compensator.band=10rpm:40rpm.")
    ],
    minimise: Annotated[str, typer.Option(help="Metric, minimised for 95 % of the runs.")],
    out: Out,
    subject_to: Annotated[
        list[str] | None, typer.Option(help='Limit: "torque_rms < 30 uN*m"; may be repeated.')
    ] = None,
    runs: Annotated[
        int, typer.Option(min=1, help="Largest number of runs, at least 5760.")
    ] = 50_000,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all random draws.")] = 0,
    workers: Workers = None,
    scheduler: Scheduler = None,
    force: ForceModel = False,
    verify: Verify = False,
    json_output: Json = False,
) -> None:
    """Search for the best values of free keys, and verify them in fresh runs."""
    options = {**locals(), "subject_to": subject_to or ()}
    with Progress() as on_progress:
        content = call(verbs.tune, options, on_progress=on_progress, command=command_line())
    if json_output:
        print_json(out / "report.json")
    if content["doubts"] or not content["within_limits"]:
        raise typer.Exit(1)


def replay(
    folder: Annotated[str, typer.Argument(help="Folder of a finished campaign, or its address.")],
    run: Annotated[int, typer.Argument(min=0, help="Number of the run.")],
    fly: Fly = False,
) -> None:
    """Repeat one run of a campaign, bit for bit, and write its history and its report."""
    limit_process(_recorded_instructions(folder))
    call(replayed, locals(), command=command_line())


def _recorded_instructions(folder: str) -> str | None:
    """Common instruction set of a campaign, before anything is imported that depends on it."""
    from gyrostat.core.remote_folder import text_of

    try:
        return recorded(json.loads(text_of(folder, "campaign.json"))["engine"])
    except (InputError, OSError, ValueError, LookupError, TypeError, AttributeError):
        return None  # what is wrong is told later


def report(
    folder: Annotated[str, typer.Argument(help="Folder of a finished campaign, or its address.")],
    check: Annotated[
        bool,
        typer.Option("--check", help="Exit with code 1 unless every pointing requirement is met."),
    ] = False,
    fly: Annotated[
        bool,
        typer.Option(
            "--fly",
            help="Write fly.html too: a page that flies runs again as values change. It needs "
            "clang with lld and wasi-libc, or zig (ziglang).",
        ),
    ] = False,
    figures: Figures = None,
    json_output: Json = False,
) -> None:
    """Write the report of a campaign: report.html and report.json."""
    content = call(verbs.report, locals(), command=command_line())
    if json_output:
        _print_report(folder)
    unmet = [r for r in content.get("requirements", ()) if r["verdict"] != "pass"]
    if check and unmet:
        say("check: " + ", ".join(f"{r['name']}: {r['verdict']}" for r in unmet))
        raise typer.Exit(1)
