"""Keys of a scenario file: dimension, default and meaning of each."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import inf, nan, pi

from gyrostat.campaigns.scenario import AXES
from gyrostat.core.units import SI_UNIT
from gyrostat.core.validation import LARGEST


@dataclass(frozen=True)
class Key:
    """A number in a scenario.

    Attributes:
        dimension: key of `gyrostat.core.units.SI_UNIT`, or the SI unit of a plain number.
        default: SI; None where the file must give it.
        meaning: one sentence for the documentation.
        least: smallest value that makes sense.
        most: largest.
        positive: whether `least` itself makes none.
        size: of a vector; 1 for a number.
    """

    dimension: str
    default: float | None
    meaning: str
    least: float = -inf
    most: float = inf
    positive: bool = False
    size: int = 1

    @property
    def unit(self) -> str:
        """SI unit."""
        return SI_UNIT.get(self.dimension, self.dimension)

    def ends(self, name: str) -> tuple[str, ...]:
        """Full keys of a number, or of the components of a vector, that has this key."""
        return (name,) if self.size == 1 else tuple(f"{name}.{axis}" for axis in AXES)

    def allows(self, value: float) -> bool:
        """Whether a value makes sense; NaN does not."""
        inside = self.least <= value <= self.most and not (self.positive and value == self.least)
        return inside and (abs(value) <= LARGEST or value == self.default)

    def range(self, found: float = nan) -> str:
        """What it allows, for a message about a value that was found."""
        unit = "" if self.unit == "1" else f", in {self.unit}"
        if abs(found) > LARGEST:
            return f"a size of {LARGEST:g} or less{unit}"
        if self.least == -inf:
            return f"a finite number{unit}"
        bound = f"above {self.least:g}" if self.positive else f"{self.least:g} or more"
        return f"{bound}{'' if self.most == inf else f', at most {self.most:g}'}{unit}"


def positive(dimension: str, default: float | None, meaning: str) -> Key:
    """A key above 0."""
    return Key(dimension, default, meaning, least=0.0, positive=True)


def size(dimension: str, default: float | None, meaning: str) -> Key:
    """A key of 0 or more."""
    return Key(dimension, default, meaning, least=0.0)


def vector(dimension: str, meaning: str) -> Key:
    """Three components in body axes, by default zero."""
    return Key(dimension, 0.0, meaning, size=3)


RUN: dict[str, Key] = {
    "duration": positive("time", None, "Of a run; a whole number of control periods."),
    "control_period": positive("time", None, "From one sample and command to the next."),
}
START: dict[str, Key] = {
    "attitude_error": vector("angle", "Rotation vector that turns the start away from `attitude`."),
    "rate": vector("speed", "Body rate, in body axes."),
}
METRICS: dict[str, Key] = {
    "after": size("time", 0.0, "Start of the time that error and crossing metrics count."),
    "settled_angle": positive("angle", 0.1 * pi / 180.0, "Pointing error of a settled run."),
    "settled_rate": positive("speed", 0.01 * pi / 180.0, "Body rate of a settled run."),
    "crossing_window": positive(
        "time", 10.0, "After a wheel came to zero speed: whose error counts as its peak."
    ),
}
_TIME = size("time", None, "When it happens.")
_DETECTED = size("time", 1.0, "From then until the controller is told, if it is told.")
_DRAG = size("viscous", 0.0, "Drag added to the bearing.")
_UNTIL = size("time", inf, "When it ends.")
_SHARE = Key("1", 1.0, "Of the samples in this time that are hit, at random.", least=0.0, most=1.0)
MEASURED: dict[str, tuple[str, str | None]] = {
    "attitude": ("1", None),
    "rate": ("speed", "rad/s²"),
    "wheel_speed": ("speed", "rad/s²"),
}
"""Measured field -> its dimension, and the unit of its rate of change; None for a quaternion, which
may change its sign from one sample to the next."""
GUARD: dict[str, Key] = {
    **{f"{n}_lower": Key(d, -inf, "Smallest accepted value.") for n, (d, _) in MEASURED.items()},
    **{f"{n}_upper": Key(d, inf, "Largest accepted value.") for n, (d, _) in MEASURED.items()},
    **{
        f"{name}_change": positive(unit, inf, "Largest accepted rate of change.")
        for name, (_, unit) in MEASURED.items()
        if unit is not None
    },
}
"""Limits of measurements."""
EVENTS: dict[str, tuple[str, dict[str, Key]]] = {
    "slew": ("The controller gets another `target`.", {"time": _TIME}),
    "torque_lost": (
        "The motor of `wheel` gives no more torque; the rotor runs down.",
        {"time": _TIME, "detected_after": _DETECTED, "added_viscous": _DRAG},
    ),
    "stuck_torque": (
        "The motor of `wheel` gives one torque whatever is commanded.",
        {
            "time": _TIME,
            "detected_after": _DETECTED,
            "torque": Key("torque", None, "That it gives."),
        },
    ),
    "seized": (
        "The rotor of `wheel` stops at once and gives its momentum to the body.",
        {"time": _TIME, "detected_after": _DETECTED},
    ),
    "degraded": (
        "The motor of `wheel` gives a share of its torque; the controller is not told.",
        {
            "time": _TIME,
            "torque_share": Key("1", None, "That is left.", least=0.0, most=1.0),
            "added_viscous": _DRAG,
        },
    ),
    "drag": (
        "The bearing of `wheel` gets heavier; the controller is not told.",
        {"time": _TIME, "added_viscous": size("viscous", None, "Drag added to the bearing.")},
    ),
    "friction_step": (
        "The bearing of `wheel` changes: its friction grows by a factor, or any parameter of its "
        "friction model, such as `coulomb`, gets the value that stands here under its name; the "
        "controller is not told.",
        {
            "time": _TIME,
            "factor": size("1", 1.0, "Of friction torques and viscous drag that get no value."),
        },
    ),
    "tachometer_lost": (
        "The speed of `wheel` is no longer measured: the last value stays.",
        {"time": _TIME},
    ),
    "sensor_dropout": (
        "Samples of the measured field `sensor` are missing: the controller gets NaN.",
        {"time": _TIME, "until": _UNTIL, "share": _SHARE},
    ),
    "sensor_spike": (
        "Samples of the measured field `sensor` have `magnitude` added, in the unit of the field.",
        {"time": _TIME, "until": _UNTIL, "share": _SHARE},
    ),
    "sensor_stuck": (
        "The measured field `sensor` keeps its last value.",
        {"time": _TIME, "until": _UNTIL},
    ),
}
"""Kind of event -> what happens, and its numbers."""
WHEEL_IS_LOST = ("torque_lost", "stuck_torque", "seized")
"""Events after which the controller does without the wheel."""
SENSOR_FAULT = "sensor_"
"""Start of the kinds of events that affect a sensor."""


def event_keys(kind: str, sensor: str | None, friction: Mapping[str, str]) -> dict[str, Key]:
    """Numbers of an event; those of the friction model may be left out.

    Args:
        kind: Of the event, key of `EVENTS`.
        sensor: Measured field that it affects, or None.
        friction: Dimensions of the friction model's parameters.
    """
    keys = dict(EVENTS[kind][1])
    if kind == "sensor_spike" and sensor is not None:
        keys["magnitude"] = Key(MEASURED[sensor][0], None, "Added to the value.")
    return keys | (friction_keys(friction) if kind == "friction_step" else {})


WHEEL: dict[str, Key] = {
    "speed": Key("speed", 0.0, "At the start, relative to the body."),
    "inertia": positive("inertia", None, "Of the rotor about its axis."),
    "torque_limit": positive("torque", inf, "Largest motor torque."),
    "momentum_limit": positive("momentum", inf, "Largest inertia times speed."),
}
"""Numbers of each wheel beside its friction; all but the speed from the spacecraft file."""
WHEEL_PARTS: dict[str, tuple[str, dict[str, Key]]] = {
    "imbalance": (
        "Wheels out of balance shake the body (`gyrostat.spacecraft.ImbalancedGyrostat`). Leave "
        "the "
        "section out for balanced wheels.",
        {
            "static_imbalance": size("imbalance", 0.0, "Mass of the rotor times its eccentricity."),
            "dynamic_imbalance": size("inertia", 0.0, "Product of inertia of the rotor."),
            "position": vector("m", "Of the wheel from the centre of mass."),
            "angle": Key("angle", 0.0, "Of the rotor at the start."),
        },
    ),
    "driver": (
        "Electronics between commanded torque and motor (`gyrostat.spacecraft.DrivenGyrostat`). "
        "Leave "
        "the section out for motors that give their torque at once. For a delay see "
        "`run.command_delay`; within a control period the lag is resolved to `run.step`.",
        {
            "motor_constant": positive("motor_constant", None, "Of the motor."),
            "time_constant": size("time", 0.0, "Of the current loop; 0: none."),
            "current_limit": positive("current", inf, "Largest current."),
            "current_quantum": size("current", 0.0, "Step of the commanded current; 0: none."),
            "bus_voltage": positive("V", inf, "That drives the current."),
            "resistance": size("Ω", 0.0, "Of the winding."),
        },
    ),
}
"""Optional section -> what it is for, and its numbers, each one for all wheels or one a wheel."""
WHEEL_ALL = {**WHEEL, **{k: v for _, keys in WHEEL_PARTS.values() for k, v in keys.items()}}
"""Every number of a wheel but those of its friction."""
INERTIA = Key("inertia", None, "Of the body without the rotors' own spin.")
DISTRIBUTIONS: Mapping[str, tuple[str, ...]] = {
    "normal": ("sigma",),
    "uniform": ("low", "high"),
    "log_normal": ("sigma",),
}
"""Distribution -> what it needs."""


def friction_keys(dimensions: Mapping[str, str]) -> dict[str, Key]:
    """Parameters of a friction model, from their dimensions."""
    return {
        name: (positive if dimension == "speed" else size)(dimension, None, "Of its friction.")
        for name, dimension in dimensions.items()
    }


RESULTS: dict[str, tuple[str, str]] = {
    "error_max": ("rad", "Largest pointing error after `metrics.after`."),
    "error_rms": ("rad", "Root mean square of the pointing error after `metrics.after`."),
    "error_end": ("rad", "Pointing error at the end."),
    "settling": ("s", "Time from which error and body rate stay settled to the end; none: never."),
    "crossings": ("1", "How often a wheel came to zero speed after `metrics.after`."),
    "crossing_peak": ("rad", "Largest error within `metrics.crossing_window` of one; none: none."),
    "momentum_peak": ("N·m·s", "Largest momentum of any wheel."),
    "torque_peak": ("N·m", "Largest motor torque commanded to any wheel."),
    "torque_rms": ("N·m", "Root mean square of the commanded motor torques of all wheels."),
    "saturated": ("1", "Share of the time with a wheel at a limit of torque, momentum or driver."),
    "energy": ("J", "Mechanical work of the commanded torques, braking counted as work."),
}
"""Metric -> its unit and meaning; before them stand the percentiles of the pointing error."""


def metric_units(percentiles: Iterable[float]) -> dict[str, str]:
    """Every metric -> its unit; those of these percentiles of the pointing error first."""
    first = {f"error_p{p:g}": "rad" for p in percentiles}
    return first | {name: unit for name, (unit, _) in RESULTS.items()}
