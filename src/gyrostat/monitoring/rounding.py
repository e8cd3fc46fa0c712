"""Error of a mean from a rounded motor current.

Noise of standard deviation d before rounding to steps q leaves a mean error of variance
q² / (2 π²) exp(-4 π² d² / q²) (Widrow and Kollár, Quantization Noise, 2008, ch. 4): none to
speak of for d above q / 2. What is left changes as the slow friction noise wanders through
the steps.
"""

import numpy as np

from gyrostat.monitoring.blocks import Blocks
from gyrostat.monitoring.estimate import Estimate
from gyrostat.monitoring.moments import MOTOR


def rounding_variance(
    blocks: Blocks, wheel: int, value: Estimate, window: tuple[float, float], step: float | None
) -> float:
    """Variance that rounding adds to the mean Coulomb torque of a window, (N·m)².

    Args:
        blocks: Blocks of the window.
        wheel: Place of the wheel.
        value: Estimate of the window.
        window: Start and end, s.
        step: Resolution of the current, A; None: as its values show.
    """
    if step is None:
        step = float(np.min(blocks.step[:, wheel]))
    if not 0.0 < step < np.inf:
        return 0.0
    dither = np.maximum(blocks.scatter[:, wheel] ** 2 - step**2 / 12.0, 0.0)
    left = step**2 / (2.0 * np.pi**2) * np.exp(-4.0 * np.pi**2 * dither / step**2)
    wander = max(value.noise_sigma / value.value[MOTOR], 1e-12)
    kept = np.exp(value.noise.log_time) * (step / (2.0 * np.pi * wander)) ** 2
    share = min(1.0, 2.0 * kept / (window[1] - window[0]))
    return float(value.value[MOTOR] ** 2 * np.mean(left) * share)
