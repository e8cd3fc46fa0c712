"""Write docs/scenario.md from the schema: python docs/make_scenario.py. A test compares them."""

from math import isnan
from pathlib import Path

from gyrostat.scenario.kinds.distributions import DISTRIBUTIONS, NAMED
from gyrostat.scenario.kinds.events import EVENTS
from gyrostat.scenario.kinds.registry import KINDS, PARTS
from gyrostat.scenario.kinds.wheel_keys import WHEEL_ALL, WHEEL_PARTS
from gyrostat.scenario.metrics.budget import BUDGET, gained
from gyrostat.scenario.metrics.kinds import METRICS, RUN_METRICS, WINDOW, WINDOW_METRICS
from gyrostat.scenario.metrics.schema import PERCENTILE, REQUIREMENT, WINDOW_PERCENTILE
from gyrostat.scenario.metrics.tracker_view import HEADS
from gyrostat.scenario.requirement import INDICES, INTERPRETATIONS
from gyrostat.scenario.schema import (
    EVENT_TIME,
    GUARD,
    INERTIA,
    RUN,
    START,
)

HEAD = """# Scenario file

This page lists every key of a scenario file. A scenario names the spacecraft, its controller and
sensors, the events, the dispersions and the metrics. `gyrostat simulate SCENARIO.toml --out RUN.nc`
simulates a single run with nominal values. `gyrostat campaign` simulates many runs with dispersed
values ([tutorial](campaign.md)).

A number is in SI units and radians, or a text with a unit: `0.25`, `"250 ms"`, `"0.1 deg/s"`,
`"3 µN·m"`. Units of gyros are written as data sheets print them: rates and biases in `deg/h`,
`arcsec/s` or `dps`, angle random walks in `deg/√h`, `deg/sqrt(hr)`, `arcsec/√s` or as a density
(of the two-sided spectrum, IEEE Std 952) in `deg/s/√Hz`, rate random walks in `deg/h/√h`, also as
`sigma`, `low` and `high` of a dispersion. An unknown key is refused; the message suggests the most
similar one. Paths are relative to the file. [Files to start from](#ready-scenarios) are in
`examples/scenarios/`. A short scenario:

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

The optional key `name` at the top is shown in the reports; by default it is the name of the file.
"""
OWN = (
    "python",
    "",
    "none",
    '`"FILE.py:NAME"`, [a class of your own](your_own_parts.md), whose fields are keys here. '
    'A scenario that names Python runs it. Beside it, `data = ["FILE", ...]` names '
    "[files that it reads](your_own_parts.md#data-files).",
)
"""Row of the key that names a user-defined part."""
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
            "Delay from a sample to the start of its command. Only commands to actuators are "
            "delayed; targets, estimates and flags are recorded at their own sample.",
        ),
    ],
    "start": [
        ("attitude", "1", "[1, 0, 0, 0]", "Quaternion, body in inertial space, scalar first."),
        (
            "wheel_speed",
            "rad/s",
            "0",
            "Wheel speed relative to the body: one value, or one for each wheel.",
        ),
    ],
    "controller": [
        ("kind", "", "required", "One of the kinds below; or instead"),
        OWN,
        ("target", "1", "[1, 0, 0, 0]", "Target attitude (quaternion), until an event changes it."),
    ],
    "compensator": [("kind", "", "none", "One of the kinds below; or instead"), OWN],
    "unloading": [("kind", "", "none", "One of the kinds below.")],
    "sensors": [("kind", "", "white_noise", "One of the kinds below.")],
    "estimator": [
        (
            "kind",
            "",
            "what the sensors need",
            "One of the kinds below; or instead",
        ),
        OWN,
    ],
    "guard": [
        ("on_bad", "", "hold", "Command after a rejected sample: hold or zero."),
    ],
    "orbit": [
        ("kind", "", "none", "One of the kinds below."),
        ("epoch", "", "that of the elements or the file", "UTC time at time 0 of the run."),
    ],
    "environment": [("kind", "", "constant", "One of the kinds below.")],
    "reference": [("kind", "", "fixed", "One of the kinds below, or `python` in its place.")],
    "metrics": [
        (
            "percentiles",
            "%",
            "[50, 95, 99.7]",
            "Percentiles of the pointing error; each is a metric.",
        ),
        (
            "boresight",
            "1",
            "none",
            "Body direction whose error is evaluated; none: full attitude error.",
        ),
        (
            "field_of_view",
            "rad",
            "none",
            "Full angle of a field of view about the boresight, which the replay shows.",
        ),
        (
            "momentum_budget",
            "",
            "false",
            "Whether the momentum that each external torque adds is a metric, `gained.NAME`.",
        ),
    ],
}
DEFAULTS = {
    "motor_constant": "of the wheel's model",
    "static_imbalance": "of the wheel's sheet, or 0",
    "dynamic_imbalance": "of the wheel's sheet, or 0",
    **{name: "none" for name, key in WINDOW.items() if key.default is None},
    "window": "required except by APE and AKE",
    "stability": "required by PDE",
}
"""Defaults of keys that another file may give, and of those that may be absent."""
DISPERSIONS = """## [[dispersion]]

One table for each dispersed parameter or group of parameters. A campaign needs at least one; a
single run ignores them.

| key | meaning |
|---|---|
| `key` | key of the parameter, from the list below; `wheel.*.NAME`: each wheel independently |
| `distribution` | distribution, with the parameters below |

{distributions}A standard deviation can be relative to the nominal value, `"20 %"`. A smallest,
largest or most likely value can be given by its relative difference from the nominal value, \
`"-10 %"`.

Alternatively, the result of an identification, with its correlations:

| key | meaning |
|---|---|
| `fit` | `fit.json` of `gyrostat identify`, or [`pool.json`](many_records.md) of `gyrostat pool` |
| `wheel` | name of the wheel whose friction and inertia are drawn from it |

Or a [lot of wheels](lot.md#draw-wheels-from-the-lot), whatever the nominal values are:

| key | meaning |
|---|---|
| `lot` | `lot.toml` of `gyrostat lot` |
| `wheel` | name of the wheel that is drawn from it; `*`: each wheel independently |

Dispersions apply to the spacecraft, not to the controller's model of it. Controller and
compensator use the nominal values, unless `controller.` and `compensator.` keys are dispersed. An
impossible draw, such as negative friction, is refused before the first run.

Keys:

| key | unit | meaning |
|---|---|---|
"""
READY = {
    "zero_crossing": "An external torque drives a cubesat's four wheels through zero speed.",
    "zero_crossing_model": "The same, with plainer friction compensation by a model alone.",
    "wheel_failure": (
        "One of four wheels fails. The controller is notified, allocates torque to the others and "
        "rotates the spacecraft."
    ),
    "wheel_failure_found": (
        "In orbit, a wheel fails; the controller is not notified and detects the failure. The "
        "wheels have imbalance, motor drivers with limits and delayed commands."
    ),
    "wheel_array": (
        "In orbit, with star tracker and gyro; wheels are kept away from zero speed and unloaded."
    ),
    "stiff_wheel": (
        "One orbit with a wheel that becomes stiff: the null space keeps wheels out of bands of "
        "speeds and lets the stiff one turn slowly."
    ),
    "science_windows": (
        "Three science windows between slews, for [`gyrostat plan-speeds`](wheel_speed_plans.md): "
        "no wheel is to cross zero or a band in them."
    ),
    "nadir_and_slew": (
        "An Earth observation pass: sun, nadir, slew to a target and back, as a sequence of modes."
    ),
    "own_controller": (
        "A cubesat with [a controller of your own](your_own_parts.md), the class in "
        "`own_controller.py`; its gains are dispersed."
    ),
    "carrara_kuga": (
        "Carrara and Kuga: a fan drives an air-bearing table. Its wheel passes zero speed with "
        "compensation of the identified friction."
    ),
    "moreira_lopes_kuga": (
        "Moreira, Lopes and Kuga: friction compensation by a Kalman filter while the bearing "
        "friction changes."
    ),
    "carvalho_fenili": (
        "Carvalho and Fenili: a wheel of a cube fails under SDRE control (state-dependent Riccati "
        "equation); `lqr` is their other law."
    ),
    "endo_sekiguchi_nonaka": (
        "Endo, Sekiguchi and Nonaka: two wheels and a model error compensator point one axis of a "
        "large spacecraft."
    ),
}
"""File in examples/scenarios -> content."""
ABSENT = """Some models of the papers are not available in scenarios: torques without wheels
(Carvalho and Fenili); wheels on a single axis; ideal speed-commanded wheels. `gyrostat reproduce`
simulates the papers themselves.
"""
GUARD_TEXT = """Validates each measurement before anything is computed from it
(`gyrostat.control.Guarded`). A sample with a value that is not finite, outside its limits or above
its rate limit is rejected: the safe command is used until the next valid sample. Of wheels and
star tracker, whose measurements have a validity flag, only the affected values are rejected.
`sample_status` and `samples_missed` are recorded. Omit the section for a controller without guard:
a sample that is not finite then ends the run."""
ORBIT_TEXT = """Orbit with an epoch, for torques, sensors, actuators and references that need it
([Orbits](orbit.md)). It is computed before the runs, by libraries (the
packages sgp4, ppigrf, pyerfa and pymsis), and interpolated in the runs. Inertial axes are then
those of the GCRS. `epoch` is the UTC time at time 0 of the run, such as
`"2026-11-22T10:00:00Z"`."""
REFERENCE = """The wanted attitude over time. Controllers follow its attitude, rate and acceleration
without lag ([how to](references.md)). With any kind but `fixed`, `controller.target` and
events of the kind `slew` are refused. `python = "FILE.py:NAME"` in place of `kind` names a function
of yours, (time, s) -> quaternion, scalar first, or a class with such a `__call__`.

With `[orbit]`, `position_error = [x, y, z]` (m, GCRS; optional) is the error of the position from
which the controller computes the reference. The pointing error counts from the reference at the
true position. Disperse its components for the error of a navigation solution; one value holds for a
run."""
BANDS_TEXT = """## [[controller.band]]

Any number of bands of wheel speeds, such as resonances of the structure, for the controllers
`wheel_array` and four or more wheels ([Bands and wear](wheel_arrays.md#bands-and-wear)). Zero speed
is avoided without any. The optional `name` is used in keys such as `controller.band.zero.below`; by
default it is `speeds`.
"""
PLAN_TEXT = """## [[controller.plan]]

Momentum of the wheels over time for the controller `wheel_array`, as `gyrostat plan-speeds` writes
it ([Wheel speeds for science](wheel_speed_plans.md)). Each entry holds until the next; the first
holds from the start of the run. Null-space control and unloading then follow the plan alone. The
`name` is used in keys such as `controller.plan.imaging.time`; every entry needs another one.
"""
TORQUES_TEXT = """## [[environment.torque]]

Any number of further external torques, added to that of `[environment]`: one of the kinds below, or
[your own](your_own_plant_parts.md#environment-torques) with `python = "FILE.py:NAME"` in place of
`kind`.
The optional `name` is used in keys such as `environment.torque.drag.area`; it consists of letters,
digits and underscores. By default it is the kind, or the class in lower case with underscores.
"""
HARMONICS_TEXT = """## [[imbalance.harmonic]]

Disturbances of the wheels at other multiples of the wheel speed than 1, such as those of bearings
([Wheel jitter](wheel_jitter.md)). Each number is one for all wheels. The optional `name` is used in
keys such as `imbalance.harmonic.cage.force`; by default it is `harmonic`.
"""
STATION_TEXT = """## [[station]]

One table for each ground station. `gyrostat check` lists its passes, and a mode of the reference
can wait for one ([Targets](references.md#ground-stations-passes-and-eclipses)). The optional `name`
is used in keys; by default it is `ground`.
"""
KEEP_OUT_TEXT = """## [[keep_out]]

One table for each instrument that must not see bright bodies. `gyrostat check` lists the times in
which it does along the reference, `simulate` those of the run
([Keep-out angles](keep_out.md)). The optional `name` is used in keys; by default it is
`instrument`.
"""
HEADS_TEXT = """## [[star_tracker]]

One table for each head of the star tracker of the sensors `star_tracker_gyro` or `star_tracker`
([Sensors and actuators](sensors_and_actuators.md#star-tracker-heads)). Without any, the tracker has
the noise `sensors.attitude_sigma` about each body axis and is never blind; with heads, this is the
noise that the estimator assumes. The optional `name` is used in keys; by default it is `head`.
"""
SENSOR_TEXT = """## [[sensor]]

Any number of sensors in addition to `[sensors]`: one of the kinds below, or [your
own](your_own_plant_parts.md#sensors) with `python = "FILE.py:NAME"` instead of `kind`. `name` (by
default the kind, or the class in lower case with underscores) is the field of the measurement that
the sensor gives. Sensor faults (`sensor = "NAME"`) and the limits of `[guard]`
(`NAME_lower`, `NAME_upper`, `NAME_change`, in the unit of the sensor) apply to it. Its noise does
not change that of the other sensors.
"""
ACTUATOR_TEXT = """## [[actuator]]

Any number of actuators in addition to the wheels: one of the kinds below, or [your
own](your_own_plant_parts.md#actuators) with `python = "FILE.py:NAME"` instead of `kind`. `name` is
the field of the command that drives the actuator; the controller must command it. It is subject to
`run.command_delay`.
"""
OWN_EVENT = """`python = "FILE.py:NAME"` instead of `kind`: [an event of your
own](your_own_plant_parts.md#events), which changes numbers of the spacecraft at the exact `time`.
"""
METRIC_TEXT = """## [[metric]]

Any number of metrics: of a kind below, or [your own](your_own_plant_parts.md#metrics), `python =
"FILE.py:NAME"`. `name` (by default the kind, or the class in lower case with underscores) is the
column of the table of runs. A metric `jitter` has a `file`, the wheels on their structure, and may
have a `window`, one name or several; by default the whole run counts ([Microvibration](
microvibration.md#in-the-runs-of-a-scenario)).
"""
METRICS_OUT = """## Metrics

The columns of the table of runs, in addition to `run`, the drawn values, `status` (0: complete)
and `ended` (s). They are computed during the run. Percentiles are exact, by rank, except in very
long runs ([campaign](campaign_background.md#percentiles)).
"""
WINDOW_TEXT = """Metrics of a part of a run, such as the imaging after a slew. The names of these
metrics start with the name of the window: `imaging.error_max`.

```toml
[[metrics.window]]
name = "imaging"
event = "turn"             # times are counted from the time of this event
from = "90 s"
until = "150 s"
boresight = [0.0, 0.0, 1.0]
exposure = "0.5 s"         # smear
jitter_above = "0.1 Hz"    # jitter
dwell_below = "20 rpm"     # dwell
```

`boresight`: body direction whose error is evaluated; by default that of `[metrics]`. `event`: name
of an event or of a `[[reference.slew]]`; times are counted from it. `mode`: name of a
`[[reference.mode]]`; times are counted from its start, and the window ends with the mode. Without
event and mode, times are those of the run. `propellant`: name of a signal of the command
or of the record of the plant, kg/s. The numbers can be dispersed."""
WINDOW_OUT = """The metrics of a window, each with the key of the window that requests it. A window
without samples, such as one between two samples, has none of them (NaN).
"""
DEFINITIONS = """Definitions:

- The rotation about the boresight is that of the error quaternion, decomposed into this rotation
  and a tilt of the boresight.
- The smear is the largest angle between the boresight at the start of an exposure and at any later
  sample of the same exposure, relative to the reference. Exposures lie within the window. They
  start at every sample; those of more than 16 control periods start about every sixteenth of the
  exposure time. A drift is exact. The smear of an oscillation with twice the exposure time as
  period is at most 0.3 % too low, with half of it at most 4 %. For a faster one see `jitter`.
- The jitter is the root mean square of the boresight's direction relative to the reference (without
  boresight, of the rotation vector of the error) after a Butterworth high pass of order 4 with the
  cut-off frequency `jitter_above`, and a Butterworth low pass of order 4 with `jitter_below` if it
  is given. The amplitude gain is 0.707 at a cut-off frequency, above 0.998 one octave inside the
  band and below 0.0625 one octave outside (both filters by the bilinear transform, so that it is
  even lower near half of the sample frequency). The filter starts in steady state with the first
  sample of the run and also processes samples before the window. A slew within or shortly before
  the window is part of the jitter.
- `dwell` counts samples in which the size of a wheel's speed is from `dwell_above` to
  `dwell_below`.
- A window of an event ends at the next slew by default. `settling` uses `metrics.settled_angle`,
  and `metrics.settled_rate` for the rate error."""


REQUIREMENT_TEXT = """Any number of pointing requirements in the terms of ECSS-E-ST-60-10C. Each
adds a metric `requirement.NAME`, and the report a verdict with its margin ([Is my requirement
met?](requirement.md)). `gyrostat report DIR --check` has the exit code 1 unless all are met.

```toml
[[requirement]]
index = "RPE"
window = "1 s"
level = 0.997
value = "5 arcsec"
```

`name`: by default the index in lower case. `interpretation`: see below; by default `mixed`.

`axis`: component of the error vector. `x`, `y`, `z`: of its rotation vector, in body axes; `full`:
its length; `half_cone`: angle between the boresight and its target direction; `about`: rotation
about the boresight. By default `half_cone` if there is a boresight, otherwise `full`. `boresight`:
by default that of the windows, or of `[metrics]`.

`during`: windows of the metrics; every interval of them is an observation period. By default it is
the run after `metrics.after`. `instant`: place of t in the window of RPE and RKE, `any`, `end` or
`centre`; by default `any`. `estimate`: signal of the command, of the measurement or of the record
with the known attitude; by default `estimated_attitude` of the controller if it has one, otherwise
the measured `attitude`. The numbers of a requirement cannot be dispersed."""


AROUND_TEXT = (
    " `keep_out`, a name or a list: the `[[keep_out]]` that "
    "[the slew to it leads around](keep_out.md#slews-around-a-cone)."
)


def entry(name, key):
    """A row of a table of keys."""
    # a default that is not allowed stands for a limit that is not given
    defaults = ["none" if value < key.least else shown(value) for value in key.defaults()]
    values = defaults or ["required"]
    default = values[0] if len(values) == 1 else f"[{', '.join(values)}]"
    return f"| `{name}` | {key.unit} | {DEFAULTS.get(name, default)} | {key.meaning} |"


def shown(value):
    """A default value, "none" where it is infinite."""
    return f"{value:.4g}".removeprefix("-inf").replace("inf", "none") or "none"


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
        keys = component.keys()
        lines += [f'`kind = "{name}"`: {component.meaning()}', ""]
        if keys:
            lines += ["| key | unit | default | meaning |", "|---|---|---|---|"]
            lines += [*(entry(n, key) for n, key in keys.items()), ""]
    return lines


def named(name, key):
    """A row with the full key of a number, or those of a vector."""
    names = f"`{name}.x`, `.y`, `.z`" if key.shape == (3,) else f"`{name}`"
    return f"| {names} | {key.unit} | {key.meaning} |"


def distributions():
    """Lines on the distributions and their parameters."""
    for name in NAMED:
        kind = DISTRIBUTIONS[name]
        yield f'`distribution = "{name}"`: {kind.__doc__.strip()}\n\n'
        yield "| key | default | meaning |\n|---|---|---|\n"
        for key, (_, meaning, default) in kind.parameters().items():
            shown = "the nominal value" if default is not None and isnan(default) else "none"
            shown = "required" if default is None else shown
            yield f"| `{key}` | {shown} | {meaning} |\n"
        yield "\n"  # a blank line after the table


def dispersed():
    """Rows of the keys that can be dispersed."""
    names = {f"body.inertia.{e}": INERTIA for e in ("xx", "yy", "zz", "xy", "xz", "yz")}
    names |= {f"wheel.NAME.{n}": key for n, key in WHEEL_ALL.items()}
    rows = [named(name, key) for name, key in names.items()]
    rows.append(
        "| `wheel.NAME.coulomb`, ... | | Parameters of the friction model of its model file. |"
    )
    rows.append(
        "| `flexible.NAME.KEY`, `hinged_panel.NAME.KEY`, `slosh.NAME.KEY` | | Numbers of an "
        "appendage of the spacecraft file: [flexible appendages](flexible.md). |"
    )
    rows += [named(f"start.{name}", key) for name, key in START.items()]
    parts = ", ".join(
        f"`{name}.KEY`"
        for name in (
            *(
                "controller",
                "compensator",
                "unloading",
                "estimator",
                "sensors",
                "orbit",
                "environment",
                "reference",
            ),
            *("reference.slew.NAME", "reference.mode.NAME", "guard"),
        )
    )
    rows.append(
        f"| {parts} | | Keys of the chosen kinds; for a vector `.x`, `.y`, `.z` of the key. |"
    )
    rows.append("| `window.NAME.KEY` | | Numbers of a window of the metrics. |")
    lists = (
        "controller.band",
        "controller.plan",
        "environment.torque",
        "imbalance.harmonic",
        "star_tracker",
        "sensor",
        "actuator",
    )
    lists += ("metric",)
    parts = ", ".join(f"`{name}.NAME.KEY`" for name in lists)
    rows.append(f"| {parts} | | Numbers of the part with this name. |")
    rows.append(
        "| `event.NAME.KEY` | | Numbers of an event; the order of the events must not change. |"
    )
    return rows


def requirement():
    """The tables [[requirement]]."""
    lines = section("[requirement]", REQUIREMENT, REQUIREMENT_TEXT)
    lines += ["| index | meaning |", "|---|---|"]
    lines += [*(f"| `{name}` | {meaning} |" for name, (_, _, meaning) in INDICES.items()), ""]
    lines += ["| interpretation | `level` is a |", "|---|---|"]
    return [*lines, *(f"| `{n}` | {meaning} |" for n, meaning in INTERPRETATIONS.items()), ""]


def asking(key: str) -> str:
    """What requests a metric of a window."""
    if key == HEADS:
        return f"`[[{key}]]`"
    return f"`{key}`" if key else "always"


def page():
    """The whole page."""
    lines = [HEAD, "## Ready scenarios", ""]
    lines += ["In `examples/scenarios/`, each with dispersions for a campaign:", ""]
    lines += ["| file | content |", "|---|---|"]
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
        (
            "controller",
            KINDS["controller"],
            "The controller is designed for the nominal spacecraft, and again at events.",
        ),
        ("compensator", KINDS["compensator"], ""),
        (
            "unloading",
            KINDS["unloading"],
            "Momentum unloading of the wheels, added to the controller and its compensator "
            "([Sensors and actuators](sensors_and_actuators.md#momentum-unloading)).",
        ),
        ("sensors", KINDS["sensors"], ""),
        (
            "estimator",
            KINDS["estimator"],
            "The estimator processes the measurements before the controller uses them. With a "
            "controller of your own, the kind `none` fits any sensors.",
        ),
        ("orbit", KINDS["orbit"], ORBIT_TEXT),
        ("environment", KINDS["environment"], ""),
        ("reference", KINDS["reference"], REFERENCE),
    ):
        lines += [*section(name, {}, text), *kinds(components)]
    for name in ("reference.slew", "reference.mode", "reference.transition"):
        shown_kinds = {
            # the keys of `conditions` once
            kind: getattr(part, "user", None) or part
            for kind, part in PARTS[name].items()
        }
        text = "" if name == "reference.transition" else AROUND_TEXT
        unique = f"Each has a unique `name`.{text}"
        lines += [f"## [[{name}]]", "", unique, "", *kinds(shown_kinds)]
    for text, section_name in (
        (BANDS_TEXT, "controller.band"),
        (PLAN_TEXT, "controller.plan"),
        (TORQUES_TEXT, "environment.torque"),
        (HARMONICS_TEXT, "imbalance.harmonic"),
        (STATION_TEXT, "station"),
        (KEEP_OUT_TEXT, "keep_out"),
        (HEADS_TEXT, "star_tracker"),
        (SENSOR_TEXT, "sensor"),
        (ACTUATOR_TEXT, "actuator"),
    ):
        lines += [text, *kinds(PARTS[section_name])]
    lines += section("guard", GUARD, GUARD_TEXT)
    lines += [
        "## [[event]]",
        "",
        "Each event has a unique `name` and a `kind`; all kinds except a slew and sensor faults "
        "have a `wheel` (by name). A wheel can have one friction step and one other event. "
        "`target` is a quaternion, scalar first. `sensor` is a measured field: `attitude`, `rate` "
        "or `wheel_speed`. Name an `axis` (`x`, `y`, `z`) of `rate` or a `wheel` of `wheel_speed` "
        "to affect only this element. A sensor may have several faults. `magnitude` of a spike is "
        "in the unit of the field, `slope` of a drift in that per second. A time is random where "
        "a `[[dispersion]]` has the key `event.NAME.time`.",
        "",
        OWN_EVENT,
    ]
    for name, kind in EVENTS.items():
        lines += [f'`kind = "{name}"`: {" ".join(kind.__doc__.split())}', ""]
        lines += ["| key | unit | default | meaning |", "|---|---|---|---|"]
        lines += [*(entry(n, key) for n, key in {"time": EVENT_TIME, **kind.keys()}.items()), ""]
    lines += section("metrics", METRICS)
    window = section("[metrics.window]", WINDOW, WINDOW_TEXT)
    lines += [*window, METRIC_TEXT, *kinds(PARTS["metric"]), METRICS_OUT]
    lines += ["| metric | unit | meaning |", "|---|---|---|"]
    results = {"error_pNN": PERCENTILE}
    for kind in RUN_METRICS:
        with_heads = f" With `[[{kind.asked_by}]]` only." if kind.asked_by else ""
        results |= {
            name: column._replace(meaning=column.meaning + with_heads)
            for name, column in kind.columns.items()
        }
    results[gained("NAME")] = BUDGET
    lines += [
        *(f"| `{n}` | {column.unit} | {column.meaning} |" for n, column in results.items()),
        "",
    ]
    lines += [WINDOW_OUT, "| metric | unit | requested by | meaning |", "|---|---|---|---|"]
    asked = [("error_pNN", WINDOW_PERCENTILE, "")]
    asked += [(n, c, kind.asked_by) for kind in WINDOW_METRICS for n, c in kind.columns.items()]
    each = WINDOW_PERCENTILE._replace(unit="1", meaning="The same of the wheel with this name.")
    asked += [("dwell.NAME", each, "dwell_below")]
    lines += [
        f"| `{n}` | {column.unit} | {asking(key)} | {column.meaning} |" for n, column, key in asked
    ]
    lines += ["", DEFINITIONS, "", *requirement()]
    head = DISPERSIONS.replace("{distributions}", "".join(distributions()))
    lines += [head + "\n".join(dispersed())]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    Path(__file__).with_name("scenario.md").write_text(page(), encoding="utf-8")
