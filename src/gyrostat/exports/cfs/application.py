"""Files of an application for the core Flight System (cFS)."""

import re
import textwrap
from collections.abc import Iterable, Mapping

from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.flight.header import declaration
from gyrostat.codegen.flight.identifiers import comment
from gyrostat.codegen.flight.module import Module, Port, Precision, call, ports_of
from gyrostat.codegen.program import Number
from gyrostat.control import SampleStatus
from gyrostat.core.errors import InputError
from gyrostat.exports.cfs import interface
from gyrostat.exports.cfs.interface import Named
from gyrostat.exports.cfs.messages import Payload, read_lines, written_lines
from gyrostat.exports.cfs.parameters import (
    Parameter,
    check_lines,
    initial_values,
    parameters_of,
)
from gyrostat.exports.cfs.readme import readme
from gyrostat.exports.folder import Search, emitted, files_of
from gyrostat.exports.message_fields import missing_lines
from gyrostat.exports.target import Target, require_controller
from gyrostat.exports.template import filled

HEADS = {"measurement": interface.SENSOR_HEAD, "command": interface.COMMAND_HEAD}
"""Argument of the step -> fields before it in its message."""
LONGEST_NAME = 14
"""Longest name of an application: its entry point NAME_Main has 19 characters in cFE."""


def application(
    target: Target, precision: Precision, origin: str, search: Search | None = None
) -> dict[str, str]:
    """Files of a cFS application that runs a controller.

    Args:
        target: Flight module of a controller with validated measurements.
        precision: Precision of real numbers.
        origin: Origin of the parameters, for the README.
        search: Search for test vectors; None for those of the test run.

    Returns:
        File name relative to the folder apps of a mission -> text.

    Raises:
        InputError: The module has no controller, or a name that is too long for cFE or one of its
            own, or it cannot be emitted; see `emit`.
    """
    require_controller(target, "cfs")
    if len(target.name) > LONGEST_NAME:
        raise InputError(
            f"--to cfs: found the name {target.name}, expected at most {LONGEST_NAME} characters"
        )
    if target.name.startswith("cfe"):
        raise InputError(f"--to cfs: found the name {target.name}, which is one of cFE's own")
    module = emitted(target, precision)
    ports = ports_of(module)
    dialect, app = Dialect(precision), target.name
    payloads = {
        name: Payload.of(ports[name].content, name, head, dialect.real)
        for name, head in HEADS.items()
    }
    values = target.designed()
    table = {port.name: port for port in module.ports[target.begin[0].name]}
    parameters = parameters_of(table, values)
    names = {"app": app, "APP": app.upper(), "title": _one_line(target.title)}
    names["real"] = dialect.real

    def text(template: str, **further: object) -> str:
        # a text that fills a gap can have gaps of the names too
        return _with_names(filled(f"cfs/{template}", **further, **names), names)

    texts = {
        "CMakeLists.txt": text("CMakeLists.txt"),
        "README.md": readme(target, names, payloads, parameters, origin, dialect),
        "fsw/mission_inc/@app@_msgids.h": text("msgids.h", ids=_guarded(interface.IDS)),
        "fsw/mission_inc/@app@_cfg.h": text(
            "cfg.h", settings=_guarded(interface.settings(target.period))
        ),
        "fsw/mission_inc/@app@_events.h": text("events.h", events=_defined(interface.ALL_EVENTS)),
        "fsw/mission_inc/@app@_msg.h": text("msg.h", **_messages(payloads)),
        "fsw/mission_inc/@app@_tbl.h": text("tbl.h", members=_declared(table, dialect)),
        "fsw/src/@app@_app.h": text("app.h", values=_declared(ports, dialect)),
        "fsw/src/@app@_app.c": text("app.c", **_main(target, module, ports, payloads, dialect)),
        "fsw/src/@app@_input.c": text("input.c", **_inputs(payloads, dialect)),
        "fsw/src/@app@_table.c": text("table.c", **_table(table, parameters, dialect)),
        "fsw/tables/@app@.c": text("tables.c", values=initial_values(table, values, dialect)),
    }
    flight = files_of(target, module, precision, origin, search)
    return {f"{app}/{name.replace('@app@', app)}": content for name, content in texts.items()} | {
        f"{app}/flight/{name}": content for name, content in flight.items()
    }


def _one_line(title: str) -> str:
    """Title for comments in C and CMake."""
    return comment(" ".join(title.split()))


def _with_names(text: str, names: Mapping[str, str]) -> str:
    return re.sub(r"@(\w+)@", lambda gap: names.get(gap[1], gap[0]), text)


def _guarded(constants: Iterable[Named]) -> str:
    """Definitions that the build of a mission can replace."""
    lines = []
    for each in constants:
        name = f"@APP@_{each.name}"
        lines += [f"/* {each.meaning} */", f"#ifndef {name}", f"#define {name} {each.value}"]
        lines += ["#endif", ""]
    return "\n".join(lines)


def _defined(constants: Iterable[Named]) -> str:
    return "\n".join(
        f"#define @APP@_{each.name} {each.value}U /* {each.meaning} */" for each in constants
    )


def _declared(ports: Mapping[str, Port], dialect: Dialect) -> str:
    """Members of a struct for arguments of the flight module."""
    return "\n".join(
        f"    {declaration(port.content, port.name, dialect)};" for port in ports.values()
    )


def _indented(lines: Iterable[str], depth: int) -> str:
    return "\n".join(f"{'    ' * depth}{line}" for line in lines)


def _messages(payloads: Mapping[str, Payload]) -> dict[str, object]:
    """Texts of the header of the messages."""
    sensor, command = payloads["measurement"], payloads["command"]
    statuses = f"    uint32 {interface.STATUSES}[@APP@_SAMPLE_STATUSES]; /* {_STATUSES} */"
    rows = [f"    uint32 {c.name}; /* {c.meaning} */" for c in interface.COUNTERS]
    rows += [statuses, *(f"    uint32 {c.name}; /* {c.meaning} */" for c in interface.STATE)]
    return {
        "codes": _defined(interface.COMMANDS),
        "sensor_fields": sensor.declarations(),
        "command_fields": command.declarations(),
        "housekeeping": "\n".join(rows),
        "statuses": f"#define @APP@_SAMPLE_STATUSES {len(SampleStatus)}U",
        "sensor_size": sensor.size,
        "sensor_crc": sensor.crc,
        "command_size": command.size,
        "command_crc": command.crc,
    }


_STATUSES = "valid sensor messages by SampleStatus"


def _main(
    target: Target,
    module: Module,
    ports: Mapping[str, Port],
    payloads: Mapping[str, Payload],
    dialect: Dialect,
) -> dict[str, object]:
    """Texts of the main file."""
    place = "@APP@_Data.Values."
    begin, start = target.begin[:2]
    held = "memcpy(&@APP@_Data.Values.command, &LastCommand, sizeof(LastCommand))"
    zero = "memset(&@APP@_Data.Values.command, 0, sizeof(LastCommand))"
    constants = (
        f"{place}{name} = {dialect.number(Number('real', float(value))).text};"
        for name, value in target.constants.items()
        if name in ports
    )
    outputs = written_lines(payloads["command"].fields, "Payload", f"{place}command")
    filters = (f"{{@APP@_{each.name}, @APP@_EVENT_MASK}}," for each in interface.FILTERED)
    return {
        "constants": _indented(constants, 1),
        **{
            word: _statement(f"Fault = {call(module, entry.name, place)};")
            for word, entry in (("parameters", begin), ("start", start), ("step", target.steps[0]))
        },
        "safe": f"(void){held if target.on_bad == 'hold' else zero};",
        "last_memory": declaration(ports["memory"].content, "LastMemory", dialect),
        "last_command": declaration(ports["command"].content, "LastCommand", dialect),
        "outputs": _indented(outputs, 1),
        "filters": _indented(filters, 2),
    }


def _inputs(payloads: Mapping[str, Payload], dialect: Dialect) -> dict[str, object]:
    """Texts of the file of the received messages."""
    fields, struct = payloads["measurement"].fields, "@APP@_Data.Values.measurement"
    missing = missing_lines(fields, struct)
    has_array = any(line.startswith("SetNotANumber") for line in missing)
    return {
        "inputs": _indented(read_lines(fields, "Payload", struct), 2),
        "missing": _indented(missing, 1),
        "fill": filled("cfs/fill.c", real=dialect.real) if has_array else "",
    }


def _table(
    table: Mapping[str, Port], parameters: list[Parameter], dialect: Dialect
) -> dict[str, object]:
    """Texts of the file of the table."""
    lines = check_lines(parameters, dialect)
    _, *helpers = filled("cfs/table_helpers.c", real=dialect.real).split("\n\n/* ")
    used = [f"/* {text.rstrip()}" for text in helpers if _name_of(text) in "\n".join(lines)]
    return {
        "ranges": "\n".join(lines),
        "helpers": "".join(f"\n{text}\n" for text in used),
        "adopted": "\n".join(_copied(f"Values->{n}", f"Table->{n}", 1) for n in table),
        "designed": "\n".join(_copied(f"Table->{n}", f"Values->{n}", 3) for n in table),
    }


def _statement(text: str) -> str:
    """Statement of a function, wrapped if it is long."""
    return textwrap.fill(text, 110, initial_indent="    ", subsequent_indent="        ")


def _copied(target: str, source: str, depth: int) -> str:
    return f"{'    ' * depth}(void)memcpy(&{target}, &{source}, sizeof({target}));"


def _name_of(helper: str) -> str:
    match = re.search(r"^static const char \*(\w+)", helper, re.MULTILINE)
    assert match is not None
    return f" {match[1]}("
