"""Options that a verb needs depending on its other options, so that one error names all of them."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.verbs.export_format import WheelFormat
from gyrostat.verbs.format_kinds import FORMATS, OF_PARTS
from gyrostat.verbs.part_kinds import PARTS

Options = Mapping[str, Any]
"""Name of an argument of a verb -> its value; None or missing if it is not given."""

FURTHER = "; ".join(
    f"{name}: {', '.join(kind.needs)}" for name, kind in PARTS.items() if kind.needs
)
"""Exported parts with the options that their designs need, as text."""


def missing_options(verb: str, options: Options) -> list[str]:
    """Options that a verb still needs, besides those that it needs in any case.

    Args:
        verb: Name of the verb.
        options: Options given so far.

    Returns:
        The missing options, as text for a message.
    """
    rule = _RULES.get(verb)
    return [] if rule is None else rule(options)


def require_options(verb: str, options: Options) -> None:
    """Check that no option is missing.

    Raises:
        InputError: Options are missing; the message names all of them.
    """
    require_given(verb, missing_options(verb, options))


def require_given(where: str, missing: list[str]) -> None:
    """Raise the error for missing options, if there are any.

    Args:
        where: Verb or place, for the message.
        missing: The missing options.

    Raises:
        InputError: Options are missing.
    """
    if missing:
        raise InputError(missing_text(where, missing))


def missing_text(where: str, missing: list[str]) -> str:
    """Message about missing options."""
    return f"{where}: missing {'; '.join(missing)}"


def missing_of_part(what: str | None, options: Options, *, is_designed: bool) -> list[str]:
    """Options that the export of a part as C or as a unit still needs.

    Args:
        what: Part to export, or None if it is not given.
        options: Options given so far.
        is_designed: Whether the part is designed from a wheel model.
    """
    missing = [] if what is not None else [f"--what (with more options: {FURTHER})"]
    missing += [] if options.get("period") is not None else ["--period"]
    needed = PARTS[what].needs if is_designed and what and what in PARTS else ()
    return missing + [option for option in needed if options.get(_argument(option)) is None]


def names_scenario(path: Path) -> bool:
    """Whether a file is a scenario file.

    Raises:
        InputError: The file cannot be read or is not TOML.
    """
    from gyrostat.core.toml_file import read_toml

    return path.suffix == ".toml" and "spacecraft" in read_toml(path, "a model file")


def _argument(option: str) -> str:
    return option.lstrip("-").replace("-", "_")


def _is_given(options: Options, *names: str) -> bool:
    return any(options.get(name) is not None for name in names)


def _attitude_and_wheels(options: Options) -> list[str]:
    if _is_given(options, "telemetry"):  # what the file lacks is reported when it is read
        return []
    attitude = _is_given(options, "attitude", "attitude_euler")
    wheels = _is_given(options, "wheels")
    return [
        *([] if attitude else ["--attitude, --attitude-euler or --telemetry"]),
        *([] if wheels else ["--wheels or --telemetry"]),
    ]


def _feasible(options: Options) -> list[str]:
    target = _is_given(options, "target", "euler", "towards")
    missing = [] if target else ["--target, --euler or --boresight with --towards"]
    if _is_given(options, "momentum"):
        return missing
    if not _is_given(options, "attitude", "attitude_euler", "rate", "wheels", "telemetry"):
        return [*missing, "--momentum or --telemetry (or --attitude and --wheels)"]
    return missing + _attitude_and_wheels(options)


def _recover(options: Options) -> list[str]:
    target = _is_given(options, "target", "euler")
    return [*([] if target else ["--target or --euler"]), *_attitude_and_wheels(options)]


def _export(options: Options) -> list[str]:
    to, model = options.get("to"), options.get("model")
    if to is not None and (to not in FORMATS or issubclass(FORMATS[to], WheelFormat)):
        return []
    try:
        if model is not None and names_scenario(Path(model)):
            return []
    except InputError:  # the verb reports it
        pass
    missing = missing_of_part(options.get("what"), options, is_designed=True)
    return missing if to or not missing else [f"{' and '.join(missing)}, with --to {OF_PARTS}"]


_RULES: dict[str, Callable[[Options], list[str]]] = {
    "feasible": _feasible,
    "recover": _recover,
    "export": _export,
}
