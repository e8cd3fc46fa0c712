"""README of a cFS application, with its interface control document."""

from collections.abc import Iterable, Mapping, Sequence

from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.control import SampleStatus
from gyrostat.exports.cfs import interface
from gyrostat.exports.cfs.interface import Named
from gyrostat.exports.cfs.messages import Payload
from gyrostat.exports.cfs.parameters import FACTOR, Parameter
from gyrostat.exports.message_fields import Field
from gyrostat.exports.target import SAFE, Target
from gyrostat.exports.template import filled
from gyrostat.exports.unit_text import unit_of

Row = Sequence[object]
STACK = 16384
"""Smallest stack that the README names, bytes."""


def readme(
    target: Target,
    names: Mapping[str, str],
    payloads: Mapping[str, Payload],
    parameters: Sequence[Parameter],
    origin: str,
    dialect: Dialect,
) -> str:
    """Text of README.md.

    Args:
        target: Flight module.
        names: Names of the application in its templates.
        payloads: Payloads of the messages "measurement" and "command".
        parameters: Parameters of the table.
        origin: Origin of the parameters.
        dialect: C of the module.
    """
    prefix, sensor, command = names["APP"], payloads["measurement"], payloads["command"]
    sizes = {"real": 8 if dialect.real == "double" else 4, "integer": 8, "logical": 1}
    assert target.on_bad is not None
    return filled(
        "cfs/README.md.txt",
        **names,
        origin=origin,
        stack=STACK,
        period=f"{target.period:g}",
        safe=SAFE[target.on_bad],
        factor=f"{FACTOR:g}",
        ids=_rows((f"`{prefix}_{n.name}`", n.value[:-1], n.meaning) for n in interface.IDS),
        sensor_size=sensor.size,
        command_size=command.size,
        sensor_table=_layout(sensor, interface.SENSOR_HEAD),
        command_table=_layout(command, interface.COMMAND_HEAD),
        housekeeping_table=_housekeeping(),
        command_list=_named(interface.COMMANDS, prefix, "code"),
        events=_events(prefix),
        table_size=f"{sum(p.value.size * sizes[p.leaf.kind] for p in parameters)} bytes of numbers",
        parameters=_parameters(parameters),
        settings=_named(interface.settings(target.period), prefix, "value"),
    )


def _table(head: Row, rows: Iterable[Row]) -> str:
    line = f"|{'---|' * len(head)}"
    return "\n".join([f"| {' | '.join(map(str, head))} |", line, _rows(rows)])


def _rows(rows: Iterable[Row]) -> str:
    return "\n".join(f"| {' | '.join(str(cell) for cell in row)} |" for row in rows)


def _named(constants: Iterable[Named], prefix: str, head: str) -> str:
    rows = ((f"`{prefix}_{n.name}`", n.value, n.meaning) for n in constants)
    return _table(("name", head, "meaning"), rows)


def _layout(payload: Payload, head: Sequence[Field]) -> str:
    rows = [_row(field, payload.real) for field in (*head, *payload.fields)]
    if payload.spare:
        offset = payload.crc - payload.spare
        rows.append(("`Spare`", f"`uint8[{payload.spare}]`", "", offset, "zero"))
    rows.append(("`Crc`", "`uint32`", "", payload.crc, "CRC of the bytes before it"))
    rows.append(("`Reserved`", "`uint32`", "", payload.crc + 4, "zero"))
    return _table(("field", "type", "unit", "offset", "meaning"), rows)


def _row(field: Field, real: str) -> Row:
    kind = f"`{field.kind_in_c(real)}{field.brackets}`"
    return f"`{field.name}`", kind, field.unit, field.offset, _cell(field.meaning)


def _cell(meaning: str) -> str:
    """Description for a table; that of a field without one is its unit, which has a column."""
    return "" if meaning and meaning == unit_of(meaning) else meaning.replace("|", "\\|")


def _housekeeping() -> str:
    statuses = len(SampleStatus)
    counts = f"`{interface.STATUSES}[{statuses}]`", "valid sensor messages by `SampleStatus`"
    rows: list[Row] = [(f"`{n.name}`", n.meaning) for n in interface.COUNTERS]
    rows += [counts, *((f"`{n.name}`", n.meaning) for n in interface.STATE)]
    sizes = [1] * len(interface.COUNTERS) + [statuses] + [1] * len(interface.STATE)
    offsets = [4 * sum(sizes[:k]) for k in range(len(sizes))]
    placed = ((name, offset, what) for (name, what), offset in zip(rows, offsets, strict=True))
    return _table(("field", "offset", "meaning"), placed)


def _events(prefix: str) -> str:
    rows = [
        (f"`{prefix}_{n.name}`", n.value, "no" if n in interface.EVENTS else "yes", n.meaning)
        for n in interface.ALL_EVENTS
    ]
    return _table(("event", "id", "filtered", "meaning"), rows)


def _parameters(parameters: Sequence[Parameter]) -> str:
    rows = []
    for p in parameters:
        shape = "".join(f"[{n}]" for n in p.leaf.shape)
        designed = f"{p.value.item():g}" if not p.leaf.shape else ""
        numbers = (designed, f"{p.lower:g}", f"{p.upper:g}")
        rows.append((f"`{p.name}{shape}`", *numbers, unit_of(p.meaning), _cell(p.meaning)))
    return _table(("parameter", "designed", "lower", "upper", "unit", "meaning"), rows)
