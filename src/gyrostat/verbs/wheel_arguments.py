"""Arguments of the verbs on wheels: records, wheel models, friction parameters, tolerances."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Named, Quantity, Say, in_si, in_si_or_none, named, one_of

if TYPE_CHECKING:
    from gyrostat.identification import Fit
    from gyrostat.telemetry import Record
    from gyrostat.wheel import Wheel, WheelModel
    from gyrostat.wheel.friction_laws import Law

HOLDS = ("zero-order", "linear")
"""Interpolation of the current between samples."""
MISSING = ("refuse", "drop")
"""Treatment of cells without a finite number."""


def load_records(
    records: "Record | str | Path | Iterable[Record | str | Path]",
    say: Say,
    *,
    missing: str = "refuse",
    unsigned_speed: bool = False,
    **reading: Any,
) -> "list[Record]":
    """Read the records given as paths, split them at gaps, and report all changes.

    Args:
        records: One or several records or paths.
        say: Function that receives each note.
        missing: "refuse" or "drop"; see `gyrostat.telemetry.read_record`.
        unsigned_speed: Whether the speed is a magnitude; the sign changes where it touches zero.
        reading: Further options of `gyrostat.telemetry.read_record`; columns and units also as
            text, or columns as the path of a TOML file.

    Raises:
        InputError: A file cannot be read, or an unsigned speed never touches zero.
    """
    from gyrostat.telemetry import Record, cut, read_record

    one_of(missing, MISSING, "--missing")
    reading["units"] = named(reading["units"], "--units") or None
    for name in ("columns", "speed_columns"):
        reading[name] = assigned(reading.get(name), f"--{name.replace('_', '-')}")
    items = [records] if isinstance(records, Record | str | Path) else list(records)
    results = []
    for item in items:
        if isinstance(item, Record):
            record, note_count = item, len(item.notes)
        else:
            record, note_count = read_record(item, missing=missing, **reading), 0  # pyright: ignore[reportArgumentType]
        record = cut(_signed(record) if unsigned_speed else record)
        for note in record.notes[note_count:]:
            say(f"{record.name}: {note}")
        results.append(record)
    return results


def assigned(columns: Any, where: str) -> Any:
    """Columns by role, from a mapping or text; the path of a TOML file stays a path."""
    return columns if _is_toml_file(columns) else named(columns, where) or None


def _is_toml_file(value: object) -> bool:
    """Whether a value is the path of a TOML file, not a text NAME=VALUE."""
    text = str(value) if isinstance(value, str | Path) else ""
    return text.endswith(".toml") and "=" not in text


def loop_of(loop: "str | Path | None", method: str) -> tuple[str | None, Path | None]:
    """State of the loop, "open" or "closed", and the file of its control law; None if not given.

    Args:
        loop: "open", "closed", or the path of a TOML file.
        method: Method of identification.

    Raises:
        InputError: The value is none of them, or contradicts the method.
    """
    if loop is None:
        return None, None
    if _is_toml_file(loop):
        if method != "inverse":
            raise InputError(
                f"--loop: found a control law with --method {method}, expected --method inverse"
            )
        return "closed", Path(loop)
    one_of(str(loop), ("open", "closed"), "--loop (or a .toml file)")
    if method not in ("batch", "inverse") or (method, loop) == ("inverse", "open"):
        raise InputError(f"--loop: found {loop} with --method {method}, expected another method")
    return str(loop), None


def _signed(record: "Record") -> "Record":
    from gyrostat.identification.read.signs import signed_speed

    signed = signed_speed(record)
    if signed is None:
        raise InputError(
            f"{record.name}: --unsigned-speed: found a speed that never touches zero, expected one "
            "that does: its sign changes there"
        )
    return signed


def wheel_model(model: "WheelModel | Wheel | Fit | str | Path", *, force: bool) -> "WheelModel":
    """Read a wheel model, or make it from a wheel or an identification.

    Args:
        model: Path of model.toml, or an object.
        force: Whether to accept a wheel that its identification marked as impossible.

    Raises:
        InputError: The file cannot be read, the identification gives no wheel, or the wheel has
            bristle friction.
    """
    from gyrostat.wheel import Wheel, WheelModel, read_model
    from gyrostat.wheel.friction import Friction

    if isinstance(model, str | Path):
        model = read_model(Path(model), force=force)
        model.static_friction()
        return model
    from gyrostat.identification import Fit

    if isinstance(model, Fit):
        model.wheel()
        result = model.wheel_model()
        if result is not None and result.impossible and not force:
            raise InputError(
                f"{model.method} fit: found a wheel that is not valid ({result.impossible}), "
                "expected a valid one; force=True accepts it if it can be simulated"
            )
        assert result is not None
        return result
    if isinstance(model, WheelModel):
        model.static_friction()
        return model
    if not isinstance(model, Wheel) or not isinstance(model.friction, Friction):
        friction = type(getattr(model, "friction", model)).__name__
        raise InputError(f"model: found {friction}, expected a wheel with a static friction curve")
    values = {"inertia": model.inertia, "motor_constant": model.motor_constant}
    values |= model.friction.parameters()
    return WheelModel(type(model.friction), {name: float(v) for name, v in values.items()})


def parameters_in_si(values: Mapping[str, Any], model: "str | Law", where: str) -> dict[str, Any]:
    """Convert values of named wheel parameters to SI.

    Args:
        values: Name -> number, text or None, which is kept.
        model: Friction model, which gives the dimension of each name.
        where: Option, for the message.

    Raises:
        InputError: A name or unit is unknown, or a value is not a number.
    """
    return {
        name: None if value is None else _parameter_in_si(value, name, model, where)
        for name, value in values.items()
    }


def _parameter_in_si(value: Quantity, name: str, model: "str | Law", where: str) -> float:
    from gyrostat.identification.fit.parameters import parameter_dimension
    from gyrostat.wheel.friction_laws import friction_law

    dimension = parameter_dimension(friction_law(model), name, where)
    return in_si(value, dimension, f"{where} {name}")


def priors(values: Named, model: "str | Law") -> dict[str, tuple[float, float]]:
    """Convert a-priori means and standard deviations of wheel parameters to SI.

    Args:
        values: Name -> (mean, sigma), or text NAME=MEAN:SIGMA.
        model: Friction model, which gives the dimension of each name.

    Raises:
        InputError: A name or unit is unknown, or a value does not have two numbers.
    """
    pairs = {}
    for name, value in named(values, "--prior").items():
        parts = value.split(":", 1) if isinstance(value, str) else value
        if not isinstance(parts, Sequence) or len(parts) != 2:
            raise InputError(f"--prior {name}: found {value!r}, expected MEAN:SIGMA")
        mean, sigma = (_parameter_in_si(part, name, model, "--prior") for part in parts)
        pairs[name] = (mean, sigma)
    return pairs


def inertia_and_tolerance(value: Quantity | None) -> tuple[float | None, dict[str, float]]:
    """Convert an inertia to kg·m², and its tolerance to a relative number."""
    from gyrostat.core.units import parse_uncertain

    if not isinstance(value, str):
        return in_si_or_none(value, "inertia", "--inertia"), {}
    number, sigma = parse_uncertain(value, "inertia", "--inertia")
    if number is None:
        raise InputError(
            f"--inertia: found {value.strip()!r}, expected a value before the tolerance"
        )
    return number, {"inertia": sigma} if sigma else {}


def factors_and_tolerances(
    options: Mapping[str, Quantity | None],
) -> tuple[dict[str, float], dict[str, float]]:
    """Convert factors on recorded signals and their tolerances to relative numbers.

    Args:
        options: Name of an option with underscores -> number, text, or None.

    Raises:
        InputError: A factor is not positive.
    """
    from gyrostat.core.units import parse_uncertain

    factors, tolerances = {}, {}
    for name, factor in options.items():
        where = f"--{name.replace('_', '-')}"
        text = factor if factor is None or isinstance(factor, str) else repr(float(factor))
        value, sigma = (1.0, 0.0) if text is None else parse_uncertain(text, None, where)
        factors[name] = 1.0 if value is None else value
        if not factors[name] > 0.0:
            raise InputError(f"{where}: found {factors[name]:g}, expected a factor above 0")
        if sigma:
            tolerances[name] = sigma
    return factors, tolerances
