"""Angles whose reduction by pi/2 takes long, as an array of C: `python3 -m bounds.angles double`.

For each exponent there is the mantissa whose angle is next to a multiple of pi/2, among the
convergents of the continued fraction (Muller and others: Handbook of Floating-Point Arithmetic, 2nd
ed., 11.3.2), and three others, of one digit and of many.
"""

import math
import sys
from collections.abc import Iterator

_FORMATS = {"double": (53, 971, 20), "float": (24, 104, 7)}
"""Type -> digits of the mantissa, largest exponent of its last digit, exponent of the first."""


def angles(real: str) -> Iterator[float]:
    """Angles, rad, of every exponent from that on which the reduction has many digits of pi.

    Args:
        real: Type of the numbers, "double" or "float".
    """
    digits, largest, first = _FORMATS[real]
    places = largest + 3 * digits
    half_pi = _half_pi(places)
    for exponent in range(first - digits, largest + 1):
        for mantissa in (
            _closest(half_pi, places + exponent, digits),
            1 << (digits - 1),
            (1 << digits) - 1,
            (1 << (digits - 1)) | ((exponent * 2654435761) % (1 << (digits - 1))),
        ):
            yield math.ldexp(float(mantissa), exponent)


def _half_pi(places: int) -> int:
    """pi/2 times 2**places, by Machin's formula."""

    def inverse_tangent(of: int) -> int:
        term = total = (1 << (places + 16)) // of
        k, sign = 1, 1
        while term:
            term //= of * of
            k, sign = k + 2, -sign
            total += sign * (term // k)
        return total

    return (4 * inverse_tangent(5) - inverse_tangent(239)) * 2 >> 16


def _closest(half_pi: int, shift: int, digits: int) -> int:
    """Mantissa m for which m 2**shift is next to a multiple of half_pi."""
    above, below = 1 << max(shift, 0), half_pi << max(-shift, 0)
    before, mantissa = 0, 1
    above %= below
    while above:
        quotient, rest = divmod(below, above)
        following = quotient * mantissa + before
        if following >= 1 << digits:
            break
        before, mantissa, below, above = mantissa, following, above, rest
    return mantissa * (((1 << digits) - 1) // mantissa)


def _main() -> None:
    real = sys.argv[1]
    rows = [f"    {angle.hex()}," for angle in angles(real)]
    print("\n".join([f"static const {real} angles[{len(rows)}] = {{", *rows, "};"]))


if __name__ == "__main__":
    _main()
