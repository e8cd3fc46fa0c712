"""Proof that no run-time error can occur, by Frama-C's EVA."""

from collections.abc import Iterator, Mapping
from typing import ClassVar

from gyrostat.codegen.flight.expressions import HELPERS, Dialect
from gyrostat.codegen.flight.header import prototype
from gyrostat.codegen.flight.module import Entry, Port, call, ports_of
from gyrostat.codegen.flight.structs import Leaf, scalars
from gyrostat.codegen.flight.tested_sums import TESTED_ADD
from gyrostat.exports.check_program import definition
from gyrostat.exports.evidence.evidence_kind import EvidenceKind, Subject
from gyrostat.exports.template import filled

_ANY = {"real": "any_real()", "integer": "any_integer()", "logical": "any_logical()"}


class RunTimeErrors(EvidenceKind):
    """No run-time error for any input, and finite results, by abstract interpretation.

    The analysed program calls the module as its README says: parameters and constants as exported,
    then steps in an endless loop, with any bits in every input. EVA follows intervals of all values
    through the C code, functions of the C library by Frama-C's specifications. An alarm is a
    possible overflow of integers, access outside an object, division by zero, invalid shift or
    conversion, or use of a value that was not set.
    """

    name = "run_time_errors"
    title = "no run-time errors and finite results for any input, proven (Frama-C EVA)"
    tools: ClassVar[Mapping[str, str]] = {"frama_c": "frama-c"}

    @classmethod
    def script(cls, subject: Subject) -> str:
        """See `EvidenceKind.script`."""
        plus = HELPERS[TESTED_ADD]
        # an option for a function that is not there is an error
        options = f" -eva-slevel-function {plus}:100" if f"{plus}(" in subject.module.source else ""
        return filled("evidence/run_time_errors.sh", options=options)

    @classmethod
    def files(cls, subject: Subject) -> dict[str, str]:
        """See `EvidenceKind.files`."""
        target, module, dialect = subject.target, subject.module, Dialect(subject.precision)
        ports = ports_of(module)
        contracts = []
        if target.on_bad is not None:
            contracts = [
                _contract(e, module.ports[e.name], dialect, target.untested) for e in target.steps
            ]
        inputs = [f"{place} = {_ANY[kind]};" for place, kind in _inputs(subject, ports)]

        def calls(entries: tuple[Entry, ...], indent: str) -> str:
            return "\n".join(f"{indent}(void){call(module, entry.name)};" for entry in entries)

        text = filled(
            "evidence/run_time_errors.c",
            name=module.name,
            real=subject.precision,
            bits={"double": "uint64_t", "float": "uint32_t"}[subject.precision],
            contracts="\n".join(contracts),
            declared="\n".join(f"    {definition(p, target, dialect)}" for p in ports.values()),
            begin=calls(target.begin, "    "),
            inputs="\n".join(f"        {line}" for line in inputs),
            steps=calls(target.steps, "        "),
        )
        return {"run_time_errors.c": text}


def _inputs(subject: Subject, ports: Mapping[str, Port]) -> Iterator[tuple[str, str]]:
    """Expression and kind of each number of the variable arguments."""
    for name in subject.target.inputs:
        for array in scalars(ports[name].content, name, pointer=False):
            for number in array.flat:
                yield number.hint, number.kind


def _contract(
    entry: Entry, ports: tuple[Port, ...], dialect: Dialect, untested: tuple[str, ...]
) -> str:
    """Contract of a step: the real numbers that it sets are finite."""
    clauses = []
    for port in ports:
        if port.set:
            is_number = isinstance(port.content, Leaf) and not port.content.shape
            place = f"(*{port.name})" if is_number else port.name
            for number in (each for a in scalars(port.content, place) for each in a.flat):
                name = number.hint.strip("(*)").replace("->", ".")
                if number.kind == "real" and name not in untested:
                    clauses.append(f"    ensures \\is_finite({number.hint});")
    lines = ["/*@", *clauses, "*/"] if clauses else []
    return "\n".join([*lines, prototype(entry.name, ports, dialect) + ";", ""])
