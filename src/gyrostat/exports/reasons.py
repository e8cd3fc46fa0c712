"""The user's reasons for what evidence cannot show, and for deviations from rules."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, get_args

from gyrostat.codegen.flight.reader.decisions import Decision
from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import described, read_toml, refuse_unknown
from gyrostat.exports.vectors.justifications import Justification, Want, justification

KIND = "a file of reasons"
KEYS = ("file", "text", "condition", "cannot_be", "modules", "confirm", "reason")
TEXTS = {"justified": ("file", "text", "reason"), "deviation": ("rule", "reason")}
"""Keys of a table that are required, with a text."""


@dataclass(frozen=True)
class Reasons:
    """Reasons of the user.

    Attributes:
        path: File that they are read from; empty for none.
        justified: What no test vector can show of his code.
        deviations: Rule of MISRA C:2012 -> reason for a deviation.
    """

    path: str = ""
    justified: tuple[Justification, ...] = ()
    deviations: Mapping[str, str] = field(default_factory=dict)

    def check(self, decisions: Sequence[Decision]) -> None:
        """Refuse reasons that are about none of the decisions of a module.

        Raises:
            InputError: A reason is about no decision, or about a condition that it does not have.
        """
        for number, each in enumerate(self.justified, start=1):
            about = [d for d in decisions if each.names(d)]
            where = f"{self.path}: [[justified]] {number}"
            if not about:
                lines = sorted({d.origin for d in decisions if d.origin.startswith(each.file)})
                known = lines[0] if lines else "see the column source of conditions.csv"
                raise InputError(
                    f"{where}: found {each.file!r} with {each.text!r}, expected the line of a "
                    f"decision of the C code, such as {known!r}"
                )
            if each.condition is not None and each.condition >= max(d.size for d in about):
                raise InputError(
                    f"{where}: key condition: found {each.condition}, expected less than "
                    f"{max(d.size for d in about)}, the number of conditions"
                )


def read_reasons(path: Path) -> Reasons:
    """Read reasons from a TOML file.

    Tables [[justified]] have the keys of `exports/vectors/justified.toml`: file, text, condition,
    cannot_be, modules, confirm and reason. Tables [[deviation]] have rule and reason.

    Raises:
        InputError: The file cannot be read, or a key is missing, unknown or has a wrong value.
    """
    content = read_toml(path, KIND)
    refuse_unknown(path, "", content, TEXTS)
    tables = {name: _tables(path, name, content.get(name, [])) for name in TEXTS}
    for number, entry in enumerate(tables["justified"], start=1):
        _check_justified(path, f"[[justified]] {number}", entry)
    justified = tuple(map(justification, tables["justified"]))
    deviations = {e["rule"]: " ".join(e["reason"].split()) for e in tables["deviation"]}
    return Reasons(str(path), justified, deviations)


def _tables(path: Path, name: str, found: Any) -> list[dict[str, Any]]:
    if not isinstance(found, list) or not all(isinstance(entry, dict) for entry in found):
        raise InputError(f"{path}: key {name}: found {described(found)}, expected [[{name}]]")
    for number, entry in enumerate(found, start=1):
        where = f"[[{name}]] {number}"
        refuse_unknown(path, f"{where}.", entry, KEYS if name == "justified" else TEXTS[name])
        for key in TEXTS[name]:
            value = entry.get(key)
            if not isinstance(value, str) or not value.strip():
                raise _wrong(path, where, key, value, "a text")
    return found


def _check_justified(path: Path, where: str, entry: Mapping[str, Any]) -> None:
    wants, condition = entry.get("cannot_be"), entry.get("condition", 0)
    known = get_args(Want)
    if not isinstance(wants, list) or not wants or any(want not in known for want in wants):
        raise _wrong(path, where, "cannot_be", wants, f"a list of {', '.join(known)}")
    if isinstance(condition, bool) or not isinstance(condition, int) or condition < 0:
        raise _wrong(path, where, "condition", condition, "a whole number from 0")
    if not isinstance(entry.get("confirm", False), bool):
        raise _wrong(path, where, "confirm", entry["confirm"], "true or false")
    modules = entry.get("modules", [])
    if not isinstance(modules, list) or not all(isinstance(name, str) for name in modules):
        raise _wrong(path, where, "modules", modules, "a list of names of flight modules")


def _wrong(path: Path, where: str, key: str, value: object, expected: str) -> InputError:
    found = described(value)
    return InputError(f"{path}: {where}: key {key}: found {found}, expected {expected}")
