"""Basilisk module that sets up the identified reaction wheel."""

import math

from gyrostat.core.errors import InputError
from gyrostat.wheel import WheelModel
from gyrostat.wheel.friction import DirectionalStribeck, Friction, Stribeck, ViscousCoulomb

_MODULE = '''\
"""An identified reaction wheel for Basilisk (AVS Lab, University of Colorado), SI units.

What Basilisk's friction (reactionWheelStateEffector) cannot represent of it:
{lost}
"""

INERTIA = {inertia!r}  # kg·m²
MOTOR_CONSTANT = {motor_constant!r}  # N·m/A
FRICTION = {{
    "cViscous": {viscous!r},  # N·m·s/rad
    "fCoulomb": {coulomb!r},  # N·m
    "fStatic": {static!r},  # N·m
    "betaStatic": {beta!r},  # rad/s; below zero there is no Stribeck term
}}


def add_wheel(factory, spin_axis, **options):
    """Add the wheel to a `simIncludeRW.rwFactory`.

    Args:
        factory: the factory.
        spin_axis: three numbers, body axes.
        options: of `factory.create`, as Omega (rpm), rWB_B, label. There is no limit of the motor
            torque unless they set one.

    Returns:
        Basilisk's configuration of the wheel.
    """
    wheel = {{"Js": INERTIA, "useRWfriction": True, "useMaxTorque": False, **FRICTION}}
    return factory.create("custom", spin_axis, **(wheel | options))


def motor_torque(current):
    """Motor torque, N·m, of a current, A: what Basilisk takes as the wheel's command."""
    return MOTOR_CONSTANT * current
'''


def basilisk(model: WheelModel) -> str:
    """Text of a Python module for Basilisk; its docstring says what is lost.

    Basilisk's Stribeck term peaks at betaStatic and falls as exp(-(w / betaStatic)² / 2); with
    betaStatic = w_s / √2 it falls as that of Carrara and Kuga, eq. (1).

    Args:
        model: content of a model file.

    Raises:
        InputError: a parameter is missing, or Basilisk has no counterpart of the friction model.
    """
    wheel = model.wheel()
    curve = wheel.friction
    lost = [
        "it has no sticking: below omegaLimitCycle the friction is a straight line through zero, "
        "and a wheel that should rest creeps",
    ]
    if isinstance(curve, DirectionalStribeck):
        lost.append(_senses(curve))
        curve = Stribeck(
            viscous=0.5 * (curve.viscous_positive + curve.viscous_negative),
            coulomb=0.5 * (curve.coulomb_positive + curve.coulomb_negative),
            static=0.5 * (curve.static_positive + curve.static_negative),
            stribeck_speed=curve.stribeck_speed,
        )
    beta, static = -1.0, 0.0
    if isinstance(curve, Stribeck):
        static, excess = float(curve.static), float(curve.static) - float(curve.coulomb)
        beta = float(curve.stribeck_speed) / math.sqrt(2.0)
        lost.append(
            "the Stribeck term acts only while the wheel speeds up from rest, and is zero at zero "
            f"speed: near zero up to {excess:.4g} N·m of friction are missing"
        )
    elif isinstance(curve, ViscousCoulomb):
        static = float(curve.coulomb)
    else:
        raise InputError(f"friction model: found {_name(curve)}, expected one that Basilisk knows")
    return _MODULE.format(
        lost="\n".join(f"- {text}." for text in lost),
        inertia=float(wheel.inertia),
        motor_constant=float(wheel.motor_constant),
        viscous=float(curve.viscous),
        coulomb=float(curve.coulomb),
        static=static,
        beta=beta,
    )


def _senses(curve: DirectionalStribeck) -> str:
    off = 0.5 * abs(float(curve.coulomb_positive) - float(curve.coulomb_negative))
    return (
        "it is the same in both senses of rotation: this has the mean, and the Coulomb torque is "
        f"off by {off:.4g} N·m in each"
    )


def _name(curve: object) -> str:
    return curve.name if isinstance(curve, Friction) else type(curve).__name__
