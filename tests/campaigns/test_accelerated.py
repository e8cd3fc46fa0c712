"""Runs of the small campaign with one run in each work item: a stand-in for CUDA computes them."""

import numpy as np
import pytest

from gyrostat.campaigns import accelerated
from gyrostat.campaigns.engine import fly
from gyrostat.campaigns.execute import chosen_engine
from gyrostat.campaigns.pointing.campaign import PointingBudget
from gyrostat.campaigns.ready import make_ready
from gyrostat.core.errors import InputError
from tests.codegen.stand_in import stand_in

pytestmark = pytest.mark.optimised_c
RUNS = [5, 77, 1000, 1003]


@pytest.fixture(scope="module")
def columns(small, scenario, tmp_path_factory):
    """Columns by the native engine, and by the stand-in for CUDA."""
    if small.engine == "jax":
        pytest.skip("not run: no C compiler")
    with pytest.MonkeyPatch.context() as patch:
        device, _ = stand_in(tmp_path_factory.mktemp("cuda"), patch, "-O0")
        patch.setattr(accelerated, "device", lambda engine: device)
        native = fly(scenario, small.seed, RUNS, engine="native").columns
        first = fly(scenario, small.seed, RUNS, engine="cuda").columns
        # as if there were no requirements: the percentiles are found on the device
        patch.setattr(PointingBudget, "needs_errors", lambda *given: False)
        others = fly(scenario, small.seed, RUNS[2:], engine="cuda").columns
        make_ready.cache_clear()
        return native, first, others


def test_metrics_are_those_of_the_native_engine(columns):
    native, ours, _ = columns
    assert native.keys() == ours.keys()
    largest = native["error_max"].max()
    for name, values in native.items():
        if values.dtype.kind != "f" or name in ("crossings", "status"):
            np.testing.assert_array_equal(ours[name], values, err_msg=name)
            continue
        finite = np.abs(values[np.isfinite(values)])
        scale = largest if "error_" in name else max(finite, default=1.0)
        tolerance = 1e-6 if values.dtype == np.float32 else 1e-10
        np.testing.assert_allclose(
            ours[name], values, rtol=tolerance, atol=tolerance * scale, err_msg=name
        )


def test_percentiles_of_the_device_are_those_of_all_errors(columns):
    _, ours, others = columns
    names = [name for name in ours if "error_" in name]
    assert sum("error_p" in name for name in names) >= 6
    for name in names:
        np.testing.assert_array_equal(others[name], ours[name][2:], err_msg=name)


def test_the_device_of_jax_is_not_that_of_an_engine(scenario):
    with pytest.raises(InputError, match="--engine cuda: found --device gpu, expected cpu"):
        chosen_engine("cuda", scenario, "gpu")
