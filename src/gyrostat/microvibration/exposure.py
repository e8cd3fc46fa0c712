"""What a motion of the line of sight does to an exposure: shift, smear, jitter, and the MTF.

In an exposure of duration T a motion exp(iwt) has a mean, a line of least squares and a rest, whose
mean squares over the exposure, for x = w T / 2 and spherical Bessel functions j, are

    shift   j0(x)²            the image is displaced
    smear   3 j1(x)²          it drifts: the end differs from the start by 2 √3 times its rms
    jitter  1 - j0² - 3 j1²   the rest

and those of an error of pointing over windows in ECSS-E-ST-60-10C (2008): the relative error (RPE)
1 - j0², the drift of the mean between two windows (PDE) 4 sin²(w D / 2) j0² with the distance D of
their starts. R. L. Lucke, S. W. Sirlin, A. M. San Martin, "New definitions of pointing stability:
AC and DC effects", Journal of the Astronautical Sciences 40 (1992); M. E. Pittelkau, "Definitions,
metrics and algorithms for displacement, jitter and stability", AAS 03-559 (2003).
"""

from typing import Any

import numpy as np
from scipy.special import j0 as bessel
from scipy.special import spherical_jn

from gyrostat.core.types import Vector


def shift_weight(frequency: Any, exposure: float) -> Any:
    """Share of the mean square that displaces the image.

    Args:
        frequency: Angular frequency of the motion, rad/s.
        exposure: Duration, s.
    """
    return spherical_jn(0, 0.5 * np.abs(frequency) * exposure) ** 2


def smear_weight(frequency: Any, exposure: float) -> Any:
    """Share of the mean square that is a drift during the exposure; see `shift_weight`."""
    return 3.0 * spherical_jn(1, 0.5 * np.abs(frequency) * exposure) ** 2


def jitter_weight(frequency: Any, exposure: float) -> Any:
    """Share of the mean square that is neither shift nor drift; see `shift_weight`."""
    x = 0.5 * np.abs(frequency) * exposure
    # the three shares add up to 1, but the difference has no digits left for a slow motion
    slow = 4.0 / 45.0 * 0.25 * x**4
    fast = 1.0 - shift_weight(frequency, exposure) - smear_weight(frequency, exposure)
    return np.where(x < 1e-2, slow, np.maximum(fast, 0.0))


def relative_weight(frequency: Any, exposure: float) -> Any:
    """Share of the mean square about the mean of a window: RPE of ECSS; see `shift_weight`."""
    return smear_weight(frequency, exposure) + jitter_weight(frequency, exposure)


def drift_weight(frequency: Any, exposure: float, apart: float) -> Any:
    """Mean square of the difference of the means of two windows, over that of the motion.

    Args:
        frequency: Angular frequency of the motion, rad/s.
        exposure: Duration of each window, s.
        apart: Time from the start of one to that of the other, s.
    """
    return 4.0 * np.sin(0.5 * frequency * apart) ** 2 * shift_weight(frequency, exposure)


def gaussian_mtf(detail: Any, sigma: Any) -> Any:
    """MTF of normal jitter: exp(-2 pi² s² f²).

    Args:
        detail: Spatial frequency f, cycles/rad.
        sigma: Standard deviation s of the line of sight along the detail, rad.
    """
    return np.exp(-2.0 * (np.pi * np.asarray(sigma) * detail) ** 2)


def smear_mtf(detail: Any, length: Any) -> Any:
    """MTF of a linear drift by a length, rad, during the exposure: |sinc(f d)|."""
    return np.abs(np.sinc(np.asarray(length) * detail))


def sinusoid_mtf(detail: Any, amplitude: Any) -> Any:
    """MTF of a sine of an amplitude, rad, over many periods: |J0(2 pi f a)|."""
    return np.abs(bessel(2.0 * np.pi * np.asarray(amplitude) * detail))


def mtf(detail: Vector, frequency: Vector, amplitude: Vector, sigma: float, exposure: float) -> Any:
    """MTF of independent tones and noise in an exposure, the mean over their phases, (details,).

    The drift of a tone with its random phase has a length 2 √3 r √2 cos(phase), where r is its rms;
    its rest is a sine of the amplitude that has its mean square.

    Args:
        detail: Spatial frequencies, (details,), cycles/rad.
        frequency: Angular frequencies of the tones, (tones,), rad/s.
        amplitude: Their amplitudes along the detail, (tones,), rad.
        sigma: Standard deviation of the noise within an exposure, rad.
        exposure: Duration, s.
    """
    rest = amplitude * np.sqrt(jitter_weight(frequency, exposure))
    product = np.prod(sinusoid_mtf(detail[:, None], rest), axis=1) * gaussian_mtf(detail, sigma)
    drift = amplitude * np.sqrt(smear_weight(frequency, exposure))
    total = float(np.sqrt(np.sum(drift**2)))
    phase = np.pi * (np.arange(32) + 0.5) / 32.0
    lengths = 2.0 * np.sqrt(3.0) * total * np.cos(phase)
    return product * smear_mtf(detail[:, None], lengths).mean(axis=1)
