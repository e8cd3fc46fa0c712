"""Write docs/scenario.md from the schema: python docs/make_scenario.py. A test compares them."""

from pathlib import Path

from gyrostat.campaigns.components import COMPENSATORS, ENVIRONMENTS, ESTIMATORS, SENSORS
from gyrostat.campaigns.controllers import CONTROLLERS
from gyrostat.campaigns.schema import (
    EVENTS,
    GUARD,
    INERTIA,
    METRICS,
    RESULTS,
    RUN,
    START,
    WHEEL_ALL,
    WHEEL_PARTS,
)

HEAD = """# Scenario file

A scenario says what flies, what happens to it, what is uncertain of it and what is measured of the
flight. `gyrostat simulate SCENARIO.toml --out RUN.nc` flies it once, with the values as they stand;
`gyrostat campaign` flies it many times, each run with values of its own ([campaign](campaign.md)).

A number is in SI units and radians, or a text with a unit: `0.25`, `"250 ms"`, `"0.1 deg/s"`,
`"3 µN·m"`. A key that nobody reads is refused, with the one that was probably meant. Paths are
relative to the file. [Files to start from](#ready-scenarios) are in `examples/scenarios/`.

```toml
name = "my cubesat"

[run]
duration = "600 s"
control_period = "0.25 s"

[spacecraft]
file = "cubesat.toml"

[controller]
kind = "three_axis"
target = [1.0, 0.0, 0.0, 0.0]

[[dispersion]]
key = "wheel.*.coulomb"
distribution = "log_normal"
sigma = "20 %"
```

Optional at the top: `name`, for the reports; by default the name of the file.
"""
EXTRA = {
    "run": [
        (
            "step",
            "s",
            "one control period",
            "Longest integration step; divides the control period.",
        ),
        (
            "command_delay",
            "periods",
            "0",
            "From a sample to the start of the command made from it. Only what goes to actuators "
            "is delayed; targets, estimates and flags stand in the history at their own sample.",
        ),
    ],
    "start": [
        ("attitude", "1", "[1, 0, 0, 0]", "Quaternion, body in inertial space, scalar first."),
        ("wheel_speed", "rad/s", "0", "Of the wheels relative to the body: one, or one a wheel."),
    ],
    "controller": [
        ("kind", "", "required", "One of those below."),
        ("target", "1", "[1, 0, 0, 0]", "Quaternion to hold, until an event gives another."),
    ],
    "compensator": [("kind", "", "none", "One of those below.")],
    "sensors": [("kind", "", "white_noise", "One of those below.")],
    "estimator": [("kind", "", "what the sensors need", "One of those below.")],
    "guard": [
        ("on_bad", "", "hold", "Command in place of one from a rejected sample: hold or zero."),
    ],
    "environment": [("kind", "", "constant", "One of those below.")],
    "metrics": [
        ("percentiles", "%", "[50, 95, 99.7]", "Of the pointing error, each a metric."),
        ("boresight", "1", "none", "Body direction whose error counts; none: the whole attitude."),
    ],
}
DEFAULTS = {
    "motor_constant": "of the wheel's model",
    "static_imbalance": "of the wheel's sheet, or 0",
    "dynamic_imbalance": "of the wheel's sheet, or 0",
}
"""Of keys that another file may give."""
DISPERSIONS = """## [[dispersion]]

One table for each value that scatters, or group of values. A campaign needs at least one; a single
run takes none of them into account.

| key | meaning |
|---|---|
| `key` | of a value, as in the list below; `wheel.*.NAME` means each wheel on its own |
| `distribution` | `normal`, `uniform` or `log_normal` |
| `sigma` | `normal`: standard deviation about the nominal value, or a share of it, `"20 %"`; \
`log_normal`: of the natural logarithm, the nominal value being the median |
| `low`, `high` | `uniform`: the ends, or shares by which they differ from the \
nominal value, `"-10 %"` |

Or, instead of these, what an identification has found, with its correlations:

| key | meaning |
|---|---|
| `fit` | `fit.json` of `gyrostat identify` |
| `wheel` | name of the wheel whose friction and inertia scatter so about the values of its model |

The spacecraft scatters, not what the controller knows of it: controller and compensator work with
the nominal values, and with `controller.` and `compensator.` keys that scatter if you say so. A
draw that makes no sense, such as a negative friction, is refused before anything flies.

Keys:

| key | unit | meaning |
|---|---|---|
"""
READY = {
    "zero_crossing": "A torque from outside drives a cubesat's four wheels through zero speed.",
    "wheel_failure": (
        "One of the four dies; the controller is told, allocates to the others, and turns the"
        " spacecraft."
    ),
    "wheel_failure_found": (
        "In an orbit; nobody tells the controller, it finds out. The wheels are out of "
        "balance, their drivers have limits, commands come late."
    ),
    "wheel_array": (
        "In an orbit, on star tracker and gyro; the wheels are kept from zero speed and unloaded."
    ),
    "carrara_kuga": (
        "Carrara and Kuga: a fan turns an air-bearing table, whose wheel passes zero speed "
        "with the friction that they identified compensated."
    ),
    "moreira_lopes_kuga": (
        "Moreira, Lopes and Kuga: a Kalman filter finds the friction that is compensated, "
        "while a bearing wears."
    ),
    "carvalho_fenili": (
        "Carvalho and Fenili: a cube under a state-dependent Riccati equation loses a wheel; "
        "`lqr` is their other law."
    ),
    "endo_sekiguchi_nonaka": (
        "Endo, Sekiguchi and Nonaka: two wheels and a model error compensator lead one axis "
        "of a large spacecraft to its target."
    ),
}
"""File in examples/scenarios -> what flies."""
ABSENT = """What the papers have and a scenario has not: friction with bristles (LuGre), which flies
on a bench but not on a spacecraft; torques without wheels, as those of Carvalho and Fenili; wheels
on a single axis; wheels whose speed is whatever is commanded. `gyrostat reproduce` flies the papers
themselves.
"""
GUARD_TEXT = """Validates each measurement before anything is computed from it
(`gyrostat.control.Guarded`): a sample with a value that is not finite, outside its limits or
faster than its limit is rejected, the command is the safe one, and the next good sample continues.
Wheels and star tracker, whose measurements have a flag, lose their own values alone. Recorded are
`sample_status` and `samples_missed`. Leave the section out for a controller without it: one sample
that is not finite then ends the run."""
METRICS_OUT = """## What is measured

The columns of the table of runs, beside `run`, the drawn values, `status` (0: complete) and `ended`
(s). They are computed while a run flies. Percentiles are exact, by rank, but for very long runs
([campaign](campaign.md#read-the-report)).

| metric | unit | meaning |
|---|---|---|
| `error_pNN` | rad | That percentile of the pointing error over the time after `metrics.after`. |
"""


def entry(name, key):
    """A row of a table of keys."""
    default = (
        "required"
        if key.default is None
        else f"{key.default:.4g}".removeprefix("-inf").replace("inf", "none") or "none"
    )
    default = "[0, 0, 0]" if key.size == 3 else DEFAULTS.get(name, default)
    return f"| `{name}` | {key.unit} | {default} | {key.meaning} |"


def per_wheel():
    """The optional sections with numbers of every wheel."""
    lines = []
    for name, (meaning, keys) in WHEEL_PARTS.items():
        lines += section(name, keys, f"{meaning} Each number is one for all wheels, or a list.")
    return lines


def section(name, keys, text=""):
    """A table [name] of the file."""
    rows = [entry(n, key) for n, key in keys.items()]
    rows += [f"| `{n}` | {u} | {d} | {m} |" for n, u, d, m in EXTRA.get(name, [])]
    head = ["| key | unit | default | meaning |", "|---|---|---|---|"]
    return [f"## [{name}]", "", *([text, ""] if text else []), *head, *rows, ""]


def kinds(components):
    """The kinds of a section, each with its keys."""
    lines = []
    for name, component in components.items():
        lines += [f'`kind = "{name}"`: {component.meaning}', ""]
        if component.keys:
            lines += ["| key | unit | default | meaning |", "|---|---|---|---|"]
            lines += [*(entry(n, key) for n, key in component.keys.items()), ""]
    return lines


def named(name, key):
    """A row with the full key of a number, or those of a vector."""
    names = f"`{name}.x`, `.y`, `.z`" if key.size == 3 else f"`{name}`"
    return f"| {names} | {key.unit} | {key.meaning} |"


def dispersed():
    """Rows of the keys that can scatter."""
    names = {f"body.inertia.{e}": INERTIA for e in ("xx", "yy", "zz", "xy", "xz", "yz")}
    names |= {f"wheel.NAME.{n}": key for n, key in WHEEL_ALL.items()}
    rows = [named(name, key) for name, key in names.items()]
    rows.append(
        "| `wheel.NAME.coulomb`, ... | | Parameters of the friction model of its model file. |"
    )
    rows += [named(f"start.{name}", key) for name, key in START.items()]
    parts = ", ".join(
        f"`{name}.KEY`"
        for name in ("controller", "compensator", "estimator", "sensors", "environment", "guard")
    )
    rows.append(
        f"| {parts} | | Those of the chosen kinds; of a vector `.x`, `.y`, `.z` of the key. |"
    )
    rows.append("| `event.NAME.KEY` | | Numbers of an event; the order of events must stay. |")
    return rows


def page():
    """The whole page."""
    lines = [HEAD, "## Ready scenarios", ""]
    lines += ["In `examples/scenarios/`, each with dispersions for a campaign:", ""]
    lines += ["| file | what flies |", "|---|---|"]
    lines += [*(f"| `{name}.toml` | {text} |" for name, text in READY.items()), "", ABSENT]
    lines += section("run", RUN)
    lines += [
        "## [spacecraft]",
        "",
        "| key | meaning |",
        "|---|---|",
        "| `file` | [spacecraft file](conventions.md#spacecraft-file): body, wheels and, for each "
        "wheel, the `model.toml` with its friction; required |",
        "",
    ]
    lines += [*section("start", START), *per_wheel()]
    for name, components, text in (
        ("controller", CONTROLLERS, "Planned for the nominal spacecraft; planned anew at events."),
        ("compensator", COMPENSATORS, ""),
        ("sensors", SENSORS, ""),
        ("estimator", ESTIMATORS, "Between sensors and controller."),
        ("environment", ENVIRONMENTS, ""),
    ):
        lines += [*section(name, {}, text), *kinds(components)]
    lines += section("guard", GUARD, GUARD_TEXT)
    lines += [
        "## [[event]]",
        "",
        "Each has a `name` of its own, a `kind`, a `wheel` (by name) unless it is a slew, and a "
        "wheel has one friction step and one other event. `target` is a quaternion, scalar first. "
        "`sensor` is a measured field: `attitude`, `rate` or `wheel_speed`; an `axis` (`x`, `y`, "
        "`z`) of `rate` or a `wheel` of `wheel_speed` may be named, or all elements are "
        "hit. A sensor may have several faults. `magnitude` of a spike is in the unit of the "
        "field.",
        "",
    ]
    for kind, (meaning, keys) in EVENTS.items():
        lines += [f'`kind = "{kind}"`: {meaning}', ""]
        lines += ["| key | unit | default | meaning |", "|---|---|---|---|"]
        lines += [*(entry(n, key) for n, key in keys.items()), ""]
    lines += section("metrics", METRICS)
    lines += [
        METRICS_OUT + "\n".join(f"| `{n}` | {u} | {m} |" for n, (u, m) in RESULTS.items()),
        "",
    ]
    lines += [DISPERSIONS + "\n".join(dispersed())]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    Path(__file__).with_name("scenario.md").write_text(page(), encoding="utf-8")
