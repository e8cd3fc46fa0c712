"""C identifiers and comments."""

import re

KEYWORDS = frozenset(
    {
        *("auto", "break", "case", "char", "const", "continue", "default", "do", "double"),
        *("else", "enum", "extern", "float", "for", "goto", "if", "inline", "int", "long"),
        *("register", "restrict", "return", "short", "signed", "sizeof", "static"),
        *(
            "struct",
            "switch",
            "typedef",
            "union",
            "unsigned",
            "void",
            "volatile",
            "while",
            "bool",
            "true",
            "false",
        ),
    }
)
FUNCTIONS = frozenset(
    {
        *("acos", "asin", "atan", "atan2", "cbrt", "ceil", "cos", "cosh", "exp", "exp2"),
        *("expm1", "fabs", "floor", "fmod", "is_finite", "isfinite", "log", "log1p", "pow", "rint"),
        *("round", "sin", "sinh", "sqrt", "tan", "tanh", "largest", "smallest", "sense"),
        *("acosh", "asinh", "atanh", "erf", "erfc", "integer_of", "integer_quotient"),
        *("integer_rest", "integer_left", "integer_right"),
        *("status", "main", "printf", "memcpy"),
    }
)
"""Names reserved by the emitted code, not available for variables."""


def identifier(name: str) -> str:
    """C identifier of a Python name; an underscore is added to a reserved word of C."""
    made = re.sub(r"[^0-9A-Za-z_]+", "_", name)
    if not made or made[0].isdigit():
        made = f"item_{made}"
    return f"{made}_" if made in KEYWORDS | FUNCTIONS else made


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
