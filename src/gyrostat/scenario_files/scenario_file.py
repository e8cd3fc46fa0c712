"""Read scenario files, scenario.toml.

docs/scenario.md lists every key. They are defined in `gyrostat.scenario.schema`, and by the classes
in the folders of `gyrostat.scenario.kinds`.
"""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from gyrostat.control.measurement_guard import ON_BAD
from gyrostat.core.errors import InputError, placed, printable
from gyrostat.core.toml_file import LONGEST_NAME
from gyrostat.core.user_errors import UserPartError
from gyrostat.core.user_modules import is_user_kind, joined_sources
from gyrostat.core.validation import MOST_PERIODS, require_period
from gyrostat.runs.plans import designs_of, plans_of
from gyrostat.runs.user.packages import with_packages
from gyrostat.runs.user.trial import try_shapes
from gyrostat.scenario.impossible import check_possible
from gyrostat.scenario.kinds.distributions import distributions_of
from gyrostat.scenario.kinds.registry import KINDS, component, fitting_estimator, measured
from gyrostat.scenario.kinds.wheel_keys import WHEEL, WHEEL_PARTS
from gyrostat.scenario.mode_graph import check_modes
from gyrostat.scenario.requirement import INDICES, KNOWLEDGE
from gyrostat.scenario.scenario import Part, Scenario
from gyrostat.scenario.schema import RUN, START, guard_keys
from gyrostat.scenario.spacecraft_values import spacecraft_values, surface_rows
from gyrostat.scenario.timeline import check_windows
from gyrostat.scenario.user.kinds import USER_KINDS
from gyrostat.scenario_files import shipped
from gyrostat.scenario_files.read_dispersions import read_dispersions
from gyrostat.scenario_files.read_events import read_events
from gyrostat.scenario_files.read_metrics import read_metrics
from gyrostat.scenario_files.read_orbit import read_orbit
from gyrostat.scenario_files.read_parts import completed, part_values, read_parts, user_tables
from gyrostat.scenario_files.read_reference import check_reference, position_error, read_tables
from gyrostat.scenario_files.read_requirements import check_requirements, read_requirements
from gyrostat.scenario_files.read_structures import read_structures
from gyrostat.scenario_files.read_user_parts import USER_KEYS, user_kind, user_sources
from gyrostat.scenario_files.tables import Table, opened
from gyrostat.spacecraft import SpacecraftFile, read_spacecraft
from gyrostat.wheel.friction_laws import law_texts

SECTIONS = (
    *("name", "run", "spacecraft", "start", *KINDS),
    *("guard", "station", "keep_out", "star_tracker", "sensor", "actuator", "event"),
    *("dispersion", "metric", "metrics", "requirement", *WHEEL_PARTS),
)
DEFAULTS = {
    "compensator": "none",
    "unloading": "none",
    "sensors": "white_noise",
    "orbit": "none",
    "environment": "constant",
    "reference": "fixed",
}
"""Section -> default of its `kind`; that of the controller is required."""
BESIDE = {
    "controller": ("target", "band", "plan", "law"),
    "environment": ("torque",),
    "reference": ("mode", "transition", "slew", "position_error"),
    "imbalance": ("harmonic",),
}
"""Section -> keys that are no numbers."""


def read_scenario(path: str | os.PathLike[str], *, force: bool = False) -> Scenario:
    """Read a scenario file and the files that it names.

    Args:
        path: Path of the file; or the name of a scenario of this package, see `shipped`.
        force: Accept wheel models and fits that are marked as impossible.

    Raises:
        InputError: A file cannot be read or is not TOML; or a key is unknown, missing or has a
            value that is not allowed.
    """
    path = shipped.path_of(Path(path))
    try:
        scenario = _read(path, force=force)
    except UserPartError as error:
        raise InputError(f"{path}: {error}") from None
    with placed(str(path)):
        return validated(scenario)


def _read(path: Path, *, force: bool) -> Scenario:
    """Scenario from a file; its parts have not been tried."""
    top = opened(path, shipped.expected(path), SECTIONS)
    craft = read_spacecraft(path.parent / _spacecraft(top), force=force)
    values: dict[str, float] = dict(spacecraft_values(craft))
    run = top.table("run", (*RUN, "step", "command_delay"))
    values |= run.numbers(RUN)
    count, substeps = _steps(run, values)
    start = top.table("start", (*START, "attitude", "wheel_speed"))
    values |= start.numbers(START) | _wheel_values(top, start, craft)
    kinds, parts = _kinds(top), read_parts(top)
    tables = [top.table(section, None) for section, kind in kinds.items() if is_user_kind(kind)]
    sources = user_sources(top, [*tables, *user_tables(top)])
    law = type(craft.spacecraft.wheels.friction)
    friction, texts = law_texts(law) or (law.name, ())
    sources = joined_sources(top.name("name", printable(path.stem)), sources, texts)
    delay = run.whole("command_delay", 0, 1000)
    # the defaults of a controller depend on the sensors
    for section, kind in sorted(kinds.items(), key=lambda each: each[0] == "controller"):
        component_kind = component(section, kind, sources)
        keys = component_kind.keys()
        user_keys = USER_KEYS if is_user_kind(kind) else ()
        extra = ("kind", *user_keys, *component_kind.texts, *BESIDE.get(section, ()))
        table = completed(top.table(section, (*keys, *extra)), component_kind, values)
        if section == "reference":
            values |= position_error(table, component_kind, kinds["orbit"])
        values |= table.with_missing(component_kind.defaults(values, delay)).numbers(keys)
    values |= part_values(parts, values, sources, delay)
    fields = measured(kinds["sensors"], [part for part, _ in parts], sources)
    guard = None
    if "guard" in top.row:
        keys = guard_keys(fields)
        table = top.table("guard", (*keys, "on_bad"))
        values |= table.numbers(keys)
        guard = table.one_of("on_bad", ON_BAD, "hold")
    controller = component("controller", kinds["controller"], sources)
    events = read_events(top, craft, values, controller, fields, sources)
    reference = component("reference", kinds["reference"], sources)
    check_reference(reference, parts, top, values)
    metrics = read_metrics(top, values, events, [part for part, _ in parts])
    rows = top.tables("requirement")
    scenario = Scenario(
        name=top.name("name", printable(path.stem)[:LONGEST_NAME]),
        wheels=craft.wheel_names,
        axes=tuple(map(tuple, np.asarray(craft.spacecraft.wheels.axes).T.tolist())),
        friction=friction,
        surfaces=surface_rows(craft),
        **kinds,
        attitude=start.unit("attitude", 4, (1.0, 0.0, 0.0, 0.0)),
        target=top.table("controller", None).unit("target", 4, (1.0, 0.0, 0.0, 0.0)),
        **metrics,
        requirements=read_requirements(rows, metrics["boresight"], values, metrics["windows"]),
        count=count,
        substeps=substeps,
        command_delay=delay,
        events=tuple(sorted(events, key=lambda e: values[f"event.{e.name}.time"])),
        dispersions=(),
        # fixed order, so that a scenario and its copy from text compile to the same program
        values=dict(sorted(values.items())),
        guard=guard,
        parts=(
            *(part for part, _ in parts),
            *(Part(each.kind, each.name, each.kind) for each in craft.appendages),
        ),
        sources=sources,
        texts=(
            *read_tables(reference, parts, top, values["run.duration"]),
            *read_orbit(kinds["orbit"], top.table("orbit", None)),
            *read_structures(parts),
        ),
    )
    scenario = replace(scenario, dispersions=read_dispersions(top, scenario, force=force))
    return with_packages(scenario)


def validated(scenario: Scenario) -> Scenario:
    """Return the scenario itself after its controllers were designed and its parts were tried.

    Raises:
        InputError: A part refuses its parameters or cannot be used.
    """
    check_windows(scenario)
    check_possible(scenario)
    distributions_of(scenario)
    check_modes(scenario)
    check_requirements(scenario)
    if scenario.sources:
        # tracing finds most mistakes in Python, before the first sample is compiled
        try_shapes(scenario, designs_of(scenario))
    plans = plans_of(scenario)
    propellants = [window.propellant for window in scenario.windows]
    knowledge = [INDICES[each.index][0] == KNOWLEDGE for each in scenario.requirements]
    if not scenario.sources and any((*propellants, *knowledge)):
        try_shapes(scenario, plans)
    return scenario


def _kinds(top: Table) -> dict[str, str]:
    """Section -> kind of its component."""
    choices: dict[str, str] = {}
    for section, kinds in KINDS.items():
        table = top.table(section, None)
        default = DEFAULTS.get(section)
        if section == "estimator":
            default = KINDS["sensors"][choices["sensors"]].estimator
        if section in USER_KINDS and "python" in table.row:
            choices[section] = user_kind(table)
        else:
            choices[section] = table.one_of("kind", kinds, default)
    estimator = fitting_estimator(choices)
    if choices["estimator"] != estimator:
        raise top.table("estimator", None).refuse(
            "kind", choices["estimator"], f"{estimator} for the sensors {choices['sensors']}"
        )
    return choices


def _spacecraft(top: Table) -> str:
    file = top.table("spacecraft", ("file",)).text("file", None)
    if "\0" in file:
        raise InputError(f"{top.path}: key spacecraft.file: found a zero byte, expected a path")
    return file


def _steps(run: Table, values: dict[str, float]) -> tuple[int, int]:
    """Number of control periods in a run, and of integration steps in a control period."""
    period = values["run.control_period"]
    count = run.multiple("duration", values["run.duration"], "control period", period, MOST_PERIODS)
    require_period(f"{run.path}: key run.control_period", period)
    if "step" not in run.row:
        return count, 1
    step = run.quantity("step", "time", positive=True)
    require_period(f"{run.path}: key run.step", step)
    return count, run.multiple("control_period", period, "step", step, 10_000)


def _wheel_values(top: Table, start: Table, craft: SpacecraftFile) -> dict[str, float]:
    """Initial speeds, and values of the optional sections, by default from the wheel models."""
    if "wheel_structure" in top.row and "imbalance" not in top.row:
        raise InputError(
            f"{top.place('wheel_structure')}: found it without [imbalance], expected both: it "
            "amplifies imbalance and harmonics"
        )
    names = craft.wheel_names
    row = {"speed": start.row["wheel_speed"]} if "wheel_speed" in start.row else {}
    values = Table(top.path, "start.wheel_", row).each("speed", WHEEL["speed"], names)
    for section, (_, keys) in WHEEL_PARTS.items():
        if section in top.row:
            table = top.table(section, (*keys, *BESIDE.get(section, ())))
            defaults = {
                name: [wheel[name] for wheel in craft.wheel_values]
                for name in keys
                if all(name in wheel for wheel in craft.wheel_values)
            }
            table = table.with_missing(defaults)
            for name, entry in keys.items():
                values |= table.each(name, entry, names)
    return values
