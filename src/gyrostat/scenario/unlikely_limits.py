"""Limits, times and spreads of a scenario that are possible, but unlikely."""

from math import degrees, pi

from gyrostat.core.errors import InputError
from gyrostat.core.text import plain
from gyrostat.scenario.kinds.distributions import distribution_of
from gyrostat.scenario.numbers import Lines, Numbers, check_inertias
from gyrostat.scenario.requirement import INDICES
from gyrostat.scenario.scenario import INERTIA

FASTEST = 0.01
"""Shortest usual time in which a motor takes its wheel from rest to the momentum limit, s."""
MOON = 3.84e8
"""Mean distance of the Moon, m; there is no circular orbit of the Earth beyond."""
SIGMAS = 3.0
"""Deviation of a drawn inertia that is looked at, in standard deviations."""


def _motor(numbers: Numbers) -> Lines:
    """Motors that reach the momentum limit of their wheel in no time."""
    times = numbers.of_wheels("momentum_limit") / numbers.of_wheels("torque_limit")
    for wheel, time in zip(numbers.wheels, times, strict=True):
        if time < FASTEST:
            yield (
                f"wheel.{wheel}.torque_limit",
                f"the motor takes the wheel to momentum_limit in {plain(float(time))} s",
            )


def _altitude(numbers: Numbers) -> Lines:
    """Orbits beyond the Moon."""
    for key, value in numbers.values.items():
        if key.endswith(".altitude") and value > MOON:
            yield key, f"{plain(value / 1e3)} km is beyond the Moon"


def _thresholds(numbers: Numbers) -> Lines:
    """Requirements that no error can violate: a rotation is at most half a turn."""
    for each in numbers.requirements:
        most = pi if INDICES[each.index][1] in ("absolute", "mean") else 2.0 * pi
        if each.value >= most:
            yield (
                f"requirement.{each.name}.value",
                f"{plain(degrees(each.value))} deg cannot be exceeded by {each.index}",
            )


def _delay(numbers: Numbers) -> Lines:
    """Delays as long as the run."""
    delay = numbers.command_delay * numbers.values.get("run.control_period", 0.0)
    if delay and delay >= numbers.values["run.duration"]:
        yield "run.command_delay", f"no command arrives within the run: {plain(delay)} s"


def _inertia(numbers: Numbers) -> Lines:
    """Drawn inertias that no body has, `SIGMAS` from the nominal one."""
    keys = {f"body.inertia.{end}" for end in INERTIA}
    for each in numbers.dispersions:
        for row, key in enumerate(each.keys):
            if key not in keys:
                continue
            ends = distribution_of(each, numbers.values).extremes(SIGMAS)
            for value in (float(end[row]) for end in ends):
                if _is_impossible(numbers, {key: value}):
                    yield (
                        f"dispersion of {key}",
                        f"a draw of {plain(value)} kg·m² is an inertia that no body has",
                    )
                    break


def _is_impossible(numbers: Numbers, draw: dict[str, float]) -> bool:
    try:
        check_inertias({**numbers.values, **draw}, numbers.wheels, numbers.axes)
    except InputError:
        return True
    return False


LIMITS = (_motor, _altitude, _thresholds, _delay, _inertia)
"""Functions of this file, which all give lines."""
