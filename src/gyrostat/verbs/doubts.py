"""Remarks on inputs that can be used, but may be meant otherwise."""

import math
from collections.abc import Iterable

from gyrostat.verbs.arguments import Quantity, is_number, numbers, parts_of


def order_doubt(
    name: str, quaternion: str | Iterable[float] | None, *, scalar_last: bool
) -> list[str]:
    """Remark on a quaternion that is a half turn as read, but no rotation in the other order.

    Args:
        name: Option or key, for the message.
        quaternion: The quaternion as given; None for no remark.
        scalar_last: Whether its scalar part is last.
    """
    from gyrostat.failures.query import UNIT_TOLERANCE

    if quaternion is None:
        return []
    scalar = numbers(quaternion, 4, None, name)[0 if scalar_last else 3]
    if abs(abs(scalar) - 1.0) > UNIT_TOLERANCE:
        return []
    order, alternative = ("last", "first") if scalar_last else ("first", "last")
    axis = "x" if scalar_last else "z"
    remedy = "leave out --scalar-last" if scalar_last else "add --scalar-last"
    return [
        f"{name}, read scalar {order}, is a half turn about {axis}; scalar {alternative} it would "
        f"be no rotation at all: if that is meant, {remedy} (or the key scalar_last in a file)"
    ]


def angle_doubt(name: str, angles: str | Iterable[Quantity] | None) -> list[str]:
    """Remark on angles without a unit that are more than a revolution in rad.

    Args:
        name: Option or key, for the message.
        angles: The angles as given; None for no remark.
    """
    values = [float(part) for part in parts_of(() if angles is None else angles) if is_number(part)]
    large = [angle for angle in values if abs(angle) > 2.0 * math.pi]
    if not large:
        return []
    return [f"{name}: {large[0]:g} is read in rad; for degrees write '{large[0]:g} deg'"]


def target_doubts(
    target: str | Iterable[float] | None,
    euler: str | Iterable[Quantity] | None,
    *,
    scalar_last: bool,
) -> list[str]:
    """Remarks on the target of both verbs on failures: its quaternion and its angles."""
    return [
        *order_doubt("--target", target, scalar_last=scalar_last),
        *angle_doubt("--euler", euler),
    ]
