"""C identifiers and comments."""

import re
import unicodedata
from collections.abc import Iterable, Sequence

from gyrostat.codegen.flight.reserved import CPP_KEYWORDS, FUNCTIONS, KEYWORDS, MACROS

_LETTER = re.compile(r"\w+ (?:\w+ )??(?:(SMALL|CAPITAL) )?LETTER (.+?)(?: WITH .*)?")


def identifier(name: str) -> str:
    """C identifier of a Python name; an underscore is added to a word that C reserves.

    Letters that are not ASCII are written in words, such as omega or Delta. Two underscores before
    the first letter are left out: such names are the compiler's.
    """
    text = name if name.isascii() else _ascii(name)
    text = re.sub(r"[^0-9A-Za-z_]+", "_", text)
    if re.match("__+[A-Za-z]", text):
        text = text.lstrip("_")
    if not text or text[0].isdigit():
        text = f"item_{text}"
    reserved = text in KEYWORDS | FUNCTIONS or MACROS.fullmatch(text)
    return f"{text}_" if reserved else text


def public_identifier(name: str) -> str:
    """Identifier for a header, which C++ may include too.

    A name loses an underscore before a capital letter: C and C++ reserve such names.
    """
    text = identifier(name)
    if re.match("_[A-Z]", text):
        text = identifier(text[1:])
    return f"{text}_" if text in CPP_KEYWORDS else text


def member_names(names: Sequence[str], types: Iterable[str] = ()) -> list[str]:
    """Identifiers for the members of a struct, all different.

    A name that is an identifier stays as it is, and the others give way. No name is that of a type
    of the members, which C++ refuses.
    """
    wanted = [public_identifier(name) for name in names]
    taken = {*types}
    found: dict[int, str] = {}
    for k in sorted(range(len(names)), key=lambda k: wanted[k] != names[k]):
        found[k] = free_name(wanted[k], taken)
        taken.add(found[k])
    return [found[k] for k in range(len(names))]


def free_name(wanted: str, taken: set[str]) -> str:
    """Unused name: the wanted one, or that with the smallest number that makes it unique."""
    name, number = wanted, 2
    while name in taken:
        name, number = f"{wanted}_{number}", number + 1
    return name


def comment(text: str) -> str:
    """Text made safe for a comment in C: it cannot end or begin a comment or continue its line."""
    text = text.replace("\\", "/")
    return re.sub(r"(?<=/)(?=[/*])|(?<=\*)(?=/)|(?<=\?)(?=\?)", " ", text).strip()  # ??/ is \


def _ascii(name: str) -> str:
    """Name with its letters and digits in ASCII; a word is set apart from what is beside it."""
    text = re.sub(r"\W+", "_", unicodedata.normalize("NFC", name))
    text = re.sub(r"[^\W_]", lambda each: _spelled(each[0]), text)
    text = re.sub(r"^ +| +$|(?<=_) +| +(?=_)", "", text)
    return re.sub(" +", "_", text)


def _spelled(letter: str) -> str:
    """ASCII text of a letter or digit: without its accents, or its name between spaces."""
    parts = unicodedata.normalize("NFKD", letter)
    text = "".join(part for part in parts if not unicodedata.combining(part))
    if re.fullmatch("[0-9A-Za-z]+", text):
        return text
    spelled = _LETTER.fullmatch(unicodedata.name(text, "")) if len(text) == 1 else None
    if spelled is None:
        return f" u{ord(letter):04x} "
    word = re.sub(r"\W+", "_", spelled[2].lower().replace("lamda", "lambda"))
    return f" {word.capitalize() if spelled[1] == 'CAPITAL' else word} "
