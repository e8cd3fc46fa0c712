"""Friction models, one short file each; a new one is registered by its file alone."""

import sys

from gyrostat.core.classes_of import classes_of
from gyrostat.wheel.friction.base import Friction, parameter
from gyrostat.wheel.friction.bristles import AnyFriction, Bristles, static_curve
from gyrostat.wheel.friction.directional import DirectionalStribeck
from gyrostat.wheel.friction.lugre import LuGre
from gyrostat.wheel.friction.stribeck import DEFAULT_STRIBECK_SPEED, Stribeck, stribeck_torque
from gyrostat.wheel.friction.viscous_coulomb import ViscousCoulomb

FRICTION_MODELS: dict[str, type[Friction]] = {
    model.name: model
    for model in sorted(classes_of(sys.modules[__name__], Friction), key=lambda m: m.name)
}
"""Static friction models by name."""
WHEEL_FRICTION: dict[str, type[Friction] | type[Bristles]] = {
    **FRICTION_MODELS,
    **{law.name: law for law in classes_of(sys.modules[__name__], Bristles)},
}
"""Friction models of a model file and of the wheels of a spacecraft by name."""

__all__ = [
    "DEFAULT_STRIBECK_SPEED",
    "FRICTION_MODELS",
    "WHEEL_FRICTION",
    "AnyFriction",
    "Bristles",
    "DirectionalStribeck",
    "Friction",
    "LuGre",
    "Stribeck",
    "ViscousCoulomb",
    "parameter",
    "static_curve",
    "stribeck_torque",
]
