"""Co-simulation unit (FMI 2.0) from an emitted module.

Modelica Association, "Functional Mock-up Interface for Model Exchange and Co-Simulation 2.0.4".
"""

import hashlib
import platform
import re
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from gyrostat.codegen.flight.c import emit
from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.flight.header import declaration
from gyrostat.codegen.flight.measure import FLAGS, compiler
from gyrostat.codegen.flight.module import Module, Port, call, ports_of
from gyrostat.codegen.flight.structs import Struct
from gyrostat.codegen.program import Kind, Number
from gyrostat.codegen.simd import run_compiler
from gyrostat.core.errors import InputError
from gyrostat.core.files import whole_file, write_texts
from gyrostat.core.jax64 import jax
from gyrostat.exports.message_fields import leaves
from gyrostat.exports.model_description import Variable, model_description
from gyrostat.exports.target import Target
from gyrostat.exports.template import filled
from gyrostat.exports.unit_text import unit_of

NONE = "    case 0xFFFFFFFF: return NULL;"
"""Cases of a kind of number that does not occur in a unit."""
SINCE = "duration"
"""Name of the argument that is the communication step; a module without it has its own period."""


def write_fmu(target: Target, path: Path) -> str | None:
    """Write a co-simulation unit: sources, description, and a binary if there is a compiler.

    Args:
        target: Flight module, which runs in each communication step.
        path: File to write, NAME.fmu.

    Returns:
        The platform of the binary; None if there is no binary.

    Raises:
        InputError: The module cannot be emitted, or the compiler fails.
    """
    name = target.name
    module = emit(name, target.entries)
    ports = ports_of(module)
    variables = list(_variables(target, ports))
    key = hashlib.sha256((module.header + module.source).encode()).hexdigest()
    guid = f"{{{key[:8]}-{key[8:12]}-{key[12:16]}-{key[16:20]}-{key[20:32]}}}"
    wrapper = _wrapper(target, module, ports, variables, guid)
    sources = {f"{name}.h": module.header, f"{name}.c": module.source, f"{name}_fmi2.c": wrapper}
    binary = _binary(sources, name)
    contents: dict[str, str | bytes] = {
        "modelDescription.xml": model_description(target, variables, guid),
        **{f"sources/{file}": text for file, text in sources.items()},
    }
    where, suffix = _platform()
    if binary is not None:
        contents[f"binaries/{where}/{name}{suffix}"] = binary
    with whole_file(path) as unfinished, zipfile.ZipFile(unfinished, "w") as archive:
        for file, content in contents.items():
            # a fixed date, so that the same unit gives the same file, byte by byte
            archive.writestr(
                zipfile.ZipInfo(file, (1980, 1, 1, 0, 0, 0)), content, zipfile.ZIP_DEFLATED
            )
    return None if binary is None else where


def _variables(target: Target, ports: dict[str, Port]) -> Iterator[Variable]:
    """Scalar variables, in the order of the ports."""
    start_values = _start_values(target)
    read_names = {name for entry in target.steps for name in entry.arguments}
    counts = {"real": 0, "logical": 0, "integer": 0}
    for port in ports.values():
        role, exact = _role(target, port)
        values = [float(x) for leaf in start_values.get(port.name, ()) for x in np.ravel(leaf)]
        unit = target.units.get(port.name, "")
        for number, (name, kind, meaning) in enumerate(_numbers(port)):
            start = values[number] if values else 0.0
            si_unit = unit or unit_of(meaning)
            reference, tunable = counts[kind], port.name in read_names - {"period"}
            yield Variable(name, kind, role, exact, tunable, meaning, si_unit, reference, start)
            counts[kind] += 1


def _role(target: Target, port: Port) -> tuple[str, bool]:
    """FMI causality of an argument, and whether its start value is given by the user."""
    name = port.name
    read_names = {name for entry in target.steps for name in entry.arguments}
    if name == SINCE:
        return "local", False
    if name in target.begin[0].results or name == "period":
        return "parameter", True
    if any(name in entry.results for entry in target.steps):
        # a state that is one number is also an output; a state that is a struct is only local
        state = name in read_names
        kind = "local" if state and isinstance(port.content, Struct) else "output"
        return kind, state and kind == "output"
    return ("input" if name in read_names else "parameter"), True


def _start_values(target: Target) -> dict[str, list[Any]]:
    """Leaves of the arguments with a start value: the parameters and the period."""
    fixed = {name: [value] for name, value in target.constants.items() if name in ("period",)}
    return fixed | {name: jax.tree.leaves(tree) for name, tree in target.designed().items()}


def _numbers(port: Port) -> Iterator[tuple[str, Kind, str]]:
    """Name, kind and description of each number of an argument."""
    for path, leaf, meaning in leaves(port.content, port.name):
        for index in np.ndindex(leaf.shape):
            yield path + "".join(f"[{k}]" for k in index), leaf.kind, meaning


def _wrapper(
    target: Target, module: Module, ports: dict[str, Port], variables: list[Variable], guid: str
) -> str:
    dialect = Dialect()

    def call_line(entry: str) -> str:
        return f"    status |= {call(module, entry, 'v->')};"

    def cases(kind: Kind) -> str:
        return "\n".join(
            f"    case {v.reference}: return &v->{v.name};" for v in variables if v.kind == kind
        )

    members = [f"    {declaration(p.content, p.name, dialect)};" for p in ports.values()]
    starts = [
        f"    v->{v.name} = {dialect.number(Number(v.kind, v.start)).text};"
        for v in variables
        if v.start != 0.0
    ]
    steps = [call_line(entry.name) for entry in target.steps]
    if SINCE in ports:
        steps = [f"    v->{SINCE} = duration;", *steps]
    else:
        period = repr(float(target.period))
        steps = [
            f"    const double periods = floor((duration / {period}) + 0.5);",
            f"    if (!((periods >= 1.0) && (fabs((duration / {period}) - periods) < 1e-6))) {{",
            "        return fmi2Error; /* a sampled unit advances by whole control periods */",
            "    }",
            "    for (double k = 0.0; k < periods; k += 1.0) {",
            *(f"    {line}" for line in steps),
            "    }",
        ]
    return filled(
        "fmi2.c",
        name=target.name,
        guid=guid,
        members="\n".join(members),
        reals=cases("real"),
        logicals=cases("logical") or NONE,
        integers=cases("integer") or NONE,
        first="\n".join(starts),
        begin="\n".join(call_line(entry.name) for entry in target.begin[1:]) or "    (void)v;",
        step="\n".join(steps),
    )


def _platform() -> tuple[str, str]:
    bits = "64" if sys.maxsize > 2**32 else "32"
    system = {"Linux": ("linux", ".so"), "Darwin": ("darwin", ".dylib")}
    name, suffix = system.get(platform.system(), ("win", ".dll"))
    return name + bits, suffix


def _binary(sources: dict[str, str], name: str) -> bytes | None:
    """Shared library, built by the C compiler of the machine; None without a compiler."""
    program = compiler()
    if program is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        write_texts(Path(folder), sources)
        files = [file for file in sources if file.endswith(".c")]
        flags = [*FLAGS.split(), "-O2", "-shared", "-fPIC", "-fvisibility=hidden"]
        command = [*program, *flags, *files, "-lm", "-o", "unit"]
        process = run_compiler(command, Path(folder))
        if process.returncode != 0:
            excerpt = re.sub(r"\s+", " ", process.stderr)[:200]
            raise InputError(f"{program[0]}: found an error in the unit ({excerpt}), expected C99")
        return (Path(folder) / "unit").read_bytes()
