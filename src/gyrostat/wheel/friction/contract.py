"""Contract of static friction laws: what every one must be, whoever wrote it.

A law is checked where concrete values enter, never on trial values of a fit or on traced ones.
"""

import dataclasses
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import si_unit
from gyrostat.core.user_errors import reported
from gyrostat.wheel.friction.sampled_curve import SampledCurve, sampled_curve

ROUNDING = 1e-9
"""Part of the largest torque that counts as zero."""
UNDECLARED = 4.0
"""Factor by which a curve may bend over less than its `speed_scale`."""
HIDDEN = 0.05
"""Curvature over the bend between rest and a speed, below which this speed does not show it."""
RUN = 8
"""Number of sampled speeds of a straight line, which span a factor of two."""
DEEP = 0.01
"""Smallest bend between rest and a speed that matters, over the torque."""


def check_signs(law: Any) -> None:
    """Validate the signs of the parameters of a law.

    Raises:
        InputError: A parameter is not finite, has the wrong sign or is no number.
    """
    for name, value in law.parameters().items():
        dimension = law.dimensions()[name]
        unit = si_unit(dimension)
        try:
            every = np.asarray(value, dtype=float)
        except (TypeError, ValueError):
            raise InputError(f"{name}: found {value!r}, expected a number, {unit}") from None
        expected = f"value {'above 0' if dimension == 'speed' else 'of 0 or more'}"
        sound = every > 0.0 if dimension == "speed" else every >= 0.0
        if name in law.signed():
            sound, expected = True, "value"
        # a bend at an infinite speed is none
        limited = ~np.isnan(every) if dimension == "speed" else np.isfinite(every)
        bad = ~(limited & sound)
        if np.any(bad):
            found = every[bad].flat[0]
            raise InputError(f"{name}: found {found:g}, expected a finite {expected} {unit}")


RESERVED = frozenset(
    (
        *("inertia", "motor_constant", "current_bias", "initial_speed", "speed", "name", "title"),
        *("viscous_per_degC", "dry_per_degC", "kind", "python", "model", "wheel", "time", "factor"),
        *("data",),
        *("rise_time", "torque_limit", "momentum_limit", "static_imbalance", "dynamic_imbalance"),
        *("position", "angle", "radial_frequency", "radial_damping", "rocking_frequency"),
        *("rocking_damping", "inertia_ratio", "wear", "time_constant", "current_limit"),
        *("current_quantum", "bus_voltage", "resistance"),
    )
)
"""Names of other values of a wheel, of its records and of events, which no parameter can have."""


@lru_cache(maxsize=64)
def check_law(law: Any) -> None:
    """Validate a class of laws, without values of its parameters.

    Raises:
        InputError: The class is incomplete, or its torque is not one real number for one speed.
    """
    name = law.__name__
    methods = sorted(getattr(law, "__abstractmethods__", ()))
    if methods:
        raise InputError(
            f"{name}: found no method {methods[0]}, expected it (gyrostat.wheel.friction.base)"
        )
    fields = [field for field in dataclasses.fields(law) if field.name not in law.dimensions()]
    plain_fields = [field.name for field in fields if not field.metadata.get("static")]
    if plain_fields:
        raise InputError(f"{name}: found a field {plain_fields[0]}, expected `= parameter(UNIT)`")
    if not law.dimensions():
        raise InputError(f"{name}: found no parameter, expected fields `= parameter(UNIT)`")
    bases = [vars(base) for base in law.__mro__ if base.__module__.startswith("gyrostat.")]
    names = [n for n in law.dimensions() if n in RESERVED or any(n in scope for scope in bases)]
    if names and not law.is_shipped():
        raise InputError(f"{name}: found a parameter {names[0]}, a name with another meaning here")
    tied = {*law.held_by_default, *law.vanishing_at, *law.vanishing_at.values()}
    if tied - set(law.dimensions()):
        raise InputError(
            f"{name}: found {min(tied - set(law.dimensions()))} in held_by_default or vanishing_at,"
            f" expected one of {', '.join(law.dimensions())}"
        )
    for shape in ((), (3,)):
        arg = jax.ShapeDtypeStruct(shape, float)
        with reported(name):
            torque = jax.eval_shape(_torque(law), [arg] * len(law.dimensions()), arg, arg)
        if not isinstance(torque, jax.ShapeDtypeStruct) or torque.shape != shape:
            raise InputError(
                f"{name}: found {_describe(torque)} from torque, expected "
                + ("one number for one speed" if shape == () else "as many numbers as wheels")
            )
        if not jnp.issubdtype(torque.dtype, jnp.floating):
            raise InputError(f"{name}: found {torque.dtype} from torque, expected real numbers")


def _torque(law: Any) -> Any:
    """Torque of a law as a function of its parameters, speed and direction."""

    def torque(theta, speed, direction):
        friction = law.of(**dict(zip(law.dimensions(), theta, strict=True)))
        return jax.tree.map(jnp.asarray, friction.torque(speed, direction))

    return torque


def _describe(value: Any) -> str:
    shape = getattr(value, "shape", None)
    return type(value).__name__ if shape is None else f"an array of shape {shape}"


def check_curve(law: Any) -> None:
    """Validate the friction curve of a law with concrete parameters, one set or one for each wheel.

    Raises:
        InputError: The curve is not finite, jumps at zero speed, drives the wheel, is not odd where
            it should be, or bends over less than its `speed_scale`.
    """
    values = [np.asarray(value, dtype=float) for value in law.parameters().values()]
    rows = np.stack([part.ravel() for part in np.broadcast_arrays(*values)], axis=1)
    for theta in np.unique(rows, axis=0):
        fault = curve_fault(type(law), theta)
        if fault:
            raise InputError(f"{type(law).__name__}: {fault}")


def start_fault(law: Any, theta: Any) -> str:
    """What a law breaks of the contract at start values of a fit; see `curve_fault`.

    A coefficient that starts at zero does not show its sign in the curve, and is tried at rest.

    Args:
        law: Class of the law.
        theta: Parameters in order, (n,), SI.
    """
    fault = curve_fault(law, theta)
    if fault:
        return fault
    free = [n in law.coefficients() and n not in law.signed() for n in law.dimensions()]
    trial = np.where(np.array(free) & (np.asarray(theta) == 0.0), 1.0, theta)
    for sense in (1.0, -1.0):
        curve = sampled_curve(law, trial, sense)
        fault = fault or _at_rest(curve, f"{sense:+g}", float(np.max(np.abs(curve.torque))))
    return fault


def curve_fault(law: Any, theta: Any) -> str:
    """What a friction curve breaks of the contract, and what is expected; empty if nothing.

    Args:
        law: Class of the law.
        theta: Parameters in order, (n,), SI.
    """
    with reported(law.__name__):
        positive, negative = (sampled_curve(law, theta, sense) for sense in (1.0, -1.0))
    size = max(np.max(np.abs(curve.torque)) for curve in (positive, negative))
    for curve, sense in ((positive, "+1"), (negative, "-1")):
        fault = _not_finite(law, curve) or _at_rest(curve, sense, size) or _driving(curve, size)
        if fault:
            return fault
    asymmetry = np.abs(positive.torque - negative.torque)
    worst = int(np.argmax(asymmetry))
    if law.odd and asymmetry[worst] > ROUNDING * size:
        return (
            f"found {positive.torque[worst]:.4g} N·m at {positive.speed[worst]:.3g} rad/s and "
            f"{-negative.torque[worst]:.4g} N·m at the opposite speed, expected opposite torques; "
            "or write `odd = False` in the class"
        )
    return _bends(law, theta, positive, size) or _bends(law, theta, negative, size)


def _not_finite(law: Any, curve: SampledCurve) -> str:
    for item, values in (
        ("torque", curve.torque),
        ("derivative of torque by speed", curve.slope),
        *zip(
            (f"derivative of torque by {name}" for name in law.dimensions()),
            curve.by_parameters.T,
            strict=True,
        ),
    ):
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            speed = curve.speed[bad[0]]
            return f"found the {item} {values[bad[0]]:g} at {speed:.3g} rad/s, expected it finite"
    return ""


def _at_rest(curve: SampledCurve, sense: str, size: float) -> str:
    """Fault of a curve at zero speed."""
    below, rest, above = curve.torque[:3]
    width = curve.speed[2] - curve.speed[0]
    steepest = 2.0 * width * np.max(np.abs(curve.slope[:3]))
    if np.ptp([below, rest, above]) > 1e-3 * ROUNDING * size + steepest:
        return (
            f"found torques {below:.4g}, {rest:.4g} and {above:.4g} N·m just below, at and above "
            f"zero speed with direction {sense}, expected a curve without a jump: the sense of "
            "rotation is `direction`, not the sign of the speed"
        )
    if rest < -ROUNDING * size:
        return (
            f"found {float(sense) * rest:.4g} N·m at zero speed in direction {sense}, expected "
            f"{'0 or more' if sense == '+1' else '0 or less'}: friction opposes the motion"
        )
    return ""


def _driving(curve: SampledCurve, size: float) -> str:
    """Fault of a curve that puts power into the wheel."""
    bad = np.flatnonzero(curve.torque[1:] < -ROUNDING * size)
    if not len(bad):
        return ""
    torque, speed = curve.torque[1:][bad[0]], curve.speed[1:][bad[0]]
    return (
        f"found {torque:.4g} N·m along the motion at {speed:.4g} rad/s, which drives the wheel, "
        f"expected friction that opposes the motion up to {curve.speed[-1]:g} rad/s (speed_range)"
    )


def _bends(law: Any, theta: Any, curve: SampledCurve, size: float) -> str:
    """Fault of a curve that bends over less than its `speed_scale`, which steps would skip."""
    values = dict(zip(law.dimensions(), np.asarray(theta).tolist(), strict=True))
    with reported(law.__name__), jax.ensure_compile_time_eval():
        scale = float(law.of(**values).speed_scale())
    if not scale > 0.0:
        return f"found the speed_scale {scale:g} rad/s, expected more than 0"
    speed, torque, slope, bend = (part[1:] for part in curve[:4])
    reach = np.sqrt(np.abs(torque) + ROUNDING * size) / np.sqrt(np.abs(bend) + 1e-300)
    # a power of the speed bends over the speed itself, which no step skips
    tight = reach < np.minimum(0.5 * speed, scale / UNDECLARED)
    # a straight line far from rest, not at a point of inflection, that leads to another torque at
    # rest
    offset = np.abs(torque - torque[0] - slope * speed)
    line = (np.abs(bend) * speed**2 < HIDDEN * offset) & (offset > DEEP * np.abs(torque))
    is_line = np.append(sliding_window_view(line, RUN).all(axis=1), np.zeros(RUN - 1, bool))
    tight |= is_line & (speed < scale)
    if size == 0.0 or not np.any(tight):
        return ""
    return (
        f"found a curve that bends below {speed[int(np.argmax(tight))]:.2g} rad/s and a speed_scale"
        f" of {scale:g} rad/s, expected a method speed_scale that returns the range of speed over "
        "which the curve bends"
    )


def is_free_at_rest(law: Any) -> bool:
    """Whether a law with concrete parameters has no friction at rest, so that it never sticks."""
    with jax.ensure_compile_time_eval():
        levels = [np.asarray(law.breakaway_torque(sense)) for sense in (1.0, -1.0)]
    return bool(np.any(np.equal(levels, 0.0)))
