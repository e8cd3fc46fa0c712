"""Build the plant, controller, sensor and initial state of a run from a scenario."""

from typing import Any, NamedTuple

from jaxtyping import Array, Float

from gyrostat.control.guidance import Reference
from gyrostat.core.jax64 import jnp
from gyrostat.runs import build_control, build_plant
from gyrostat.runs.assembly import Assembly, Stage
from gyrostat.runs.designs import Plans
from gyrostat.scenario.metrics.budget import Budget
from gyrostat.scenario.sensing import Values
from gyrostat.scenario.structure import Structure
from gyrostat.spacecraft.sensors.keep_out import KeepOut

STAGES: tuple[Stage, ...] = (
    build_control.choose_law,  # a limit of the controller can be one of the body
    build_plant.add_orbit,
    build_plant.add_body,  # its torques and actuators are evaluated along the orbit
    build_plant.add_motion,
    build_plant.add_of_controller,  # from here each wraps the plant before it: mechanics first,
    build_plant.add_imbalance,
    build_plant.add_drivers,  # then what turns a command into motor torques,
    build_plant.add_changes,  # then what changes any of this
    build_plant.add_start,  # the state has a field for each of these
    build_control.add_controller,  # designed for the momentum at the start
    build_control.add_reference,  # its slews depend on that momentum and on the phases
    build_control.follow_reference,  # from here each wraps the controller before it
    build_control.add_compensator,  # adds to motor torques
    build_control.add_unloading,  # of the wheels, with the torques that are commanded in the end
    build_control.add_estimator,  # all before it use its estimates
    build_control.add_sensors,  # of the whole plant
    build_control.add_faults,  # of any sensor
    build_control.add_guard,  # nothing sees a measurement before it, faults included
    build_control.add_metrics,
)
"""Stages of building a run, in the order in which each needs those before it."""


class Setup(NamedTuple):
    """Parts of one run.

    Attributes:
        plant: Spacecraft with the values of the run.
        controller: Controller, planned for the nominal spacecraft.
        sensor: Sensor of the plant.
        start: State of the plant at time 0.
        starts: Start times of the phases, (phases,), s.
        targets: Target attitude of each phase, (phases, 4), scalar first.
        metrics: User-defined metrics by name.
        reference: Reference attitude at the true position; None for the targets of the phases.
        budget: Momentum budget; None unless it is requested.
        keep_outs: Instruments that keep angles to bright bodies.
    """

    plant: Any
    controller: Any
    sensor: Any
    start: Any
    starts: Float[Array, " phases"]
    targets: Float[Array, "phases 4"]
    metrics: dict[str, Any]
    reference: Reference | None = None
    budget: Budget | None = None
    keep_outs: tuple[KeepOut, ...] = ()


def build(structure: Structure, values: Values, plans: Plans) -> Setup:
    """Build the parts of a run from its values; pure, for `jit` and `vmap` over the values."""
    run = Assembly(structure, values, plans)
    for stage in STAGES:
        run = run._replace(**stage(run))
    targets = jnp.asarray(plans.targets)
    loop = run.plant, run.controller, run.sensor, run.start
    metrics = dict(run.metrics)
    of_orbit = run.reference, run.budget, run.keep_outs
    return Setup(*loop, run.starts, targets, metrics, *of_orbit)
