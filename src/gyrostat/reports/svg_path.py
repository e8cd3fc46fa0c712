"""Paths of SVG."""

import math

from gyrostat.core.types import Vector


def path_of(x: Vector, y: Vector) -> str:
    """Path through points; `y` points up."""
    parts, pen = [], "M"
    for a, b in zip(x.tolist(), (1000.0 - y).tolist(), strict=True):
        if math.isfinite(b):
            parts.append(f"{pen}{a:.1f} {min(max(b, -9e3), 9e3):.1f}")
            pen = "L"
        else:
            pen = "M"
    return "".join(parts)
