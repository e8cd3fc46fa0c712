"""Braking of failed wheels that still turn, and the settling time that such a wheel allows."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import equinox as eqx
import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.pictured import Described
from gyrostat.failures.feasibility import Holdable
from gyrostat.failures.recovery_plan import Loss, across, plane_normal
from gyrostat.spacecraft import Spacecraft
from gyrostat.wheel.friction import Stribeck, ViscousCoulomb


@dataclass(frozen=True)
class BrakeGain(Described):
    """What braking a failed wheel with the torque limit of its motor would bring.

    Attributes:
        torque: Torque limit, N·m.
        angle: Angle of the nearest feasible attitude from the target, rad; None if no attitude is
            feasible.
        earliest: Time before which no controller settles, s; None if the wheel does not limit it.
    """

    torque: float
    angle: float | None
    earliest: float | None


def with_brakes(spacecraft: Spacecraft, losses: Mapping[int, Loss]) -> Spacecraft:
    """Add the torque of each motor that still brakes, as dry friction, which ends at rest.

    Args:
        spacecraft: Spacecraft.
        losses: Index of each failed wheel -> its failure.

    Raises:
        InputError: A motor brakes a wheel whose friction model has no Coulomb torque to add it to.
    """
    torque = np.zeros(spacecraft.wheels.count)
    for wheel, loss in losses.items():
        torque[wheel] = loss.brake_torque
    if not torque.any():
        return spacecraft
    friction = spacecraft.wheels.friction
    if not isinstance(friction, ViscousCoulomb | Stribeck):
        raise InputError(
            f"brake torque: found wheels with {type(friction).__name__} friction, expected "
            "ViscousCoulomb or Stribeck, or a time constant as brake"
        )
    torques = {
        name: getattr(friction, name) + torque
        for name in ("coulomb", "static")
        if hasattr(friction, name)
    }
    wheels = eqx.tree_at(lambda w: w.friction, spacecraft.wheels, replace(friction, **torques))
    return replace(spacecraft, wheels=wheels)


def without_brakes(losses: Mapping[int, Loss]) -> dict[int, Loss]:
    """The same failures of wheels, none of which is braked."""
    return {
        wheel: replace(loss, brake_time=None, brake_torque=0.0) for wheel, loss in losses.items()
    }


def earliest_settling(
    spacecraft: Spacecraft,
    answer: Holdable,
    working: np.ndarray,
    wheel: int,
    *,
    momentum: float,
    loss: Loss,
    error: float,
) -> float | None:
    """Time before which a failed wheel that loses its momentum prevents settling.

    With two working directions, a momentum `m` of the failed wheel along its axis `a` displaces the
    feasible attitudes by `m |n . a| / rho`, with the normal `n` of the plane of the working wheels
    and the momentum `rho` in that plane. The bearing friction of the wheel, which stops it sooner,
    is neglected.

    Args:
        spacecraft: Spacecraft.
        answer: Feasible attitude for the stopped wheel.
        working: Whether each wheel works, (wheels,).
        wheel: Index of the failed wheel.
        momentum: Momentum of this wheel at the failure, along its axis, N·m·s.
        loss: Its failure; it runs down, or is braked.
        error: Largest angle to the feasible attitude that counts as settled, rad.

    Returns:
        Time after the failure, s; None if the working wheels do not span exactly two directions, or
        if the wheel keeps its momentum.
    """
    if answer.rank != 2 or answer.momentum_in_body is None or not loss.slows_down:
        return None
    normal = plane_normal(spacecraft, working)
    share = abs(float(normal @ np.asarray(spacecraft.wheels.axes)[:, wheel]))
    tolerance = across(spacecraft, working, answer.momentum_in_body) * error
    at_first = abs(momentum)
    if share * at_first <= tolerance:
        return 0.0
    at_last = tolerance / share
    # dm/dt = -rate m - torque
    rate, torque = loss.decay_rate, loss.brake_torque
    if rate == 0.0:
        return (at_first - at_last) / torque
    if at_last == 0.0 and torque == 0.0:
        return float("inf")
    return float(np.log((rate * at_first + torque) / (rate * at_last + torque)) / rate)
