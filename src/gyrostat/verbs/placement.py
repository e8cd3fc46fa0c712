"""Verb `place`: directions of star tracker heads, a radiator and a solar panel in body axes."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Quantity, Say, direction, in_si, numbers, silent
from gyrostat.verbs.scenario_check import scenario_of

if TYPE_CHECKING:
    from gyrostat.runs.placement import Blocked, Exclusion
    from gyrostat.runs.placement_result import Placement
    from gyrostat.runs.reference_path import ReferencePath
    from gyrostat.scenario import Scenario
    from gyrostat.spacecraft.sensors.star_tracker_heads import StarTrackerHead

MOST_HEADS = 3
WHOLE = "run"
"""Name of the whole run among the windows; no window has it."""
ANGLES = {"sun": "sun_exclusion", "earth": "earth_exclusion", "moon": "moon_exclusion"}
"""Option -> attribute of a head that it replaces."""


def place(
    scenario: "Scenario | str | Path",
    out: "str | Path | None" = None,
    *,
    heads: int = 2,
    sun: Quantity | None = None,
    earth: Quantity | None = None,
    moon: Quantity | None = None,
    rate: Quantity | None = None,
    apart: Quantity = "60 deg",
    blocked: Iterable[str] | str | None = None,
    window: Iterable[str] | str | None = None,
    absorptance: float = 0.1,
    emittance: float = 0.85,
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.place",
) -> "Placement":
    """Find where star tracker heads, a radiator and a solar panel see best, in body axes.

    The attitude is that of the reference; where a mode of the reference waits for a measured
    quantity, it is that of the simulated nominal run.

    Args:
        scenario: Scenario with an orbit, or path of scenario.toml.
        out: Folder for place.json and report.html; None writes no file.
        heads: Largest number of star tracker heads, 1 to 3; the best directions are found for each
            number.
        sun: Least angle between boresight and Sun, rad; None: that of the first head of the
            scenario.
        earth: Least angle between boresight and limb of the Earth, rad; None: likewise.
        moon: Least angle between boresight and Moon, rad; None: likewise, or 0.
        rate: Largest body rate at which a head sees, rad/s; None: likewise, or no limit.
        apart: Least angle between two heads, rad: two near each other leave the rotation about
            their boresights uncertain.
        blocked: Directions that the body blocks: "DIRECTION:HALF_ANGLE", such as "-z:30deg" or
            "1,0,1:20deg".
        window: Windows of the metrics whose time counts, or "run" for the whole run; None: the
            windows of the scenario, or the whole run if there are none.
        absorptance: Absorptance of the radiator for sunlight.
        emittance: Emittance of the radiator in the infrared.
        force: Whether to replace files that gyrostat did not write, and to take wheels that are
            marked as impossible.
        say: Function that receives each message for the user.
        command: Text that the report names as its origin.

    Returns:
        Directions, with the fraction of time in which heads see there.

    Raises:
        InputError: The scenario has no orbit, an option cannot be used, the reference enters none
            of the windows, the body is in the way of all directions, or existing files would be
            replaced.
    """
    import numpy as np

    from gyrostat.core.outputs import check_outputs
    from gyrostat.reports.placement import FILES, write_placement
    from gyrostat.runs.body_sky import body_sky
    from gyrostat.runs.placement import evaluated, place_heads
    from gyrostat.runs.placement_result import Placement
    from gyrostat.runs.reference_path import nominal_setup, waits_for_measurement
    from gyrostat.runs.surface_placement import place_panel, place_radiator
    from gyrostat.runs.tracker_forecast import heads_of_run
    from gyrostat.scenario.kinds.orbits import orbit_with_moon

    if out is not None:
        check_outputs(Path(out), FILES, by="place", force=force)
    if heads not in range(1, MOST_HEADS + 1):
        raise InputError(f"--heads: found {heads}, expected 1 to {MOST_HEADS}")
    for name, value in (("--absorptance", absorptance), ("--emittance", emittance)):
        if not 0.0 <= value <= 1.0:
            raise InputError(f"{name}: found {value:g}, expected 0 to 1")
    cones = _cones(blocked)
    distance = in_si(apart, "angle", "--apart")
    if not 0.0 <= distance <= 0.5 * np.pi:
        raise InputError(f"--apart: found {np.degrees(distance):g} deg, expected 0 to 90 deg")
    definition = scenario_of(scenario, force=force)
    orbit = orbit_with_moon(definition)
    if orbit is None:
        raise InputError(f"{definition.name}: found no section [orbit], expected one")
    setup = nominal_setup(definition)
    present, angles = heads_of_run(setup), {"sun": sun, "earth": earth, "moon": moon}
    exclusion = _exclusion(angles, rate, present[0] if present else None)
    path, source = _path(definition, waits_for_measurement(setup), say)
    chosen, counts = _counting(path, window, definition)
    sky = body_sky(orbit, path.time, path.attitude, path.rate)
    counted = sky.at(counts)
    best = []
    for number in range(1, heads + 1):
        found = place_heads(counted, exclusion, number, apart=distance, blocked=cones)
        if found is None:
            raise InputError(
                f"--blocked, --apart: found no directions for {number} heads, expected some that "
                "the body does not block"
            )
        best.append(found)
    unit = [np.asarray(head.boresight, dtype=float) for head in present]
    now = None
    if unit:
        directions = np.array([each / np.linalg.norm(each) for each in unit])
        now = evaluated(counted, directions, [_exclusion(angles, rate, each) for each in present])
    radiator = place_radiator(counted, absorptance, emittance, cones)
    panel = place_panel(counted, cones)
    result = Placement(
        definition.name,
        source,
        chosen,
        exclusion,
        distance,
        tuple(cones),
        tuple(best),
        now,
        radiator,
        panel,
        counted,
        path.step,
    )
    if out is not None:
        write_placement(result, Path(out), command=command, say=say, force=force)
    return result


def _path(definition: "Scenario", waits: bool, say: Say) -> "tuple[ReferencePath, str]":
    """Attitude over time, and what it is."""
    from gyrostat.runs.reference_path import flown_path, reference_path

    if not waits:
        return reference_path(definition), "the reference"
    from gyrostat.campaigns.engine import fly_nominal
    from gyrostat.campaigns.execute import chosen_engine
    from gyrostat.core.engines import engine_named

    say("a mode of the reference waits for a measured quantity: simulating the nominal run")
    engine = chosen_engine(engine_named("auto", say, "--engine"), definition, "cpu", say)
    return flown_path(definition, fly_nominal(definition, 0, engine)), "the nominal run"


def _exclusion(
    angles: dict[str, Any], rate: Quantity | None, head: "StarTrackerHead | None"
) -> "Exclusion":
    """What blinds a head: the options, then those of a head of the scenario."""
    import numpy as np

    from gyrostat.runs.placement import Exclusion

    found: dict[str, float] = {}
    for name, value in angles.items():
        if value is not None:
            found[name] = in_si(value, "angle", f"--{name}")
        elif head is not None:
            found[name] = float(getattr(head, ANGLES[name]))
        elif name == "moon":
            found[name] = 0.0
        else:
            raise InputError(
                f"--{name}: found none and no [[star_tracker]] in the scenario, expected the "
                f"{name} exclusion angle of a head, such as --{name} 30deg"
            )
        if not 0.0 <= found[name] < np.pi:
            raise InputError(
                f"--{name}: found {np.degrees(found[name]):g} deg, expected 0 to less than 180 deg"
            )
    if rate is not None:
        found["rate"] = in_si(rate, "speed", "--rate")
        if found["rate"] <= 0.0:
            raise InputError(f"--rate: found {found['rate']:g} rad/s, expected more than 0")
    elif head is not None:
        found["rate"] = float(head.rate_limit)
    return Exclusion(**found)


def _cones(blocked: Iterable[str] | str | None) -> "list[Blocked]":
    """Cones of directions that the body blocks."""
    import numpy as np

    from gyrostat.runs.placement import Blocked

    cones = []
    for text in [blocked] if isinstance(blocked, str) else list(blocked or ()):
        middle, colon, angle = text.rpartition(":")
        if not colon:
            raise InputError(
                f"--blocked: found {text!r}, expected DIRECTION:HALF_ANGLE, such as -z:30deg"
            )
        half = float(numbers([angle], 1, "angle", "--blocked")[0])
        if not 0.0 < half < np.pi:
            raise InputError(
                f"--blocked: found the half angle {np.degrees(half):g} deg, expected one between 0 "
                "and 180 deg"
            )
        cones.append(Blocked(direction(middle, "--blocked"), half))
    return cones


def _counting(
    path: "ReferencePath", windows: Iterable[str] | str | None, definition: "Scenario"
) -> tuple[tuple[str, ...], Any]:
    """Names of the windows that count, and whether each row of the path does."""
    import numpy as np

    given = [windows] if isinstance(windows, str) else list(windows or path.windows)
    for name in given:
        if name not in (*path.windows, WHOLE):
            known = ", ".join((*path.windows, WHOLE))
            raise InputError(f"--window: found {name!r}, expected one of {known}")
    if not given or WHOLE in given:
        return (), np.ones(len(path.time), bool)
    counts = np.any([path.windows[name] for name in given], axis=0)
    if not np.any(counts):
        raise InputError(
            f"{definition.name}: found no time in the windows {', '.join(given)}, expected some"
        )
    return tuple(given), counts
