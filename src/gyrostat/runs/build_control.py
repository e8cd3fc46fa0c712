"""Stages that build the controller, the sensor and the metrics of a run."""

from dataclasses import replace
from typing import Any

from gyrostat.control import AttitudeTargets
from gyrostat.control.guidance import Guided, Reference
from gyrostat.core.jax64 import jax, jnp
from gyrostat.runs.assembly import Assembly
from gyrostat.runs.build_parts import named_parts
from gyrostat.runs.build_reference import navigated, reference_of
from gyrostat.runs.designs import phase_starts
from gyrostat.runs.phases import Phases, in_orbit
from gyrostat.scenario.build_spacecraft import has_section, of_wheels
from gyrostat.scenario.kinds.registry import chosen
from gyrostat.scenario.sensing import arrays_of, guarded, with_faults
from gyrostat.spacecraft import AddedSensors
from gyrostat.spacecraft.sensors.star_tracker_heads import StarTrackerHeads


def read_options(run: Assembly) -> dict[str, Any]:
    """Options of the controller, with the bands and the wear of the wheels."""
    structure, values = run.structure, run.values
    options = arrays_of(values, "controller", chosen(structure, "controller").keys)
    bands = named_parts(structure, values, "controller.band")
    if bands:
        options["bands"] = dict(sorted(bands.items()))
    if has_section(structure, "wear"):
        options["wear"] = of_wheels(structure, values, "wear")
    return {"options": options}


def add_controller(run: Assembly) -> dict[str, Any]:
    """Controller with the design of each phase."""
    law = chosen(run.structure, "controller")
    made = [law.make(plan, run.options, run.start.momentum) for plan in run.plans.controllers]
    times = phase_starts(run.structure, run.values)
    starts = jnp.stack([jnp.asarray(time, dtype=float) for time in times])
    joined = jax.tree.map(lambda *leaves: jnp.stack([jnp.asarray(x) for x in leaves]), *made)
    return {"starts": starts, "controller": Phases(starts, joined, orbit=run.orbit)}


def add_reference(run: Assembly) -> dict[str, Any]:
    """Reference attitude at the true position, and as the controller computes it."""

    def reference(orbit: Any) -> Reference | None:
        given = run.structure, run.values, run.plans, run.start, run.starts, orbit
        return reference_of(*given)

    true = guide = reference(run.orbit)
    navigation = navigated(run.values, run.orbit)
    if navigation is not run.orbit:
        guide = reference(navigation)
    if true is None and getattr(run.controller.plans, "takes_reference", False):
        guide = Reference.of(AttitudeTargets(run.starts, jnp.asarray(run.plans.targets)))
    return {"reference": true, "guide": guide}


def follow_reference(run: Assembly) -> dict[str, Any]:
    """Controller that follows the reference."""
    if run.guide is None:
        return {}
    return {"controller": Guided(run.controller, run.guide, run.structure.command_delay)}


def add_compensator(run: Assembly) -> dict[str, Any]:
    """Friction compensator around the controller."""
    delay, period = run.structure.command_delay, run.values["run.control_period"]
    known, sensors = run.plans.known, run.plans.sensors
    made = run.component("compensator", run.controller, known, delay, period, sensors)
    return {"controller": in_orbit(made, run.orbit)}


def add_unloading(run: Assembly) -> dict[str, Any]:
    """Unloading of the wheels around the compensated controller."""
    return {"controller": run.component("unloading", run.controller, run.plans.known)}


def add_estimator(run: Assembly) -> dict[str, Any]:
    """Estimator around all that uses estimates."""
    made = run.component("estimator", run.controller, run.plans.known, run.plans.sensors)
    return {"controller": in_orbit(made, run.orbit)}


def add_sensors(run: Assembly) -> dict[str, Any]:
    """Sensors of the plant, with the heads of star trackers and further sensors."""
    structure, values, known = run.structure, run.values, run.plans.known
    sensor = run.component("sensors", run.plant, known)
    heads = named_parts(structure, values, "star_tracker", orbit=run.orbit)
    if heads:
        tracker = StarTrackerHeads(tuple(heads.values()), sensor.tracker.periods)
        sensor = replace(sensor, tracker=tracker)
    given = {"plant": run.plant, "spacecraft": known, "orbit": run.orbit}
    added = named_parts(structure, values, "sensor", **given)
    return {"sensor": AddedSensors(sensor, added) if added else sensor}


def add_faults(run: Assembly) -> dict[str, Any]:
    """Faults of the sensors."""
    return {"sensor": with_faults(run.structure, run.values, run.sensor)}


def add_guard(run: Assembly) -> dict[str, Any]:
    """Guard of the measurements around the whole controller."""
    given = run.structure, run.values, run.controller, run.sensor, run.start
    return {"controller": guarded(*given)}


def add_metrics(run: Assembly) -> dict[str, Any]:
    """User-defined metrics."""
    given = {"spacecraft": run.plans.known, "orbit": run.orbit}
    return {"metrics": named_parts(run.structure, run.values, "metric", **given)}
