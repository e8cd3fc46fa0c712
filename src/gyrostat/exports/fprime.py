"""Component for F Prime around a flight module: FPP model and C++."""

import textwrap
from collections.abc import Iterable, Sequence

from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.flight.header import declaration
from gyrostat.codegen.flight.identifiers import comment
from gyrostat.codegen.flight.module import Port, Precision, call, ports_of
from gyrostat.codegen.flight.structs import Struct
from gyrostat.codegen.program import Number
from gyrostat.control import SampleStatus
from gyrostat.exports.folder import Search, emitted, files_of
from gyrostat.exports.message_fields import Field, fields_of, missing_lines
from gyrostat.exports.target import SAFE, Target, require_controller
from gyrostat.exports.template import filled


def component(
    target: Target, precision: Precision, origin: str, search: Search | None = None
) -> dict[str, str]:
    """Files of an F Prime component that runs a controller.

    Args:
        target: Flight module of a controller with validated measurements.
        precision: Precision of real numbers.
        origin: Origin of the parameters, for the README.
        search: Search for test vectors; None for those of the test run.

    Returns:
        File name relative to the folder of the components of a project -> text.

    Raises:
        InputError: The module has no controller, or it cannot be emitted; see `emit`.
    """
    require_controller(target, "fprime")
    module = emitted(target, precision)
    ports = ports_of(module)
    name = "".join(word.capitalize() for word in target.name.split("_"))
    dialect = Dialect(precision)
    sensed, commanded = (
        list(fields_of(ports[n].content, n, set())) for n in ("measurement", "command")
    )
    missing = missing_lines(sensed, "this->m_measurement")
    begin, start = target.begin[:2]
    calls = {"parameters": (begin, 1), "start": (start, 1), "step": (target.steps[0], 2)}
    held = "memcpy(&this->m_command, &lastCommand, sizeof(lastCommand))"
    zero = "memset(&this->m_command, 0, sizeof(lastCommand))"
    texts = {
        **{
            word: _statement(f"fault |= {call(module, entry.name, 'this->m_')};", depth)
            for word, (entry, depth) in calls.items()
        },
        "name": target.name,
        "Name": name,
        "NAME": target.name.upper(),
        "title": comment(" ".join(target.title.split())),
        "period": f"{target.period:g}",
        "origin": origin,
        "safe": SAFE[target.on_bad or "hold"],
        "real": dialect.real,
        "statuses": _lines((f"{s.name} = {int(s)}" for s in SampleStatus), 2),
        "measurement": _lines(_members(sensed, dialect), 2),
        "command": _lines(_members(commanded, dialect), 2),
        "members": _lines(_variables(target, ports.values(), dialect), 2),
        "last_memory": f"    {_declared(ports['memory'], dialect, 'lastMemory')};",
        "last_command": f"    {_declared(ports['command'], dialect, 'lastCommand')};",
        "inputs": _lines(_inputs(sensed), 2),
        "outputs": _lines(_outputs(commanded, dialect), 2),
        "missing": _lines(missing, 2),
        "fill": "",
    }
    if any(line.startswith("SetNotANumber") for line in missing):
        texts["fill"] = filled("fprime/fill.cpp", real=dialect.real)
    code = texts | {"safe": f"(void)std::{held if target.on_bad == 'hold' else zero};"}
    files = {
        "CMakeLists.txt": filled("fprime/CMakeLists.txt", **texts),
        "README.md": filled("fprime/README.md.txt", **texts),
        f"{name}.fpp": filled("fprime/component.fpp", **texts),
        f"{name}.hpp": filled("fprime/component.hpp", **code),
        f"{name}.cpp": filled("fprime/component.cpp", **code),
    }
    flight = files_of(target, module, precision, origin, search)
    files |= {f"flight/{file}": text for file, text in flight.items()}
    return {f"{name}/{file}": text for file, text in files.items()}


def _lines(lines: Iterable[str], depth: int) -> str:
    return "\n".join(f"{'  ' * depth}{line}" for line in lines)


def _statement(text: str, depth: int) -> str:
    indent = "    " * depth
    return textwrap.fill(text, 110, initial_indent=indent, subsequent_indent=f"{indent}    ")


def _members(fields: Sequence[Field], dialect: Dialect) -> Iterable[str]:
    """Members of a struct in FPP; an array of several dimensions is one array of its numbers."""
    real = "F64" if dialect.real == "double" else "F32"
    kinds = {"real": real, "integer": "I64", "logical": "bool"}
    for field in fields:
        if field.meaning:
            yield f"@ {' '.join(field.meaning.split())}"
        size = f"[{field.count}] " if field.shape else ""
        yield f"${field.name}: {size}{kinds[field.kind]}"  # $: a name that may be a word of FPP


def _declared(port: Port, dialect: Dialect, name: str) -> str:
    scope = "::" if isinstance(port.content, Struct) else ""  # not a name of the component
    return scope + declaration(port.content, name, dialect)


def _variables(target: Target, ports: Iterable[Port], dialect: Dialect) -> Iterable[str]:
    """Member variables with the arguments of the flight module."""
    for port in ports:
        value = target.constants.get(port.name)
        initial = "{}"
        if value is not None:
            initial = f" = {dialect.number(Number('real', float(value))).text}"
        yield f"{_declared(port, dialect, f'm_{port.name}')}{initial};"


def _inputs(fields: Sequence[Field]) -> Iterable[str]:
    for field in fields:
        member = field.member("this->m_measurement")
        if field.shape:
            yield f"(void)std::memcpy(&{member}, sample.get_{field.name}(), sizeof({member}));"
        else:
            yield f"{member} = sample.get_{field.name}();"


def _outputs(fields: Sequence[Field], dialect: Dialect) -> Iterable[str]:
    for field in fields:
        member = field.member("this->m_command")
        if field.shape:
            yield f"(void)std::memcpy(value.get_{field.name}(), &{member}, sizeof({member}));"
        else:
            yield f"value.set_{field.name}({member});"
