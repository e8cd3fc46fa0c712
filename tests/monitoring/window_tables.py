"""Window tables of days with stated values, without telemetry."""

import numpy as np

from gyrostat.monitoring.windows import Windows

DAY = 86400.0
STATED = {"coulomb": 1e-3, "viscous": 1e-6, "motor_constant": 0.027, "offset": 0.0}


def window_table(days, wheel="a", low=150.0, high=250.0, sigma=0.01, **values):
    """Valid windows of one wheel, one for each of `days`; `values` are columns."""
    count = len(days)
    columns = {
        "start": np.asarray(days) * DAY,
        "end": (np.asarray(days) + 1.0) * DAY,
        "speed_min": np.full(count, low),
        "speed_max": np.full(count, high),
        "speed_mean": np.full(count, 0.5 * (low + high)),
        "noise_sigma": np.full(count, 1e-5),
        "noise_time": np.full(count, 1200.0),
        "valid": np.ones(count, bool),
    }
    for name, value in STATED.items():
        columns[name] = np.full(count, value)
        columns[f"{name}_sigma"] = np.full(count, sigma * (value or STATED["coulomb"]))
        columns[f"{name}_observable"] = np.full(count, name != "offset")
        columns[f"{name}_reason"] = ["the speed keeps one sign" * (name == "offset")] * count
    for name in ("coulomb_viscous", "coulomb_motor_constant", "coulomb_offset"):
        columns[f"cov_{name}"] = np.zeros(count)
    for name in ("viscous_motor_constant", "viscous_offset", "motor_constant_offset"):
        columns[f"cov_{name}"] = np.zeros(count)
    columns |= values
    names = list(columns)
    rows = zip(*columns.values(), strict=True)
    return Windows.of({"wheel": wheel, **dict(zip(names, row, strict=True))} for row in rows)
