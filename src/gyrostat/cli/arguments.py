"""Parse command-line arguments: quantities, NAME=VALUE pairs, records."""

import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gyrostat.core.errors import InputError, printable

if TYPE_CHECKING:
    from gyrostat.telemetry import Record


def say(text: str) -> None:
    """Print a message for a person as one line on stderr."""
    print(printable(text), file=sys.stderr, flush=True)


def pairs(text: str | None, where: str) -> dict[str, str]:
    """Split NAME=VALUE,NAME=VALUE.

    Raises:
        InputError: a part has no equals sign or a name comes twice.
    """
    found: dict[str, str] = {}
    for part in (text or "").split(","):
        if not part.strip():
            continue
        name, equals, value = (p.strip() for p in part.partition("="))
        if not (name and equals and value):
            raise InputError(f"{where}: found {part.strip()!r}, expected NAME=VALUE")
        if name in found:
            raise InputError(f"{where}: found {name} twice, expected it once")
        found[name] = value
    return found


def command_line() -> str:
    """What the user typed, as a shell would take it."""
    return shlex.join(["gyrostat", *sys.argv[1:]])


def load(
    path: Path,
    columns: str | None,
    units: str | None,
    unsigned_current: bool,
    *,
    drop: bool = False,
    unsigned_speed: bool = False,
    edges: Path | None = None,
    pulses: int = 1,
) -> "Record":
    """Read a record, cut it at gaps, and say what was done to it.

    Args:
        path: of the file.
        columns: text of --columns.
        units: text of --units.
        unsigned_current: whether the current has lost its sign.
        drop: whether rows with missing numbers are left out.
        unsigned_speed: whether the speed has lost its sign.
        edges: file with the times of a tachometer's edges, or None.
        pulses: edges a turn.

    Raises:
        InputError: the file gives no record.
    """
    from gyrostat.telemetry import cut, read_record

    record = read_record(
        path,
        columns=pairs(columns, "--columns") or None,
        units=pairs(units, "--units") or None,
        unsigned_current=unsigned_current,
        missing="drop" if drop else "refuse",
        edges=edges,
        pulses=pulses,
    )
    if unsigned_speed:
        from gyrostat.identification.signs import signed_speed

        signed = signed_speed(record)
        if signed is None:
            raise InputError(
                f"{path}: --unsigned-speed: found a speed that never touches zero, expected one "
                "that does: nothing shows where its sign changes"
            )
        record = signed
    record = cut(record)
    for note in record.notes:
        say(f"{record.name}: {note}")
    return record


def quantity(text: str, name: str, model: str, option: str) -> float:
    """The value of a named parameter, SI."""
    from gyrostat.core.units import parse_quantity
    from gyrostat.identification.parameters import parameter_dimension
    from gyrostat.identification.prediction import friction_model

    dimension = parameter_dimension(friction_model(model), name, option)
    return parse_quantity(text, dimension, f"{option} {name}")


def quantities(text: str | None, dimension: str, option: str) -> list[float]:
    """Values of an option that takes one or several, separated by commas, SI."""
    from gyrostat.core.units import parse_quantity

    parts = text.split(",") if text else []
    return [parse_quantity(part.strip(), dimension, option) for part in parts]


def inertia(text: str | None) -> tuple[float | None, dict[str, float]]:
    """Value of --inertia, kg·m², and its tolerance as a share, where one is given."""
    from gyrostat.core.units import parse_uncertain

    if text is None:
        return None, {}
    value, sigma = parse_uncertain(text, "inertia", "--inertia")
    if value is None:
        raise InputError(
            f"--inertia: found {text.strip()!r}, expected a value before the tolerance"
        )
    return value, {"inertia": sigma} if sigma else {}


def scales(options: Mapping[str, str | None]) -> tuple[dict[str, float], dict[str, float]]:
    """Factors on what was recorded, and their tolerances as shares, where they are given.

    Args:
        options: name of an option with underscores -> its text.

    Raises:
        InputError: a factor that is not positive.
    """
    from gyrostat.core.units import parse_uncertain

    factors, tolerances = {}, {}
    for name, text in options.items():
        where = f"--{name.replace('_', '-')}"
        value, sigma = (1.0, 0.0) if text is None else parse_uncertain(text, None, where)
        factors[name] = 1.0 if value is None else value
        if not factors[name] > 0.0:
            raise InputError(f"{where}: found {factors[name]:g}, expected a factor above 0")
        if sigma:
            tolerances[name] = sigma
    return factors, tolerances


def refuse_given(options: Mapping[str, object], where: str, expected: str) -> None:
    """Refuse options that would have no effect.

    Args:
        options: name -> what the user gave, empty where nothing.
        where: what has no use for them.
        expected: what has.

    Raises:
        InputError: one was given.
    """
    given = [option for option, value in options.items() if value]
    if given:
        raise InputError(f"{where}: found {', '.join(given)}, expected these with {expected} only")


def drive(items: Sequence[str], model: str) -> dict[str, float]:
    """What `validate --hold` tells of the drive: current_bias=VALUE, A.

    Raises:
        InputError: another name, which the model file holds, or no value.
    """
    told = held(items, model)
    for name, value in told.items():
        if name != "current_bias":
            raise InputError(
                f"--hold: found {name}, expected current_bias: the model file holds the wheel"
            )
        if value is None:
            raise InputError("--hold current_bias: found no value, expected one in A")
    return {name: value for name, value in told.items() if value is not None}


def held(items: Sequence[str], model: str) -> dict[str, float | None]:
    """Values of --hold NAME=VALUE, or None for a NAME to hold at its default."""
    found: dict[str, float | None] = {}
    for item in items:
        for part in item.split(","):
            name, _, value = (p.strip() for p in part.partition("="))
            found[name] = quantity(value, name, model, "--hold") if value else None
    return found


def priors(items: Sequence[str], model: str) -> dict[str, tuple[float, float]]:
    """Means and sigmas of --prior NAME=MEAN:SIGMA, SI."""
    found = {}
    for name, text in (kv for item in items for kv in pairs(item, "--prior").items()):
        mean, colon, sigma = text.partition(":")
        if not colon:
            raise InputError(f"--prior {name}: found {text!r}, expected MEAN:SIGMA")
        found[name] = (
            quantity(mean, name, model, "--prior"),
            quantity(sigma, name, model, "--prior"),
        )
    return found


def starts(items: Sequence[str], model: str) -> dict[str, float]:
    """Values of --start NAME=VALUE, SI."""
    return {
        name: quantity(text, name, model, "--start")
        for item in items
        for name, text in pairs(item, "--start").items()
    }


def progress(stage: str, count: int, cost: float) -> None:
    """Say how an iteration goes."""
    say(f"  {stage}: iteration {count}, cost {cost:.6g}")
