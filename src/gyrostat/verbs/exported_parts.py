"""Parts that are exported: designed from a wheel model and options, or given, as flight modules."""

import shutil
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Named, Quantity, in_si, refuse_given
from gyrostat.verbs.export_format import CodeFormat
from gyrostat.verbs.exported_part import Given
from gyrostat.verbs.measurement_limits import measurement_limits
from gyrostat.verbs.part_kinds import PARTS

if TYPE_CHECKING:
    from gyrostat.exports import Search, Target
    from gyrostat.wheel import WheelModel


class Choice(NamedTuple):
    """Options of an exported part, as given.

    Attributes:
        what: Part to design, or kind of the part.
        period: Control period, s.
        design: Option -> value, or None if it is not given.
        ranges: Accepted values of inputs.
        rate_limits: Largest accepted change of inputs.
        on_bad: Command after a rejected sample: "hold" or "zero".
        name: Name of the flight module; None for that of the part.
    """

    what: str
    period: Quantity
    design: dict[str, Any]
    ranges: Named
    rate_limits: Named
    on_bad: str
    name: str | None


def code_texts(
    form: type[CodeFormat],
    part: Any,
    model: "WheelModel | None",
    choice: Choice,
    precision: str,
    origin: str,
    search: "Search | None",
) -> dict[str, str]:
    """Files of code: name -> text.

    Those of a part that is designed from a wheel model are kept in the private cache. A given part
    is always traced.

    Args:
        form: Format.
        part: Part to export, unless it is designed.
        model: Wheel model to design a part from; None to export `part`.
        choice: Options.
        precision: Precision of real numbers: "double" or "float".
        origin: Origin of the parameters, for the README.
        search: Search for test vectors; None for those of the test run.

    Raises:
        InputError: A part or option cannot be used.
    """
    from gyrostat.codegen.simd import compiler, compiler_version
    from gyrostat.core.stored_texts import stored_texts

    def make() -> dict[str, str]:
        return form.texts(flight_target(part, model, choice), precision, origin, search)

    if model is None:
        return make()
    try:
        tools = compiler(), compiler_version(), shutil.which("size")
    except InputError:  # nothing is measured by a compiler that does not run
        return make()
    values = {name: float(value) for name, value in model.values.items()}
    sought = None if search is None else repr(search.reasons)
    about = (form, model.friction, values, choice, precision, origin, sought, tools)
    return stored_texts(about, make)


def flight_target(part: Any, model: "WheelModel | None", choice: Choice) -> "Target":
    """Flight module of a part, or of one designed from a wheel model and the options.

    Raises:
        InputError: A part or option cannot be used.
    """
    from gyrostat.core.validation import check_parts, require_period

    part_name, options = choice.what, choice.design
    kind = PARTS[part_name]
    limits = measurement_limits(part_name, choice.ranges, choice.rate_limits)
    if not kind.fields:
        refuse_given({"--on-bad": choice.on_bad == "zero"}, f"--what {part_name}", "another --what")
    if model is None:
        refuse_given(options, name_of(part), "a wheel or its model")
    else:
        option_names = (*kind.needs, *kind.takes)
        unused = {option: value for option, value in options.items() if option not in option_names}
        refuse_given(unused, f"--what {part_name}", "another --what")
    period = in_si(choice.period, "time", "--period")
    require_period("--period", period)
    if model is not None:
        part = kind.design(model.wheel(), period, Given(options))
    check_parts(part)
    target = named(kind.module(part, period, limits, choice.on_bad), choice.name)
    digest = None if model is None else model.digest()
    return target if digest is None else replace(target, digests={"model": f"SHA-256 {digest}"})


def named(target: "Target", name: str | None) -> "Target":
    """Flight module with the name of the option, if it is given."""
    from gyrostat.exports.target import renamed

    return target if name is None else renamed(target, name)


def name_of(model: Any) -> str:
    """Name of a given object, for a message."""
    return f"an object of {type(model).__name__}"
