"""Orbits that a scenario can name, one entry each, and the tables along them."""

from collections.abc import Mapping
from dataclasses import replace
from math import tau
from typing import Any

from gyrostat.campaigns.components import Component, Options
from gyrostat.campaigns.scenario import Scenario
from gyrostat.campaigns.schema import Key, positive, size
from gyrostat.campaigns.sensing import Values, options_of
from gyrostat.core.errors import InputError
from gyrostat.spacecraft.orbit.elements import CircularElements, KeplerElements
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.orbit.orbit_file import OrbitFile
from gyrostat.spacecraft.orbit.tables import orbit_environment
from gyrostat.spacecraft.orbit.two_line_elements import TwoLineElements

PHASE = "orbit.phase"
"""Key of the start along the orbit, the only key of an orbit that can be dispersed."""
FRAMES = ("GCRS", "TEME", "ITRF")
"""Frames of the rows of an orbit in a CSV file."""
_INDICES: dict[str, Key] = {
    "phase": Key(
        "angle",
        0.0,
        "Start of the run later by this part of an orbital period, 360 deg for one period; the "
        "Earth and the Sun are those of that time.",
        least=0.0,
        most=tau,
    ),
    "f107": positive("1", 150.0, "Solar radio flux F10.7 of the day before, sfu."),
    "f107a": positive("1", 150.0, "Mean of F10.7 over 81 days, sfu."),
    "ap": size("1", 15.0, "Daily geomagnetic index Ap."),
    "ut1_utc": Key("time", 0.0, "UT1 - UTC.", least=-0.9, most=0.9),
}
_PLANE: dict[str, Key] = {
    "inclination": Key("angle", 0.0, "Inclination to the equator of the GCRS."),
    "ascending_node": Key("angle", 0.0, "Right ascension of the ascending node."),
}


def _named(made: Any) -> Any:
    """Function that makes elements of the options that have their names."""

    def make(options: Options, texts: Mapping[str, str]) -> Any:
        own = {name: float(value) for name, value in options.items() if name not in _INDICES}
        return made(**own)

    return make


ORBITS: dict[str, Component] = {
    "none": Component("No orbit.", {}, lambda options, texts: None),
    "circular": Component(
        "Orbit that is circular at the epoch, with the oblateness J2 of the Earth.",
        {
            "altitude": positive("length", None, "Altitude above the equatorial radius."),
            **_PLANE,
            "latitude": Key("angle", 0.0, "Argument of latitude, from the ascending node."),
            **_INDICES,
        },
        _named(CircularElements),
        texts=("epoch",),
    ),
    "kepler": Component(
        "Orbit from osculating Keplerian elements at the epoch, with the oblateness J2.",
        {
            "semi_major_axis": positive("length", None, "Semi-major axis."),
            "eccentricity": Key("1", 0.0, "Eccentricity, below 1.", least=0.0, most=0.99),
            **_PLANE,
            "perigee": Key("angle", 0.0, "Argument of perigee."),
            "true_anomaly": Key("angle", 0.0, "True anomaly."),
            **_INDICES,
        },
        _named(KeplerElements),
        texts=("epoch",),
    ),
    "tle": Component(
        "Two-line elements by SGP4, from `file` or the text `lines`. The epoch of the run is that "
        "of the elements by default.",
        _INDICES,
        lambda options, texts: TwoLineElements.read(texts["elements"], "key orbit"),
        texts=("epoch", "file", "lines"),
    ),
    "file": Component(
        "Positions and velocities from `file`: CCSDS OEM, or CSV with time, s, position, m, and "
        "velocity, m/s, in the `frame` GCRS (default), TEME or ITRF.",
        _INDICES,
        lambda options, texts: OrbitFile.read(texts["elements"], texts["frame"]),
        texts=("epoch", "file", "frame"),
    ),
}
"""Kinds of [orbit]; `make` takes the options and texts, and returns the definition of an orbit."""


def planned_orbit(scenario: Scenario) -> OrbitEnvironment | None:
    """Tables along the orbit of a scenario; None without an orbit.

    Raises:
        InputError: The orbit is not possible, its file does not cover the run, a library of the
            extra `orbit` is missing, or a key of it other than the phase is dispersed.
    """
    if scenario.orbit == "none":
        return None
    fixed = [key for key in scenario.dispersed if key.startswith("orbit.") and key != PHASE]
    if fixed:
        raise InputError(
            f"key {fixed[0]}: found a dispersion, expected one of {PHASE} only: all runs of a "
            "campaign share the tables of one orbit"
        )
    options = options_of(scenario.values, "orbit")
    texts = {
        text.path.removeprefix("orbit."): text.text
        for text in scenario.texts
        if text.path.startswith("orbit.")
    }
    orbit = ORBITS[scenario.orbit].make(options, texts)
    epoch = texts.get("epoch") or orbit.epoch
    share = 1.0 if PHASE in scenario.dispersed else scenario.values[PHASE] / tau
    later = share * orbit.period
    names = ("f107", "f107a", "ap", "ut1_utc")
    indices = {name: scenario.values[f"orbit.{name}"] for name in names}
    return orbit_environment(orbit, epoch, scenario.duration + later, **indices)[0]


def nominal_orbit(scenario: Scenario) -> OrbitEnvironment | None:
    """Tables of the nominal run, with the splines of the campaign; None without an orbit."""
    planned = planned_orbit(scenario)
    if planned is None:
        return None
    later = scenario.values[PHASE] / tau * float(planned.period)
    return planned.until(scenario.duration + later)


def orbit_of_run(values: Values, planned: OrbitEnvironment | None) -> OrbitEnvironment | None:
    """Orbit of a run, from its phase."""
    if planned is None:
        return None
    return replace(planned, offset=values[PHASE] / tau * planned.period)
