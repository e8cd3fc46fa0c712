"""Modes of simple appendages from their geometry: a hinged panel, a slosh mass on a spring.

The motion of the body that keeps the centre of mass at rest is part of the modes. They also act in
free fall, where gravity accelerates all parts alike. All positions are from the centre of mass of
the undeformed spacecraft, whose inertia and mass include the appendages. To first order in the
deflection.
"""

from collections.abc import Mapping
from typing import Any

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.spacecraft.flexible.modes import FlexibleModes
from gyrostat.spacecraft.spacecraft import Spacecraft

APPENDAGES: Mapping[str, Mapping[str, str]] = {
    "flexible": {"participation": "√kg·m", "translation": "√kg"},
    "hinged_panel": {
        "mass": "mass",
        "inertia": "inertia",
        "hinge": "length",
        "centre": "length",
        "axis": "1",
    },
    "slosh": {"mass": "mass", "position": "length", "direction": "1"},
}
"""Kind of appendage -> its keys in a spacecraft file, in addition to frequency and damping, and
their dimensions or units."""


def hinged_panel(
    mass: Scalar,
    inertia: Any,
    hinge: Any,
    centre: Any,
    axis: Any,
    *,
    frequency: Scalar,
    damping: Scalar,
    spacecraft_mass: Scalar,
) -> FlexibleModes:
    """Mode of a rigid panel on a hinge with a spring; for an angle a, q = sqrt(I_a) a.

    I_a is the inertia of the panel about the hinge line. A spring of stiffness k and damping c
    gives the frequency sqrt(k / I_a) and the damping ratio c / (2 sqrt(k I_a)).

    Args:
        mass: Mass of the panel, kg.
        inertia: Inertia of the panel about its centre of mass, body axes, (3, 3), kg·m².
        hinge: Position of a point of the hinge line, body axes, (3,), m.
        centre: Position of the centre of mass of the panel, body axes, (3,), m.
        axis: Direction of the hinge line, body axes, of any length, (3,).
        frequency: Frequency on a body at rest, rad/s.
        damping: Damping ratio on a body at rest.
        spacecraft_mass: Mass of the spacecraft with the panel, kg.
    """
    line, middle = _direction(axis), jnp.asarray(centre)
    linear = jnp.cross(line, middle - jnp.asarray(hinge))
    moment = jnp.asarray(inertia) @ line
    root = jnp.sqrt(line @ moment + mass * (linear @ linear))
    angular = jnp.cross(middle, mass * linear) + moment
    return _single_mode(angular / root, mass * linear / root, frequency, damping, spacecraft_mass)


def spring_mass(
    mass: Scalar,
    position: Any,
    direction: Any,
    *,
    frequency: Scalar,
    damping: Scalar,
    spacecraft_mass: Scalar,
) -> FlexibleModes:
    """Mode of a mass on a spring along a line, such as slosh; for a displacement x, q = sqrt(m) x.

    A spring of stiffness k and damping c gives the frequency sqrt(k / m) and the damping ratio
    c / (2 sqrt(k m)).

    Args:
        mass: Moving mass m, kg.
        position: Its position at rest, body axes, (3,), m.
        direction: Direction of its motion, body axes, of any length, (3,).
        frequency: Frequency on a body at rest, rad/s.
        damping: Damping ratio on a body at rest.
        spacecraft_mass: Mass of the spacecraft with the moving mass, kg.
    """
    linear = jnp.sqrt(jnp.asarray(mass)) * _direction(direction)
    angular = jnp.cross(jnp.asarray(position), linear)
    return _single_mode(angular, linear, frequency, damping, spacecraft_mass)


def _direction(line: Any) -> Vector3:
    line = jnp.asarray(line, dtype=float)
    return line / jnp.sqrt(line @ line)


def _single_mode(
    angular: Vector3, linear: Vector3 | None, frequency: Any, damping: Any, spacecraft_mass: Any
) -> FlexibleModes:
    """One mode from its angular and linear momentum per modal rate, body axes."""
    number, ratio = (jnp.reshape(jnp.asarray(x, dtype=float), 1) for x in (frequency, damping))
    share = None if linear is None else linear[None] / jnp.sqrt(spacecraft_mass)
    return FlexibleModes(number, ratio, angular[None], share)


def appendage_modes(kind: str, values: Mapping[str, Any], spacecraft: Spacecraft) -> FlexibleModes:
    """Modes of an appendage of a spacecraft file.

    Args:
        kind: Key of `APPENDAGES`.
        values: Values of its keys, SI; frequencies in Hz.
        spacecraft: Spacecraft with its mass and centre of mass.
    """

    def vector(name: str) -> Vector3:
        return jnp.stack([jnp.asarray(values[f"{name}.{end}"], dtype=float) for end in "xyz"])

    def point(name: str) -> Vector3:
        centre = spacecraft.centre_of_mass
        return vector(name) if centre is None else vector(name) - jnp.asarray(centre)

    mass: Any = spacecraft.mass
    fields: dict[str, Any] = {
        "frequency": 2.0 * jnp.pi * values["frequency"],
        "damping": values["damping"],
        "spacecraft_mass": mass,
    }
    if kind == "slosh":
        return spring_mass(values["mass"], point("position"), vector("direction"), **fields)
    if kind == "hinged_panel":
        xx, yy, zz, xy, xz, yz = (
            jnp.asarray(values[f"inertia.{end}"], dtype=float)
            for end in ("xx", "yy", "zz", "xy", "xz", "yz")
        )
        inertia = jnp.stack([jnp.stack(row) for row in ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))])
        return hinged_panel(
            values["mass"], inertia, point("hinge"), point("centre"), vector("axis"), **fields
        )
    linear = vector("translation") if "translation.x" in values else None
    return _single_mode(vector("participation"), linear, **fields)
