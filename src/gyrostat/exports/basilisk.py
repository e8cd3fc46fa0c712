"""Basilisk module that sets up the identified reaction wheel."""

import math

from gyrostat.core.errors import InputError
from gyrostat.exports.template import filled
from gyrostat.wheel import WheelModel
from gyrostat.wheel.friction import DirectionalStribeck, Friction, Stribeck, ViscousCoulomb


def basilisk(model: WheelModel) -> str:
    """Text of a Python module for Basilisk; its docstring lists the effects that are lost.

    Basilisk's Stribeck term peaks at betaStatic and falls as exp(-(w / betaStatic)² / 2); with
    betaStatic = w_s / √2 it falls as that of Carrara and Kuga, eq. (1).

    Args:
        model: Content of a model file.

    Raises:
        InputError: A parameter is missing, or Basilisk has no counterpart of the friction model.
    """
    wheel = model.wheel()
    curve = wheel.friction
    losses = [
        "it has no sticking: below omegaLimitCycle the friction is a straight line through zero, "
        "and a wheel that should rest creeps",
    ]
    if model.impossible:
        losses.insert(
            0, "the wheel is not valid: key validity.impossible of its model file says why"
        )
    if isinstance(curve, DirectionalStribeck):
        losses.append(_senses(curve))
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
        losses.append(
            "the Stribeck term acts only while the wheel speeds up from rest, and is zero at zero "
            f"speed: near zero up to {excess:.4g} N·m of friction are missing"
        )
    elif isinstance(curve, ViscousCoulomb):
        static = float(curve.coulomb)
    else:
        name = curve.name if isinstance(curve, Friction) else type(curve).__name__
        raise InputError(f"friction model: found {name}, expected one that Basilisk supports")
    return filled(
        "basilisk.py.txt",
        lost="\n".join(f"- {text}." for text in losses),
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
        "it is the same in both senses of rotation: this module uses the mean, and the Coulomb "
        f"torque is wrong by {off:.4g} N·m in each sense"
    )
