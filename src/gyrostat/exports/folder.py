"""Flight folder: header, source, check program, Makefile and README."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from gyrostat.codegen.flight.c import emit
from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.flight.header import declaration, prototype
from gyrostat.codegen.flight.measure import FLAGS, OPTIMISATION, Compiled, measure
from gyrostat.codegen.flight.module import Entry, Module, Precision, call, ports_of
from gyrostat.codegen.flight.operation_count import CLASSES, ELEMENTARY, operations
from gyrostat.codegen.flight.reader.tokens import UnreadableError
from gyrostat.codegen.program import Assign, Call, Function, statements
from gyrostat.codegen.scope import LARGEST
from gyrostat.core.source_digest import source_digest
from gyrostat.exports.check_program import TOLERANCE, check_files, output_fields
from gyrostat.exports.evidence.evidence_kind import Subject
from gyrostat.exports.evidence.folder import evidence_files, evidence_notes
from gyrostat.exports.reasons import Reasons
from gyrostat.exports.target import SAFE, Target
from gyrostat.exports.template import filled
from gyrostat.exports.vectors.find import find_vectors
from gyrostat.exports.vectors.vectors import Vectors, nominal_vectors

DIFFERS = "The test program fails with this compiler"
"""Beginning of the line of the README about outputs that are not as in Python."""
MOST_NAMED = 6
"""Largest number of them that the line names."""


@dataclass(frozen=True)
class Search:
    """Search for test vectors that show every condition.

    Attributes:
        say: Function that receives a message about it.
        reasons: Reasons of the user for what cannot be shown, and for deviations from rules.
    """

    say: Callable[[str], None]
    reasons: Reasons = field(default_factory=Reasons)


def files(
    target: Target, precision: Precision, origin: str, search: Search | None = None
) -> dict[str, str]:
    """Emit a flight module with all its files.

    Args:
        target: Flight module.
        precision: Precision of real numbers.
        origin: Origin of the parameters, for the README.
        search: Search for test vectors; None for those of the test run.

    Returns:
        File name -> text.

    Raises:
        InputError: The module cannot be emitted; see `emit`.
    """
    return files_of(target, emitted(target, precision), precision, origin, search)


def emitted(target: Target, precision: Precision) -> Module:
    """C of a flight module, with the digests of what it is made from."""
    return emit(target.name, target.entries, precision, digests(target))


def files_of(
    target: Target,
    module: Module,
    precision: Precision,
    origin: str,
    search: Search | None = None,
) -> dict[str, str]:
    """All files of a flight module that was emitted; see `files`."""
    name = target.name
    found, refusal = None, "no vectors were sought: export with --evidence"
    if search is not None:
        try:
            found = find_vectors(target, module, precision, search.reasons)
            search.say(found.message())
        except UnreadableError as error:
            refusal = f"no vectors were sought, because the C code cannot be read back: {error}"
            search.say(refusal)
    vectors = nominal_vectors(target, module, precision) if found is None else found.vectors
    texts = {
        f"{name}.h": module.header,
        f"{name}.c": module.source,
        **check_files(target, module, precision, vectors),
        "Makefile": filled("Makefile", name=name, flags=FLAGS, optimisation=OPTIMISATION),
    }
    deviations = {} if search is None else search.reasons.deviations
    subject = Subject(target, module, precision, texts, found, refusal, deviations)
    readme = _readme(subject, origin, vectors, measure(texts, name))
    return texts | evidence_files(subject) | {"README.md": readme}


def digests(target: Target) -> dict[str, str]:
    """What a flight module is made from -> its digest, with the generator."""
    return {"generator": f"gyrostat {source_digest()}", **target.digests}


def _readme(subject: Subject, origin: str, vectors: Vectors, compiled: Compiled | None) -> str:
    target, module, precision = subject.target, subject.module, subject.precision
    dialect = Dialect(precision)

    def calls(entries: Sequence[Entry]) -> str:
        return "\n".join(f"{call(module, entry.name)};" for entry in entries)

    def prototype_of(entry: Entry) -> str:
        return prototype(entry.name, module.ports[entry.name], dialect) + ";"

    losses = ["", "", "## Errors of single precision", "", *_losses(compiled)]
    return filled(
        "README.md.txt",
        title=target.title,
        origin=origin,
        made_from=", ".join(f"{what}: `{text}`" for what, text in digests(target).items()),
        precision=precision,
        declarations="\n".join(_declarations(target, module, dialect)),
        begin=calls(target.begin),
        period=f"{target.period:g}",
        calls=calls(target.steps),
        validation="\n".join(_validation(target)),
        prototypes="\n".join(map(prototype_of, target.entries)),
        resources="\n".join(
            [
                *_costs(target, module, compiled),
                *_failure(compiled, TOLERANCE[precision]),
                *_tables(module),
            ]
        ),
        steps=len(vectors.rows),
        tolerance=f"{TOLERANCE[precision]:g}",
        rounding=_rounding(target, vectors),
        losses="\n".join(losses) if precision == "float" else "",
        evidence=evidence_notes(subject),
    )


def _validation(target: Target) -> list[str]:
    """Description of the validation of inputs, for the README."""
    reports = [n for entry in target.steps for n in entry.results if n.endswith("report")]
    if target.on_bad is None:
        return ["Inputs are not validated. A NaN propagates to all results that depend on it."]
    where = f"`{reports[0]}.sample_status`" if reports else "`output.sample_status`"
    return [
        "Every input is validated before anything is computed from it: finite, "
        "within its range, within its rate limit if it has one. A sample with a rejected value is "
        f"treated as missing: the memory is predicted, the output is {SAFE[target.on_bad]}, and "
        f"{where} says why (see `SampleStatus` in the header). The next good sample continues. "
        "After 4 samples without an accepted value the rate limit is not applied, so that no "
        f"sensor is rejected permanently. Memory and outputs stay finite{_exception(target)}.",
        "The limits are parameters of `guard`; 3.4e38 means no limit."
        + (f" From the data of the sensors: {', '.join(target.ranges)}." if target.ranges else ""),
    ]


def _exception(target: Target) -> str:
    """Results that are not tested to be finite, for a sentence."""
    names = ", ".join(f"`{name}`" for name in target.untested)
    return f", except {names}, which are computed without a test" if names else ""


def _declarations(target: Target, module: Module, dialect: Dialect) -> list[str]:
    lines = []
    for port in ports_of(module).values():
        value = target.constants.get(port.name)
        text = declaration(port.content, port.name, dialect)
        lines.append(f"{text}{'' if value is None else f' = {value!r}'};")
    return lines


def _costs(target: Target, module: Module, compiled: Compiled | None) -> list[str]:
    functions = {function.name: function for function in module.functions}
    classes = (*CLASSES, ELEMENTARY)
    lines = [
        f"| operations of a call | {' | '.join(classes)} |",
        "| --- " * (len(classes) + 1) + "|",
    ]
    for entry in target.steps:
        largest = operations(functions[entry.name])
        one_pass = operations(functions[entry.name], one_pass=True)
        cells = [str(largest[name]) for name in classes]
        if one_pass != largest:
            cells = [f"{one_pass[name]} ({largest[name]})" for name in classes]
        lines.append(f"| `{entry.name}` | {' | '.join(cells)} |")
    if any("(" in line for line in lines[2:]):
        lines += ["", "Counts for one pass of each loop that may end early (for its most passes)."]
    lines.append("")
    if compiled is None:
        return [*lines, "Size and stack: not measured, because there was no C compiler."]
    sizes = [] if compiled.code is None else [f"{compiled.code} bytes of code and constants"]
    if compiled.stack:
        deepest = max(_depth(functions[e.name], compiled) for e in target.entries)
        sizes.append(f"{deepest} bytes of stack at most, without those of the C library")
    return [
        *lines,
        f"By {compiled.compiler} with `{OPTIMISATION}`: {', '.join(sizes) or 'it compiles'}.",
    ]


def _failure(compiled: Compiled | None, tolerance: float) -> list[str]:
    """What the README says where the test program fails."""
    if compiled is None or not compiled.fails:
        return []
    # the errors are printed with two digits; NaN differs too
    wrong = [f"`{n}`" for n, error in compiled.errors.items() if not error <= 0.99 * tolerance]
    most = f", and {len(wrong) - MOST_NAMED} more" if len(wrong) > MOST_NAMED else ""
    named = f": not as in Python are {', '.join(wrong[:MOST_NAMED])}{most}" if wrong else ""
    return ["", f"{DIFFERS}{named}."]


def _tables(module: Module) -> list[str]:
    """Description of the constant tables, for the README."""
    body = (s for function in module.functions for s in statements(function.body))
    tables = {s.table for s in body if isinstance(s, Assign) and s.table and s.table.values}
    if not tables:
        return []
    sizes = ", ".join(str(size) for size in sorted(table.size for table in tables))
    return [
        "",
        f"Arrays of more than {LARGEST} numbers are constants of the code (`static const`, not on "
        f"the stack): found {sizes} numbers. `{module.name}_parameters` does not set them; export "
        "again to change them.",
    ]


def _depth(function: Function, compiled: Compiled) -> int:
    """Stack of the deepest chain of calls, bytes; an inlined function counts as none."""
    calls = (s.function for s in statements(function.body) if isinstance(s, Call))
    below = max((_depth(callee, compiled) for callee in calls), default=0)
    return compiled.stack.get(function.name, 0) + below


def _rounding(target: Target, vectors: Vectors) -> str:
    """Sentence about outputs that are made of rounding errors, for the README."""
    fields, are_errors = vectors.fields, vectors.conditioning.are_errors
    names = [fields[k].name for k in output_fields(target, fields) if are_errors[k]]
    if not names:
        return ""
    listed = ", ".join(f"`{name}`" for name in names)
    return f" Of outputs that are made of rounding errors only the size is compared: {listed}."


def _losses(compiled: Compiled | None) -> list[str]:
    if compiled is None:
        return ["Not measured, because there was no C compiler: `make errors` prints them."]
    return [
        "Largest error of every output in these steps against double precision, over the larger "
        "one of its value and its largest value in the test run. Steps in which single precision "
        "decides otherwise are not among them:",
        "",
        *(f"- `{output}`: {error:.1e}" for output, error in compiled.errors.items()),
    ]
