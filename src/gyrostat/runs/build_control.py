"""Stages that build the controller, the sensor and the metrics of a run."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from gyrostat.control import AttitudeTargets
from gyrostat.control.guidance import Guided, ModeLaws, Reference
from gyrostat.core.jax64 import jax, jnp
from gyrostat.runs.assembly import Assembly, context_of
from gyrostat.runs.build_parts import named_kinds, named_parts
from gyrostat.runs.build_reference import navigated, reference_case
from gyrostat.runs.designs import phase_starts
from gyrostat.runs.phases import Phases, in_orbit
from gyrostat.scenario.build_spacecraft import has_section, of_wheels
from gyrostat.scenario.controller_kind import Beginning
from gyrostat.scenario.scenario import KEEP_OUT, LAW
from gyrostat.scenario.sensing import guarded, with_faults
from gyrostat.scenario.timeline import modes
from gyrostat.spacecraft import AddedSensors
from gyrostat.spacecraft.sensors.star_tracker_heads import StarTrackerHeads


def choose_law(run: Assembly) -> dict[str, Any]:
    """Kind of the controller with its values."""
    return {"law": run.component("controller")}


def add_controller(run: Assembly) -> dict[str, Any]:
    """Controller with the design of each phase."""
    structure, values = run.structure, run.values
    bands = named_parts(structure, values, "controller.band", context_of(run))
    wear = of_wheels(structure, values, "wear") if has_section(structure, "wear") else None
    plan = [*named_parts(structure, values, "controller.plan", context_of(run)).values()]
    ordered = [band for _, band in sorted(bands.items())]
    beginning = Beginning(run.start.momentum, ordered, plan, wear)
    times = phase_starts(structure, values)
    starts = jnp.stack([jnp.asarray(time, dtype=float) for time in times])

    def phases(law: Any, designs: Sequence[Any]) -> Phases:
        each = [law.controller(design, beginning) for design in designs]
        plans = jax.tree.map(lambda *leaves: jnp.stack([jnp.asarray(x) for x in leaves]), *each)
        return Phases(starts, plans, orbit=run.orbit)

    others = named_kinds(structure, values, LAW)
    laws = [run.law, *others.values()]
    controllers = map(phases, laws, [run.plans.controllers, *run.plans.laws])
    controller: Any = next(controllers)
    if others:
        names = list(others)
        chosen = [
            1.0 + names.index(part.linked("law")[0]) if part.linked("law") else 0.0
            for part in structure.parts
            if part.section == "reference.mode"
        ]
        follows = tuple(law.follows for law in laws)
        controller = ModeLaws(
            (controller, *controllers), jnp.asarray(chosen), follows, len(structure.wheels)
        )
    return {"starts": starts, "controller": controller}


def add_reference(run: Assembly) -> dict[str, Any]:
    """Reference attitude at the true position, and as the controller computes it."""

    def reference(orbit: Any) -> Reference | None:
        if run.plans.reference is None:
            return None
        kind, case = reference_case(
            run.structure, run.values, run.plans, run.start, run.starts, orbit
        )
        return kind.reference(case)

    true = guide = reference(run.orbit)
    navigation = navigated(run.values, run.orbit)
    if navigation is not run.orbit:
        guide = reference(navigation)
    if true is None and getattr(run.controller, "takes_reference", False):
        guide = Reference.of(AttitudeTargets(run.starts, jnp.asarray(run.plans.targets)))
    return {"reference": true, "guide": guide}


def follow_reference(run: Assembly) -> dict[str, Any]:
    """Controller that follows the reference."""
    if run.guide is None:
        return {}
    return {"controller": Guided(run.controller, run.guide, run.structure.command_delay)}


def add_compensator(run: Assembly) -> dict[str, Any]:
    """Friction compensator around the controller."""
    controller = run.component("compensator").make(context_of(run, "controller"))
    return {"controller": in_orbit(controller, run.orbit)}


def add_unloading(run: Assembly) -> dict[str, Any]:
    """Unloading of the wheels around the compensated controller."""
    unloading = run.component("unloading").make(context_of(run, "controller"))
    acts = [run.values[f"reference.mode.{name}.unloading"] for name in modes(run.structure.parts)]
    if run.structure.unloading == "none" or not acts:
        return {"controller": unloading}
    return {"controller": replace(unloading, in_modes=jnp.stack([jnp.asarray(a) for a in acts]))}


def add_estimator(run: Assembly) -> dict[str, Any]:
    """Estimator around all that uses estimates."""
    controller = run.component("estimator").make(context_of(run, "controller"))
    return {"controller": in_orbit(controller, run.orbit)}


def add_sensors(run: Assembly) -> dict[str, Any]:
    """Sensors of the plant, with the heads of star trackers and further sensors."""
    structure, values, context = run.structure, run.values, context_of(run, "plant", "orbit")
    sensor = run.component("sensors").make(context)
    heads = named_parts(structure, values, "star_tracker", context)
    if heads:
        tracker = StarTrackerHeads(tuple(heads.values()), sensor.tracker.periods)
        sensor = replace(sensor, tracker=tracker)
    further = named_parts(structure, values, "sensor", context)
    return {"sensor": AddedSensors(sensor, further) if further else sensor}


def add_faults(run: Assembly) -> dict[str, Any]:
    """Faults of the sensors."""
    return {"sensor": with_faults(run.structure, run.values, run.sensor)}


def add_guard(run: Assembly) -> dict[str, Any]:
    """Guard of the measurements around the whole controller."""
    return {"controller": guarded(run.structure, run.values, run.controller, run.sensor, run.start)}


def add_metrics(run: Assembly) -> dict[str, Any]:
    """User-defined metrics, and instruments whose angles a metric evaluates."""
    context = context_of(run, "orbit")
    metrics, keep_outs = (
        named_parts(run.structure, run.values, section, context) for section in ("metric", KEEP_OUT)
    )
    return {"metrics": metrics, "keep_outs": tuple(keep_outs.values())}
