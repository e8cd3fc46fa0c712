"""Build the further parts of a scenario: lists of parts and modes of appendages."""

from typing import Any

from gyrostat.core.user_modules import is_own
from gyrostat.scenario.kinds.registry import OF_SPACECRAFT, component
from gyrostat.scenario.sensing import Values, arrays_of, options_of
from gyrostat.scenario.structure import Structure
from gyrostat.spacecraft import FlexibleModes, Spacecraft


def named_parts(structure: Structure, values: Values, section: str, **given: Any) -> dict[str, Any]:
    """Build the parts of a list: name -> part.

    Args:
        structure: Structure of the scenario.
        values: Values of this run.
        section: Section of the parts.
        given: Values of reserved fields of user-defined parts. Parts of this package also get the
            control period, `period`, s.
    """
    found = {}
    for part in structure.parts:
        if part.section == section:
            place = f"{section}.{part.name}"
            made = component(section, part.kind, structure.sources)
            own = {} if is_own(part.kind) else {"period": values["run.control_period"]}
            options = arrays_of(values, place, made.keys)
            found[part.name] = made.make(options, place=place, **given, **own)
    return found


def modes_of_run(
    structure: Structure, values: Values, spacecraft: Spacecraft
) -> FlexibleModes | None:
    """Modes of the appendages of the spacecraft; None if there are none.

    Args:
        structure: Structure of the scenario.
        values: Values of this run.
        spacecraft: Spacecraft of this run.
    """
    made = [
        component(part.section, part.kind).make(
            part.kind, options_of(values, f"{part.section}.{part.name}"), spacecraft
        )
        for part in structure.parts
        if part.section in OF_SPACECRAFT
    ]
    return FlexibleModes.joined(*made) if made else None
