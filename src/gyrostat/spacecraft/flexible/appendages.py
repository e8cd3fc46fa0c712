"""Modes of simple appendages from their geometry: a hinged panel, a slosh mass on a spring.

The motion of the body that keeps the centre of mass at rest is part of the modes. They also act in
free fall, where gravity accelerates all parts alike. All positions are from the centre of mass of
the undeformed spacecraft, whose inertia and mass include the appendages. To first order in the
deflection.
"""

from typing import Any

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.spacecraft.flexible.modes import FlexibleModes


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

    I_a = axis · inertia axis is the inertia about the hinge line. A spring of stiffness k and
    damping c gives the frequency sqrt(k / I_a) and the damping ratio c / (2 sqrt(k I_a)).

    Args:
        mass: Mass of the panel, kg.
        inertia: Inertia of the panel about the hinge, body axes, (3, 3), kg·m².
        hinge: Position of the hinge, body axes, (3,), m.
        centre: Centre of mass of the panel from the hinge, body axes, (3,), m.
        axis: Hinge line, body axes, of any length, (3,).
        frequency: Frequency on a body at rest, rad/s.
        damping: Damping ratio on a body at rest.
        spacecraft_mass: Mass of the spacecraft with the panel, kg.
    """
    line = _direction(axis)
    about_hinge = jnp.asarray(inertia) @ line
    moved = mass * jnp.cross(line, jnp.asarray(centre))
    turned = jnp.cross(jnp.asarray(hinge), moved) + about_hinge
    root = jnp.sqrt(line @ about_hinge)
    return _one(turned / root, moved / root, frequency, damping, spacecraft_mass)


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
    moved = jnp.sqrt(jnp.asarray(mass)) * _direction(direction)
    turned = jnp.cross(jnp.asarray(position), moved)
    return _one(turned, moved, frequency, damping, spacecraft_mass)


def _direction(line: Any) -> Vector3:
    line = jnp.asarray(line, dtype=float)
    return line / jnp.sqrt(line @ line)


def _one(turned: Vector3, moved: Vector3, frequency, damping, spacecraft_mass) -> FlexibleModes:
    """One mode from its angular and linear momentum per modal rate, body axes."""
    number, ratio = (jnp.reshape(jnp.asarray(x, dtype=float), 1) for x in (frequency, damping))
    return FlexibleModes(number, ratio, turned[None], moved[None] / jnp.sqrt(spacecraft_mass))
