"""Parameters of a friction law whose curve is nearest to viscous plus Coulomb friction."""

import dataclasses
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.core.units import si_unit
from gyrostat.wheel.friction.sampled_curve import sampled_curve


def nearest_to_coulomb(law: Any, viscous: float, coulomb: float) -> dict[str, float]:
    """Parameters of a law, SI, for which its curve is nearest to b w + c.

    The torque is linear in its coefficients, the parameters whose unit has N·m. Each of both parts
    of the curve is approximated by coefficients of 0 or more, so that the result is linear in b and
    c; other parameters have the start values of their fields.

    Args:
        law: Class of the law.
        viscous: Viscous coefficient b, N·m·s/rad.
        coulomb: Coulomb torque c, N·m.

    Raises:
        InputError: A parameter that is no coefficient has no start value, or the law has no
            coefficient.
    """
    starts = {f.name: f.metadata.get("start") for f in dataclasses.fields(law)}
    values: dict[str, float] = {}
    coefficients: list[str] = []
    for name, dimension in law.dimensions().items():
        start = starts[name]
        values[name] = 0.0 if start is None else float(start)
        if start is None and name not in law.coefficients():
            raise InputError(
                f"{law.__name__}: found no start value of {name}, expected "
                f'{name} = parameter("{si_unit(dimension)}", start=VALUE), or a method from_coulomb'
            )
        if start is None:
            coefficients.append(name)
    if not coefficients:
        return values
    parts = _parts(law, tuple(values.items()), tuple(coefficients))
    return values | dict(zip(coefficients, (parts @ [viscous, coulomb]).tolist(), strict=True))


def _parts(law: Any, fixed: tuple[tuple[str, float], ...], coefficients: tuple[str, ...]) -> Any:
    """Coefficients for the curve w and for the curve 1, (coefficients, 2)."""
    from scipy.optimize import nnls  # takes long to import

    names = list(law.dimensions())
    base = np.array([dict(fixed)[name] for name in names])
    shapes, speed = [], np.zeros(0)
    for name in (None, *coefficients):
        theta = base + (np.array(names) == name)
        curve = sampled_curve(law, theta, 1.0)
        speed = curve.speed[3:]
        shapes.append(curve.torque[3:])
    rows = np.stack(shapes[1:], axis=1) - shapes[0][:, None]
    if not np.all(np.isfinite(rows)):
        raise InputError(
            f"{law.__name__}: found no start values, expected a torque that is linear in "
            f"{', '.join(coefficients)}, or a method from_coulomb"
        )
    weight = 1.0 / speed
    ones: Vector = np.ones(len(speed))
    return np.stack(
        [nnls(weight[:, None] * rows, weight * speed)[0], nnls(rows, ones)[0]], axis=1
    ).round(12)
