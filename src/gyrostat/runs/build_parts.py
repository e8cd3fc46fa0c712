"""Build the further parts of a scenario: lists of parts and modes of appendages."""

from typing import Any

from gyrostat.core.errors import placed
from gyrostat.scenario.component import Context
from gyrostat.scenario.kinds.registry import APPENDAGES, component
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.sensing import Values, arrays_of, options_of
from gyrostat.scenario.structure import Structure
from gyrostat.spacecraft import FlexibleModes, Spacecraft


def named_kinds(structure: Structure, values: Values, section: str) -> dict[str, Any]:
    """Kinds of the parts of a list with their values: name -> kind.

    Args:
        structure: Structure of the scenario.
        values: Values of this run.
        section: Section of the parts.
    """
    kinds = {}
    for part in structure.parts:
        if part.section == section:
            kind = component(section, part.kind, structure.sources)
            kinds[part.name] = kind.of(arrays_of(values, f"{section}.{part.name}", kind.keys()))
    return kinds


def named_parts(
    structure: Structure, values: Values, section: str, context: Context
) -> dict[str, Any]:
    """Build the parts of a list: name -> part.

    Args:
        structure: Structure of the scenario.
        values: Values of this run.
        section: Section of the parts.
        context: What the parts are made with; their places and links are added.
    """
    links = {part.name: dict(part.links) for part in structure.parts if part.section == section}
    return {
        name: kind.make(context._replace(place=f"{section}.{name}", links=links[name]))
        for name, kind in named_kinds(structure, values, section).items()
    }


def tables_of(scenario: Scenario) -> dict[str, Any]:
    """Place of each metric with a file -> what is computed of the file once.

    Raises:
        InputError: The file does not fit the scenario.
    """
    kinds = {f"{part.section}.{part.name}": part for part in scenario.parts}
    tables = {}
    for text in scenario.texts:
        part = kinds.get(text.path)
        if part is not None and part.section == "metric":
            with placed(f"key {text.path}.file"):
                kind = component(part.section, part.kind, scenario.sources)
                tables[text.path] = kind.tabulated(scenario, text.text)
    return tables


def modes_of_run(
    structure: Structure, values: Values, spacecraft: Spacecraft
) -> FlexibleModes | None:
    """Modes of the appendages of the spacecraft; None if there are none.

    Args:
        structure: Structure of the scenario.
        values: Values of this run.
        spacecraft: Spacecraft of this run.
    """
    modes = [
        APPENDAGES[part.section].modes(
            options_of(values, f"{part.section}.{part.name}"), spacecraft
        )
        for part in structure.parts
        if part.section in APPENDAGES
    ]
    return FlexibleModes.joined(*modes) if modes else None
