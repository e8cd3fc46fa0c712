"""Friction models, one short file each; a new static model is known everywhere by its file."""

import importlib
import pkgutil

from gyrostat.friction.base import Friction, Scalar, parameter
from gyrostat.friction.directional import DirectionalStribeck
from gyrostat.friction.lugre import LuGre, static_curve
from gyrostat.friction.stribeck import DEFAULT_STRIBECK_SPEED, Stribeck, stribeck_torque
from gyrostat.friction.viscous_coulomb import ViscousCoulomb

for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")

FRICTION_MODELS: dict[str, type[Friction]] = {
    model.name: model for model in sorted(Friction.__subclasses__(), key=lambda m: m.name)
}
"""Every friction model by its name."""

__all__ = [
    "DEFAULT_STRIBECK_SPEED",
    "FRICTION_MODELS",
    "DirectionalStribeck",
    "Friction",
    "LuGre",
    "Scalar",
    "Stribeck",
    "ViscousCoulomb",
    "parameter",
    "static_curve",
    "stribeck_torque",
]
