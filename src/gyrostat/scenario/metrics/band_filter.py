"""Streaming Butterworth filters of order 4, high pass and low pass, for metrics in a band.

Two second-order sections each, by the bilinear transform with prewarped cut-off frequency (A. V.
Oppenheim, R. W. Schafer, "Discrete-Time Signal Processing", sections 6.3 and 7.2). The amplitude
gain at the cut-off is 1/sqrt(2), with the warped frequency w = tan(pi f T):

    high pass |H| = 1 / sqrt(1 + (w_c / w)^8),    low pass |H| = 1 / sqrt(1 + (w / w_c)^8)

One octave inside the band the gain is above 0.998, one octave outside below 0.0625. The power of
white noise in the band is 2.6 % of a cut-off frequency higher than behind an ideal low pass, and as
much lower behind the high pass.
"""

from typing import NamedTuple

from jaxtyping import Array, Float

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp

DAMPING = (1.8477590650225735, 0.7653668647301796)
"""1/Q of the two sections: 2 cos(pi / 8) and 2 cos(3 pi / 8)."""


class Section(NamedTuple):
    """Coefficients of a second-order section; a0 is 1.

    Attributes:
        b: Coefficients b0, b1, b2 of the input.
        a: Coefficients a1, a2 of the output.
    """

    b: tuple[Scalar, Scalar, Scalar]
    a: tuple[Scalar, Scalar]


Sections = tuple[Section, ...]
States = Float[Array, "sections 2 *value"]
"""The two state variables of each section, in the transposed direct form II."""


def high_pass(frequency: Scalar, period: Scalar) -> Sections:
    """High pass with a cut-off frequency, Hz, at a sample period, s."""
    return _sections(frequency, period, low=False)


def low_pass(frequency: Scalar, period: Scalar) -> Sections:
    """Low pass with a cut-off frequency, Hz, at a sample period, s."""
    return _sections(frequency, period, low=True)


def _sections(frequency: Scalar, period: Scalar, *, low: bool) -> Sections:
    warped = jnp.tan(jnp.pi * frequency * period)
    squared = warped**2

    def section(damping: float) -> Section:
        scale = 1.0 / (1.0 + damping * warped + squared)
        outer = squared * scale if low else scale
        middle = 2.0 * outer if low else -2.0 * outer
        return Section(
            (outer, middle, outer),
            (2.0 * (squared - 1.0) * scale, (1.0 - damping * warped + squared) * scale),
        )

    return tuple(section(damping) for damping in DAMPING)


def at_rest(sections: Sections, value: Float[Array, "*value"]) -> States:
    """Steady state for a constant input; the first section is one of a high pass."""
    outer = sections[0].b[0] * value
    first = jnp.stack([-outer, outer])
    return jnp.stack([first, *(jnp.zeros_like(first) for _ in sections[1:])])


def filtered(
    sections: Sections, states: States, value: Float[Array, "*value"]
) -> tuple[States, Float[Array, "*value"]]:
    """Process one sample; returns the new states and the output.

    Args:
        sections: Sections, in the order in which the signal passes them.
        states: States from the last sample.
        value: Input.
    """
    after = []
    for ((b0, b1, b2), (a1, a2)), (first, second) in zip(sections, states, strict=True):
        output = b0 * value + first
        after.append(jnp.stack([b1 * value - a1 * output + second, b2 * value - a2 * output]))
        value = output
    return jnp.stack(after), value
