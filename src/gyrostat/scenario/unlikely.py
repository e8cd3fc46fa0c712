"""Numbers of a scenario or spacecraft that are possible, but unlikely: one line for each.

A unit or a decimal point is the usual reason. Nothing is refused here; see
`gyrostat.scenario.impossible`.
"""

from math import degrees, inf, isfinite, pi, tau
from typing import Any

import numpy as np

from gyrostat.core.jax64 import jnp
from gyrostat.core.text import plain
from gyrostat.core.types import Vector
from gyrostat.scenario.distribution import DEVIATION, VALUE
from gyrostat.scenario.kinds.distributions import DISTRIBUTIONS, distribution_of
from gyrostat.scenario.kinds.registry import numbers_of
from gyrostat.scenario.numbers import Lines, Numbers
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.schema import CENTRE_OF_MASS
from gyrostat.scenario.spacecraft_values import spacecraft_values, surface_rows
from gyrostat.scenario.unlikely_limits import LIMITS
from gyrostat.spacecraft import SpacecraftFile
from gyrostat.spacecraft.flexible.appendages import APPENDAGES
from gyrostat.wheel.friction import static_curve
from gyrostat.wheel.friction_laws import law_of

TRACKER_NOISE = np.radians(1.0)
"""Largest usual noise of a star tracker, rad."""
DENSITIES = 0.01, 20e3
"""Usual mean densities of a spacecraft, kg/m³: of a deployed sail, and of tungsten."""
SHARE = 0.02
"""Least usual radius of gyration over the half diagonal of the surfaces."""
FAR = 2.0
"""Largest usual distance of the centre of mass from the middle of the surfaces, over their half
diagonal."""
ARM = 10.0
"""Largest usual distance of the centre of mass from the origin, in radii of gyration."""
FARTHEST = 100.0
"""Largest usual distance where neither surfaces nor mass are known, m."""
OFFSET = 2.0
"""Largest usual sigma of a value of either sign, over the value: an offset may be near zero. Sigma
of a vector's component is usually at most the length of the vector."""
SPEEDS = np.linspace(0.0625, 1.0, 16)
"""Speeds at which friction is compared with the motor, over that of the momentum limit."""
DIAGONAL = ("body.inertia.xx", "body.inertia.yy", "body.inertia.zz")
ROUNDING = 1e-9
"""Relative excess of a bound that is due to rounding."""


def unlikely_numbers(scenario: Scenario) -> list[str]:
    """Lines on the numbers of a scenario and its spacecraft that are unlikely.

    Args:
        scenario: Scenario that was read, or restored from its text.
    """
    return _lines(
        Numbers(
            scenario.values,
            scenario.wheels,
            scenario.axes,
            law_of(scenario.friction, scenario.sources),
            scenario.surfaces,
            scenario.sensors,
            numbers_of(scenario),
            scenario.dispersions,
            scenario.requirements,
            scenario.command_delay,
        )
    )


def unlikely_spacecraft(file: SpacecraftFile) -> list[str]:
    """Lines on the numbers of a spacecraft file that are unlikely."""
    axes = np.asarray(file.spacecraft.wheels.axes).T.tolist()
    law = type(file.spacecraft.wheels.friction)
    values, rows = spacecraft_values(file), surface_rows(file)
    return _lines(Numbers(values, file.wheel_names, tuple(map(tuple, axes)), law, rows))


def _lines(numbers: Numbers) -> list[str]:
    """Lines of every function of this file."""
    checks = (_damping, _spreads, _tracker, _centre_of_mass, _mass, _friction, _angles, *LIMITS)
    return [f"unlikely: {key}: {text}" for check in checks for key, text in check(numbers)]


def _damping(numbers: Numbers) -> Lines:
    """Damping ratios above 1."""
    for key, value in numbers.values.items():
        name = key.rsplit(".", 1)[-1]
        of_mode = name == "damping" and key.split(".")[0] in APPENDAGES
        if (of_mode or name in ("radial_damping", "rocking_damping")) and value > 1.0:
            yield key, f"a damping ratio of {value:g} is above 1, the mode does not vibrate"


def _spreads(numbers: Numbers) -> Lines:
    """Standard deviations above the nominal value."""
    for each in numbers.dispersions:
        sigmas = distribution_of(each, numbers.values).deviation()
        for key, sigma in zip(each.keys, sigmas.tolist(), strict=True):
            nominal = abs(numbers.values[key])
            share = sigma / nominal if nominal > 0.0 else 0.0
            entry = numbers.entries.get(key)
            is_signed = entry is not None and entry.least < 0.0 and key not in DIAGONAL
            if share > (OFFSET if is_signed else 1.0) + ROUNDING:
                yield f"dispersion of {key}", f"sigma is {plain(100.0 * share)} % of the value"
            elif share > 1.0 and is_signed and entry is not None and entry.shape == (3,):
                vector = key.rsplit(".", 1)[0]
                length = np.linalg.norm([numbers.values[end] for end in entry.ends(vector)])
                if sigma > length * (1.0 + ROUNDING):
                    yield (
                        f"dispersion of {key}",
                        f"sigma is {plain(100.0 * share)} % of the value, and more than {vector}",
                    )


def _tracker(numbers: Numbers) -> Lines:
    """Noise of a star tracker, or of another attitude sensor."""
    for key, value in numbers.values.items():
        head = key.startswith("star_tracker.") and key.endswith(("across_sigma", "about_sigma"))
        if (head or key == "sensors.attitude_sigma") and value > TRACKER_NOISE * (1.0 + ROUNDING):
            yield key, f"a star tracker with {plain(degrees(value))} deg of noise"


def _extent(numbers: Numbers) -> tuple[Vector, float] | None:
    """Middle of the surfaces, (3,), and the radius of a sphere around them, m; None without."""
    if not numbers.surfaces:
        return None
    rows = np.array(numbers.surfaces)
    area, normal, centre = rows[:, 0], rows[:, 1:4], rows[:, 4:7]
    # the half width of a square facet, in its plane
    half = 0.5 * np.sqrt(area)[:, None] * np.sqrt(np.clip(1.0 - normal**2, 0.0, None))
    low, high = np.min(centre - half, axis=0), np.max(centre + half, axis=0)
    return 0.5 * (low + high), float(0.5 * np.linalg.norm(high - low))


def _gyration(numbers: Numbers) -> float | None:
    """Radius of gyration about the centre of mass, m: root of tr(J) / 2 / m; None without mass."""
    mass = numbers.values.get("body.mass")
    return None if mass is None else float(np.sqrt(0.5 * np.trace(numbers.inertia_locked()) / mass))


def _centre_of_mass(numbers: Numbers) -> Lines:
    """Centre of mass far outside the body."""
    key = "body.centre_of_mass"
    if f"{key}.x" not in numbers.values:
        return
    centre = np.array([numbers.values[end] for end in CENTRE_OF_MASS.ends(key)])
    extent, radius = _extent(numbers), _gyration(numbers)
    if extent is not None:
        distance, size = float(np.linalg.norm(centre - extent[0])), extent[1]
        if distance > FAR * size:
            yield (
                key,
                f"{plain(distance)} m from the middle of the surfaces, which reach {plain(size)} m",
            )
        return
    distance = float(np.linalg.norm(centre))
    if radius is not None and distance > ARM * radius:
        yield (
            key,
            f"{plain(distance)} m from the origin, with a radius of gyration of {plain(radius)} m",
        )
    elif radius is None and distance > FARTHEST:
        yield key, f"{plain(distance)} m from the origin of the body axes"


def _mass(numbers: Numbers) -> Lines:
    """Mass, inertia and size that do not belong to one body.

    A sphere with the radius of gyration k = root(tr(J) / 2 / m) has the radius root(5 / 3) k.
    """
    extent, radius = _extent(numbers), _gyration(numbers)
    mass = numbers.values.get("body.mass")
    if extent is not None:
        half = extent[1]
        least = 0.5 * float(np.trace(numbers.inertia_locked())) / half**2
        if radius is not None and not SHARE * half <= radius <= half:
            yield (
                "body.inertia",
                f"with body.mass it has a radius of gyration of {plain(radius)} m, but the "
                f"surfaces reach {plain(half)} m",
            )
        elif radius is None and least > DENSITIES[1] * 4.0 / 3.0 * pi * half**3:
            yield (
                "body.inertia",
                f"surfaces that reach {plain(half)} m need {plain(least)} kg for it, denser than "
                "tungsten",
            )
    if mass is None or radius is None:
        return
    density = mass / (4.0 / 3.0 * pi * (np.sqrt(5.0 / 3.0) * radius) ** 3)
    if not DENSITIES[0] <= density <= DENSITIES[1]:
        yield (
            "body.mass",
            f"with body.inertia it has a radius of gyration of {plain(radius)} m, which is a mean "
            f"density of {plain(float(density), 3)} kg/m³",
        )


def _friction(numbers: Numbers) -> Lines:
    """Friction that the motor cannot overcome, from rest to the speed of the momentum limit."""
    limits = numbers.of_wheels("torque_limit")
    if not np.any(np.isfinite(limits)):
        return
    law: Any = numbers.law
    curve = static_curve(law.of(**{name: numbers.of_wheels(name) for name in law.dimensions()}))
    fastest = numbers.of_wheels("momentum_limit") / numbers.of_wheels("inertia")
    speeds = np.where(np.isfinite(fastest), fastest, 0.0)
    at_rest = np.max([np.abs(curve.breakaway_torque(sense)) for sense in (1.0, -1.0)], axis=0)
    turning = [
        np.max([np.abs(curve.torque(jnp.asarray(s * x * speeds), s)) for s in (1.0, -1.0)], axis=0)
        for x in SPEEDS
    ]
    at_rest = np.broadcast_to(at_rest, limits.shape)
    turning = np.broadcast_to(turning, (len(SPEEDS), *limits.shape))
    for k, wheel in enumerate(numbers.wheels):
        index = int(np.argmax(turning[:, k]))
        speed = plain(float(SPEEDS[index] * speeds[k]))
        cases = ((at_rest[k], "at rest"), (turning[index, k], f"at {speed} rad/s"))
        for torque, condition in cases:
            if torque > limits[k]:
                yield (
                    f"wheel.{wheel}",
                    f"friction of {plain(float(torque))} N·m {condition} is above torque_limit, "
                    f"{plain(float(limits[k]))} N·m",
                )
                break


def _angles(numbers: Numbers) -> Lines:
    """Angles whose size suggests that a number without a unit was meant in degrees."""
    for key, entry in numbers.entries.items():
        value = numbers.values.get(key, 0.0)
        # a rotation vector or misalignment is at most half a turn
        most = pi if entry.shape == (3,) else tau
        if entry.unit == "rad" and isfinite(value) and abs(value) > most * (1.0 + ROUNDING):
            yield key, _in_degrees(value)
    for each in numbers.dispersions:
        parameters = DISTRIBUTIONS[each.distribution].parameters()
        for key, row in zip(each.keys, each.parameters, strict=True):
            entry = numbers.entries.get(key)
            if entry is None or entry.unit != "rad":
                continue
            for (name, parameter), value in zip(parameters.items(), row, strict=False):
                most = {VALUE: tau, DEVIATION: pi}.get(parameter.of, inf)
                if isfinite(value) and abs(value) > most * (1.0 + ROUNDING):
                    yield f"dispersion of {key}, {name}", _in_degrees(value)


def _in_degrees(value: float) -> str:
    return (
        f"{plain(value)} rad is {plain(degrees(value))} deg; a number without a unit is in rad, "
        f"for degrees write '{value:g} deg'"
    )
