"""Streaming Butterworth filters against SciPy, and exposures that do not end."""

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from gyrostat.core.jax64 import jnp
from gyrostat.scenario.metrics.band_filter import high_pass, low_pass
from gyrostat.scenario.metrics.exposures import exposed, no_exposures


@pytest.mark.parametrize("share", [0.004, 0.1, 0.4])
@pytest.mark.parametrize(("kind", "design"), [("low", low_pass), ("high", high_pass)])
def test_sections_are_those_of_a_butterworth_filter_of_fourth_order(kind, design, share):
    period = 0.125
    impulse = np.eye(1, 400)[0]
    rows = [[*section.b, 1.0, *section.a] for section in design(share / period, period)]
    expected = sosfilt(butter(4, 2.0 * share, kind, output="sos"), impulse)
    np.testing.assert_allclose(sosfilt(np.array(rows, float), impulse), expected, atol=1e-12)


def test_no_angle_before_the_first_exposure_ends():
    seen, angles = no_exposures(), []
    for angle in (0.0, 0.1, 0.2, 0.3):
        direction = jnp.array([np.cos(angle), np.sin(angle), 0.0])
        seen, largest = exposed(seen, direction, jnp.array(True), jnp.array(2.0))
        angles.append(float(largest))
    assert angles[:2] == [-np.inf, -np.inf]
    assert angles[2:] == pytest.approx([0.2, 0.2])
