"""Verb `plan-speeds`: wheel speeds without crossings in science windows."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.engines import engine_named
from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Quantity, Say, in_si, silent
from gyrostat.verbs.scenario_check import say_unlikely, scenario_of

if TYPE_CHECKING:
    from gyrostat.runs.sight_in_run import SightInRun
    from gyrostat.scenario import Scenario
    from gyrostat.search.speed_plan import SpeedPlan

MOST_RUNS = 100_000
SIGHT_SPEEDS = 10_000
"""Number of wheel speeds at which the motion of the line of sight is computed."""


def plan_speeds(
    scenario: "Scenario | str | Path",
    out: "str | Path | None" = None,
    *,
    window: Iterable[str] | str | None = None,
    clearance: Quantity = "50 rpm",
    runs: int = 0,
    seed: int = 0,
    sight: "str | Path | None" = None,
    engine: str = "auto",
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.plan_speeds",
    **changes: Any,
) -> "SpeedPlan":
    """Plan wheel speeds so that no wheel crosses zero or a band of speeds in science windows.

    The plan chooses for each window the momentum to which the external actuator unloads before it,
    and the null-space momentum of the wheels. Its cost is the sum of all changes of momentum.

    Args:
        scenario: Scenario with the controller `wheel_array`, or path of scenario.toml.
        out: Folder for plan.toml, plan.json and report.html; None writes no file.
        window: Science windows among the windows of the metrics; None: all.
        clearance: Least distance of wheel speeds from zero, from each `[[controller.band]]` and
            from the limits in the windows, rad/s.
        runs: Number of dispersed runs, from which the probability of no crossing is estimated, by
            the present law and with the plan; 0: none.
        seed: Seed of all draws.
        sight: File of wheels on a structure, as for `jitter`, with a limit: its speeds to avoid
            become bands, and the motion of the line of sight in the windows is given for both laws.
        engine: "native", "jax" or "auto".
        force: Whether to replace files that gyrostat did not write, and to take wheels that are
            marked as impossible.
        say: Function that receives each message for the user.
        command: Text that the files name as their origin.
        changes: Changes of the scenario, as for `simulate`.

    Returns:
        The plan; its `answer` is "found", "infeasible" or "not found", and `scenario` is the
        scenario with the plan.

    Raises:
        InputError: The scenario has no windows or another controller, an option cannot be used, or
            existing files would be replaced.
    """
    from gyrostat.core.outputs import check_outputs
    from gyrostat.reports.speed_plan import FILES, lines_of, write_plan
    from gyrostat.search.speed_plan import search_plan

    if out is not None:
        check_outputs(Path(out), FILES, by="plan-speeds", force=force)
    distance = in_si(clearance, "speed", "--clearance")
    if distance <= 0.0:
        raise InputError(f"--clearance: found {distance:g} rad/s, expected more than 0")
    if not 0 <= runs <= MOST_RUNS:
        raise InputError(f"--runs: found {runs}, expected 0 to {MOST_RUNS}")
    definition = scenario_of(scenario, force=force, changes=changes)
    say_unlikely(definition, say)
    names = [each.name for each in definition.windows]
    given = [window] if isinstance(window, str) else [*(window or names)]
    for name in given:
        if name not in names:
            raise InputError(
                f"--window: found {name!r}, expected "
                f"{'one of ' + ', '.join(names) if names else 'a scenario with windows'}"
            )
    if not given:
        raise InputError(
            f"{definition.name}: found no [[metrics.window]], expected the science windows"
        )
    wanted = engine_named(engine, say, "--engine")

    def engine_for(each: "Scenario") -> str:
        from gyrostat.campaigns.execute import chosen_engine

        return chosen_engine(wanted, each, "cpu", say)

    motion = None if sight is None else _sight(definition, Path(sight))
    result = search_plan(
        definition,
        given,
        distance,
        runs=runs,
        seed=seed,
        engine_for=engine_for,
        sight=motion,
    )
    for line in lines_of(result):
        say(line)
    if out is not None:
        write_plan(result, Path(out), command=command, say=say, force=force)
    return result


def _sight(scenario: "Scenario", path: Path) -> "SightInRun":
    """Motion of the line of sight by the wheels of a scenario; raises `InputError`."""
    from gyrostat.microvibration.disturbance_file import read_structure
    from gyrostat.runs.sight_in_run import SightInRun

    structure = read_structure(path)
    if structure.limit is None:
        raise InputError(f"{path}: found no key limit, expected one, from which the bands follow")
    return SightInRun.of(scenario, structure, SIGHT_SPEEDS)
