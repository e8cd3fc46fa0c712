"""Keys of the metrics of a scenario file, and the metrics of a run."""

from math import inf, pi

from gyrostat.campaigns.schema import Key, positive, size

METRICS: dict[str, Key] = {
    "after": size("time", 0.0, "Start of the interval that error and crossing metrics evaluate."),
    "settled_angle": positive("angle", 0.1 * pi / 180.0, "Settling threshold: pointing error."),
    "settled_rate": positive(
        "speed", 0.01 * pi / 180.0, "Settling threshold: body rate relative to the reference."
    ),
    "crossing_window": positive(
        "time", 10.0, "Time after a zero crossing in which `crossing_peak` is evaluated."
    ),
}
WINDOW: dict[str, Key] = {
    "from": size("time", 0.0, "Start of the window, which includes a sample at this time."),
    "until": size(
        "time",
        inf,
        "End of the window, which includes a sample at this time; none: the next slew for a window "
        "of an event, otherwise the end of the run.",
    ),
    "exposure": positive(
        "time", None, "Exposure time of `smear`; a whole number of control periods."
    ),
    "jitter_above": positive("frequency", None, "Lower cut-off frequency of `jitter`."),
    "jitter_below": positive("frequency", None, "Upper cut-off frequency of `jitter`."),
    "dwell_above": size("speed", 0.0, "Lower end of the wheel speeds of `dwell`, of either sign."),
    "dwell_below": positive("speed", None, "Upper end of the wheel speeds of `dwell`."),
}
"""Keys of a window; those without default are optional, and each adds a metric."""
REQUIREMENT: dict[str, Key] = {
    "value": positive("angle", None, "Required value of the index."),
    "level": positive(
        "1", None, 'Probability that it is not exceeded, such as 0.997 or "99.7 %".', most=1.0
    ),
    "window": positive("time", None, "Window of the mean; a whole number of control periods."),
    "stability": positive(
        "time",
        None,
        "Time from the start of one window of PDE to that of the other, at least one window.",
    ),
    "share": positive(
        "1", 0.95, "Share of the runs of which a temporal requirement holds.", most=1.0
    ),
}
"""Numbers of a pointing requirement."""
RESULTS: dict[str, tuple[str, str]] = {
    "error_max": ("rad", "Largest pointing error after `metrics.after`."),
    "error_rms": ("rad", "Root mean square of the pointing error after `metrics.after`."),
    "error_end": ("rad", "Pointing error at the end of the run."),
    "settling": (
        "s",
        "Time after which pointing error and rate error stay settled until the end; none: never.",
    ),
    "crossings": ("1", "Number of times that a wheel reaches zero speed after `metrics.after`."),
    "crossing_peak": (
        "rad",
        "Largest pointing error within `metrics.crossing_window` after a zero crossing; none: no "
        "crossing.",
    ),
    "momentum_peak": ("N·m·s", "Largest momentum of any wheel."),
    "torque_peak": ("N·m", "Largest motor torque commanded to any wheel."),
    "torque_rms": ("N·m", "Root mean square of the commanded motor torques of all wheels."),
    "saturated": (
        "1",
        "Fraction of time in which any wheel is at a limit of torque, momentum or driver.",
    ),
    "energy": ("J", "Mechanical work of the commanded torques; braking counts as positive."),
}
"""Metric -> its unit and meaning, except the percentiles of the pointing error."""
PERCENTILE = ("rad", "Percentile of the pointing error over the time after `metrics.after`.")
"""Unit and meaning of a percentile of the pointing error."""
WINDOW_PERCENTILE = ("rad", "Percentile of the pointing error.")
"""Unit and meaning of a percentile of the pointing error in a window."""
WINDOW_RESULTS: dict[str, tuple[str, str, str]] = {
    "error_max": ("rad", "", "Largest pointing error."),
    "error_rms": ("rad", "", "Root mean square of the pointing error."),
    "error_end": ("rad", "", "Pointing error at the last sample."),
    "rotation_max": ("rad", "boresight", "Largest rotation about the boresight."),
    "rotation_rms": ("rad", "boresight", "Root mean square of the rotation about the boresight."),
    "rate_error_max": ("rad/s", "", "Largest body rate relative to the reference."),
    "rate_error_rms": ("rad/s", "", "Root mean square of the body rate relative to the reference."),
    "settling": (
        "s",
        "",
        "Time from the start of the window after which it stays settled until its end, the longest "
        "of all times that the window is entered; none: never.",
    ),
    "smear": (
        "rad",
        "exposure",
        "Largest rotation of the boresight, relative to the reference, within an exposure; none: "
        "the window is shorter.",
    ),
    "jitter": (
        "rad",
        "jitter_above",
        "Root mean square of the pointing error above `jitter_above` and below `jitter_below`.",
    ),
    "dwell": ("1", "dwell_below", "Fraction of time in which any wheel has a speed in the band."),
    "propellant": ("kg", "propellant", "Integral of the signal `propellant`."),
}
"""Metric of a window -> its unit, the key of the window that requests it, and its meaning."""
GAINED = "gained"
"""Beginning of the names of the metrics of the momentum budget; the name of a torque follows."""
BUDGET = ("N·m·s", "Size of the momentum that this external torque adds in the run.")
"""Unit and meaning of a metric of the momentum budget."""
