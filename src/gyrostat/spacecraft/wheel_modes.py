"""Structural modes of a rotor in its elastic bearings: transmitted loads and whirl frequencies.

The rotor turns with the speed W about the z axis. Its displacement x + iy and its tilt u + iv about
the two axes across z are complex numbers, so that a motion exp(iwt) whirls forward (in the sense of
W > 0) for w > 0 and backward for w < 0. With the natural frequency n and the damping ratio z of a
mode at rest, and the ratio g of polar to transverse inertia of the rotor,

    translation:  a'' + 2 z n a' + n² a             = force / mass
    rocking:      q'' + 2 z n q' - i g W q' + n² q  = torque / transverse inertia

The gyroscopic term is perpendicular to the rate of tilt: it does no work. The undamped rocking mode
splits into whirls at w = g W / 2 ± √((g W / 2)² + n²), whose product is -n². The bearing transmits
2 z n q' + n² q times the inertia. R. A. Masterson, D. W. Miller, R. L. Grogan, "Development and
validation of reaction wheel disturbance models: empirical model", Journal of Sound and Vibration
249 (2002), section 3; G. Genta, "Dynamics of Rotating Systems" (2005), chapter 2.

The functions use operators alone, and take numbers and arrays of NumPy or JAX.
"""

from typing import Any, NamedTuple

import numpy as np

from gyrostat.core.types import Matrix


class Gain(NamedTuple):
    """Complex factor as its real and imaginary part."""

    real: Any
    imaginary: Any


def translation_gain(frequency: Any, natural: Any, damping: Any) -> Gain:
    """Transmitted part of a force on a rotor.

    Args:
        frequency: Angular frequency of the force; its sign is the sense of rotation, rad/s.
        natural: Natural frequency n, rad/s; infinite for a rigid bearing.
        damping: Damping ratio z.
    """
    ratio = frequency / natural
    return _transmitted(1.0 - ratio**2, 2.0 * damping * ratio)


def rocking_gain(
    frequency: Any, speed: Any, natural: Any, damping: Any, inertia_ratio: Any
) -> Gain:
    """Transmitted part of a torque across the axis of a rotor.

    Args:
        frequency: Angular frequency of the torque; its sign is the sense of rotation, rad/s.
        speed: Speed W of the rotor, rad/s.
        natural: Natural frequency n at rest, rad/s; infinite for a rigid bearing.
        damping: Damping ratio z at rest.
        inertia_ratio: Polar over transverse inertia g of the rotor.
    """
    return _transmitted(*_rocking(frequency, speed, natural, damping, inertia_ratio))


def rocking_power(
    frequency: Any, speed: Any, natural: Any, damping: Any, inertia_ratio: Any
) -> Any:
    """Square of the size of `rocking_gain`, which has the same arguments.

    Without inertia ratio it is also that of `translation_gain`.
    """
    stiffness, damped = _rocking(frequency, speed, natural, damping, inertia_ratio)
    square = damped**2
    return (1.0 + square) / (stiffness**2 + square)


def whirl_frequencies(speed: Any, natural: Any, inertia_ratio: Any) -> tuple[Any, Any]:
    """Frequencies of forward and backward whirl without damping, both positive, rad/s.

    Args:
        speed: Speed of the rotor, 0 or more, rad/s.
        natural: Natural frequency of the rocking mode at rest, rad/s.
        inertia_ratio: Polar over transverse inertia of the rotor.
    """
    half = 0.5 * inertia_ratio * speed
    root = (half**2 + natural**2) ** 0.5
    return half + root, root - half


def rocking_matrix(speed: float, natural: float, damping: float, inertia_ratio: float) -> Matrix:
    """State matrix of the free rocking mode in real coordinates, (4, 4).

    Args:
        speed: Speed of the rotor, rad/s.
        natural: Natural frequency at rest, rad/s.
        damping: Damping ratio at rest.
        inertia_ratio: Polar over transverse inertia of the rotor.

    Returns:
        Derivative of (u, v, u', v') over these.
    """
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    eye, zero = np.eye(2), np.zeros((2, 2))
    rate = inertia_ratio * speed * turn - 2.0 * damping * natural * eye
    return np.block([[zero, eye], [-(natural**2) * eye, rate]])


def _rocking(
    frequency: Any, speed: Any, natural: Any, damping: Any, inertia_ratio: Any
) -> tuple[Any, Any]:
    """Dynamic stiffness of a rocking mode over that at rest, real and imaginary part."""
    ratio = frequency / natural
    stiffer = inertia_ratio * (speed / natural) * ratio
    return 1.0 - ratio**2 + stiffer, 2.0 * damping * ratio


def _transmitted(stiffness: Any, damping: Any) -> Gain:
    """(1 + i damping) / (stiffness + i damping)."""
    size = stiffness**2 + damping**2
    return Gain((stiffness + damping**2) / size, damping * (stiffness - 1.0) / size)
