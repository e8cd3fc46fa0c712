"""Peers of the monitor: daily numbers that operators and papers use, with their change detection.

Each peer turns a day of telemetry into one number a wheel, which a two-sided CUSUM watches; mean
and standard deviation are those of the first 20 days. The isolation forest takes all numbers of a
day together. Thresholds are set on tuning flights, for the same rate of false alarms.
"""

import numpy as np

BLOCK = 60.0
FIRST = 20
"""Days that give a peer its mean and standard deviation."""
NUMBERS = ("ols_coulomb", "ols_viscous", "current_at_speed", "delta_torque", "scatter")


def daily_numbers(samples, wheel, speeds):
    """Numbers of a day for each wheel: name of `NUMBERS` -> (4,).

    Args:
        samples: Samples of the day.
        wheel: Nominal wheel.
        speeds: Usual speeds of the wheels, (4,), rad/s; NaN on the first day.
    """
    number = np.floor(samples.time / BLOCK)
    first = np.flatnonzero(np.diff(number, prepend=-np.inf))
    count = np.diff(np.append(first, samples.time.size))
    full = count >= 0.9 * np.median(count)
    drive, speed = (
        np.add.reduceat(x, first, axis=0) / count[:, None] for x in (samples.drive, samples.speed)
    )
    ends = np.append(first[1:], samples.time.size) - 1
    span = np.maximum(samples.time[ends] - samples.time[first], 1.0)[:, None]
    change = (samples.speed[ends] - samples.speed[first]) / span
    torque = wheel.motor_constant * drive - wheel.inertia * change
    found = {name: np.full(4, np.nan) for name in NUMBERS}
    for k in range(4):
        there = full & (np.abs(speed[:, k]) > 5.0)
        if np.sum(there) < 30:
            continue
        sign, w = np.sign(speed[there, k]), speed[there, k]
        columns = np.column_stack([sign, w])
        (coulomb, viscous), *_ = np.linalg.lstsq(columns, torque[there, k], rcond=1e-6)
        delta = sign * torque[there, k] - wheel.coulomb - wheel.viscous * np.abs(w)
        usual = speeds[k] if np.isfinite(speeds[k]) else np.median(np.abs(w))
        near = np.abs(np.abs(w) - usual) < 0.15 * usual
        found["ols_coulomb"][k], found["ols_viscous"][k] = coulomb, viscous
        found["delta_torque"][k], found["scatter"][k] = np.mean(delta), np.std(delta)
        if np.sum(near) >= 10:
            found["current_at_speed"][k] = np.mean((sign * drive[there, k])[near])
    return found


def standardised(values):
    """Values less the mean of the first days, over their standard deviation."""
    start = values[:FIRST][np.isfinite(values[:FIRST])]
    if start.size < 5:
        return np.zeros_like(values)
    scale = max(np.std(start, ddof=1), 1e-12 * abs(np.mean(start)) + 1e-300)
    return np.nan_to_num((values - np.mean(start)) / scale)


def cusum(values, slack=0.5):
    """Two-sided CUSUM of standardised values, (N,)."""
    up = down = 0.0
    path = np.zeros(values.size)
    for k, value in enumerate(values):
        up, down = max(0.0, up + value - slack), max(0.0, down - value - slack)
        path[k] = max(up, down) if k >= FIRST else 0.0
    return path


def kalman_trend(values):
    """Slope of a local linear trend in its standard deviations, without sign, (N,)."""
    mean, covariance = np.array([values[0], 0.0]), np.diag([1.0, 0.01])
    move, path = np.array([[1.0, 1.0], [0.0, 1.0]]), np.zeros(values.size)
    for k, value in enumerate(values):
        mean, covariance = move @ mean, move @ covariance @ move.T + np.diag([1e-4, 1e-4])
        gain = covariance[:, 0] / (covariance[0, 0] + 1.0)
        mean = mean + gain * (value - mean[0])
        covariance = covariance - np.outer(gain, covariance[0])
        path[k] = abs(mean[1]) / np.sqrt(covariance[1, 1]) if k >= FIRST else 0.0
    return path


def forest(tables):
    """Isolation forest: score of each day of each wheel, (wheels, N); None without scikit-learn.

    Args:
        tables: Standardised numbers of each wheel, (wheels, N, numbers).
    """
    try:
        from sklearn.ensemble import IsolationForest
    except ImportError:
        return None
    healthy = np.concatenate([each[:FIRST] for each in tables])
    model = IsolationForest(n_estimators=100, random_state=0).fit(healthy)
    scores = [-model.score_samples(each) for each in tables]
    # the mean of five days, as one odd day is no fault
    smooth = np.stack([np.convolve(s, np.ones(5) / 5.0)[: s.size] for s in scores])
    smooth[:, :FIRST] = 0.0
    return smooth


def paths(numbers):
    """Statistic of each peer over time for each wheel: name -> (wheels, N).

    Args:
        numbers: Name of `NUMBERS` -> (wheels, N).
    """
    scaled = {name: np.stack([standardised(v) for v in numbers[name]]) for name in NUMBERS}
    result = {
        "daily least squares": np.stack(
            [
                np.maximum(cusum(c), cusum(v))
                for c, v in zip(scaled["ols_coulomb"], scaled["ols_viscous"], strict=True)
            ]
        ),
        "CUSUM of current at speed": np.stack([cusum(v) for v in scaled["current_at_speed"]]),
        "Kalman trend of delta torque": np.stack([kalman_trend(v) for v in scaled["delta_torque"]]),
    }
    scores = forest(np.stack([scaled[name] for name in NUMBERS], axis=-1))
    return result | ({} if scores is None else {"isolation forest": scores})
