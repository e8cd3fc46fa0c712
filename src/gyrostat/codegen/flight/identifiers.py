"""C identifiers and comments."""

import re

from gyrostat.codegen.flight.expressions import HELPERS

KEYWORDS = frozenset(
    {
        *("auto", "bool", "break", "case", "char", "const", "continue", "default", "do"),
        *("double", "else", "enum", "extern", "false", "float", "for", "goto", "if", "inline"),
        *("int", "long", "register", "restrict", "return", "short", "signed", "sizeof"),
        *("static", "struct", "switch", "true", "typedef", "union", "unsigned", "void"),
        *("volatile", "while"),
    }
)
FUNCTIONS = frozenset(
    {
        *HELPERS.values(),
        *("acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "ceil", "cos"),
        *("cosh", "erf", "erfc", "exp", "exp2", "expm1", "fabs", "floor", "fmod", "isfinite"),
        *("log", "log1p", "main", "memcpy", "pow", "printf", "rint", "round", "sin", "sinh"),
        *("sqrt", "status", "tan", "tanh"),
    }
)
"""Names reserved by the emitted code, not available for variables."""


def identifier(name: str) -> str:
    """C identifier of a Python name; an underscore is added to a reserved word of C."""
    text = re.sub(r"[^0-9A-Za-z_]+", "_", name)
    if not text or text[0].isdigit():
        text = f"item_{text}"
    return f"{text}_" if text in KEYWORDS | FUNCTIONS else text


def free_name(wanted: str, taken: set[str]) -> str:
    """Unused name: the wanted one, or that with the smallest number that makes it unique."""
    name, number = wanted, 2
    while name in taken:
        name, number = f"{wanted}_{number}", number + 1
    return name


def comment(text: str) -> str:
    """Text made safe for a comment in C: it cannot end or begin a comment or continue its line."""
    for pair in ("*/", "/*", "??"):  # ?? begins a trigraph
        text = text.replace(pair, f"{pair[0]} {pair[1]}")
    return text.replace("\\", "/").strip()
