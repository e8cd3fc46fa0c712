"""Parse units as written in docstrings."""

import re
from collections import Counter

_BASE: dict[str, dict[str, int]] = {
    "kg": {"kg": 1},
    "m": {"m": 1},
    "s": {"s": 1},
    "A": {"A": 1},
    "rad": {"rad": 1},
    "1": {},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "Ω": {"kg": 1, "m": 2, "s": -3, "A": -2},
}
_POWERS = {"²": 2, "³": 3, "": 1}
_FACTOR = re.compile(r"(kg|rad|[msANJWVΩ1])([²³]?)")


def base_exponents(unit: str) -> dict[str, int]:
    """Exponents of kg, m, s, A and rad in a unit like N·m·s/rad, kg·m² or rad/s².

    Raises:
        ValueError: The text is not such a unit.
    """
    total: Counter[str] = Counter()
    # all factors after the solidus are in the denominator, with or without brackets
    above, _, below = unit.partition("/")
    for sign, text in ((1, above), (-1, below.strip("()"))):
        for factor in filter(None, text.split("·")):
            match = _FACTOR.fullmatch(factor)
            if match is None:
                raise ValueError(f"unit: found {unit!r}, expected a product of SI units")
            for name, power in _BASE[match[1]].items():
                total[name] += sign * power * _POWERS[match[2]]
    return {name: power for name, power in total.items() if power}


def unit_of(meaning: str) -> str:
    """Unit at the end of a field's description, or ""."""
    unit = re.split(r"[,;:] | and ", meaning)[-1].strip().rstrip(".")
    try:
        return unit if unit and base_exponents(unit) is not None else ""
    except ValueError:
        return ""
