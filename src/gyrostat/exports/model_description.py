"""modelDescription.xml of a co-simulation unit (FMI 2.0)."""

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from gyrostat.codegen.program import Kind
from gyrostat.exports.target import Target
from gyrostat.exports.unit_text import base_exponents


@dataclass(frozen=True)
class Variable:
    """Scalar variable of the unit.

    Attributes:
        name: C expression in the values, without the place in arrays.
        kind: "real", "integer" or "logical".
        role: "parameter", "input", "output" or "local".
        meaning: Description.
        unit: SI unit, or "".
        exact: Whether its start value is given by the user (initial = "exact").
        tunable: Whether changes of its value after initialisation have an effect.
        reference: Value reference among the variables of its kind.
        start: Start value.
    """

    name: str
    kind: Kind
    role: str
    exact: bool
    tunable: bool
    meaning: str
    unit: str
    reference: int
    start: float


def model_description(target: Target, variables: list[Variable], guid: str) -> str:
    """Text of modelDescription.xml.

    Args:
        target: Flight module of the unit.
        variables: All variables, in order.
        guid: GUID of the unit.
    """
    root = ElementTree.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=target.name,
        guid=guid,
        description=target.title,
        generationTool="gyrostat",
        variableNamingConvention="structured",
    )
    simulation = ElementTree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=target.name,
        canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
    )
    files = ElementTree.SubElement(simulation, "SourceFiles")
    for file in (f"{target.name}.c", f"{target.name}_fmi2.c"):
        ElementTree.SubElement(files, "File", name=file)
    units = sorted({variable.unit for variable in variables} - {""})
    if units:
        definitions = ElementTree.SubElement(root, "UnitDefinitions")
        for unit in units:
            base = {name: str(power) for name, power in base_exponents(unit).items()}
            definition = ElementTree.SubElement(definitions, "Unit", name=unit)
            ElementTree.SubElement(definition, "BaseUnit", base)
    ElementTree.SubElement(
        root, "DefaultExperiment", startTime="0", stepSize=repr(float(target.period))
    )
    model_variables = ElementTree.SubElement(root, "ModelVariables")
    outputs = []
    for index, variable in enumerate(variables, start=1):
        outputs += [index] if variable.role == "output" else []
        _describe(model_variables, variable)
    structure = ElementTree.SubElement(root, "ModelStructure")
    unknown = [k for k in outputs if not variables[k - 1].exact]
    for tag, indices in (("Outputs", outputs), ("InitialUnknowns", unknown)):
        if indices:
            every = ElementTree.SubElement(structure, tag)
            for index in indices:
                ElementTree.SubElement(every, "Unknown", index=str(index))
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _describe(parent: ElementTree.Element, variable: Variable) -> None:
    about = {"name": variable.name, "valueReference": str(variable.reference)}
    if variable.meaning:
        about["description"] = variable.meaning
    about["causality"] = variable.role
    about["variability"] = "continuous" if variable.kind == "real" else "discrete"
    if variable.role == "parameter":
        about["variability"] = "tunable" if variable.tunable else "fixed"
    if variable.role != "input":
        about["initial"] = "exact" if variable.exact else "calculated"
    element = ElementTree.SubElement(parent, "ScalarVariable", about)
    content = {}
    if variable.kind == "real" and variable.unit:
        content["unit"] = variable.unit
    tag, text = _TYPES[variable.kind]
    if variable.exact:
        content["start"] = text(variable.start)
    ElementTree.SubElement(element, tag, content)


def _number(value: float) -> str:
    """Number in XML; infinity as the largest double, because FMI 2.0 has no infinity."""
    return repr(float(np.clip(value, -sys.float_info.max, sys.float_info.max)))


_TYPES: Mapping[str, tuple[str, Callable[[float], str]]] = {
    "real": ("Real", _number),
    "integer": ("Integer", lambda value: str(int(value))),
    "logical": ("Boolean", lambda value: str(bool(value)).lower()),
}
"""Kind of number -> its type in FMI and the text of a value."""
