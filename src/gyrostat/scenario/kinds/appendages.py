"""Flexible appendages and propellant of a spacecraft file, with numbers to be dispersed."""

from collections.abc import Mapping

from gyrostat.scenario.kinds.components import Component
from gyrostat.scenario.scenario import INERTIA
from gyrostat.scenario.schema import Key, positive, size, vector
from gyrostat.spacecraft.flexible.appendages import appendage_modes

_COMMON = {
    "frequency": positive("frequency", None, "Frequency on a body at rest."),
    "damping": size("1", 0.0, "Damping ratio on a body at rest."),
}


APPENDAGES: Mapping[str, Component] = {
    "flexible": Component(
        "One vibration mode (`gyrostat.spacecraft.FlexibleModes`).",
        {
            **_COMMON,
            "participation": vector(
                "√kg·m", "Angular momentum about the centre of mass per modal rate, body axes."
            ),
            "translation": vector("√kg", "Linear momentum per modal rate, body axes."),
        },
        appendage_modes,
    ),
    "hinged_panel": Component(
        "Rigid panel on a hinge with a spring (`gyrostat.spacecraft.hinged_panel`).",
        {
            **_COMMON,
            "mass": positive("mass", None, "Mass of the panel."),
            **{
                f"inertia.{end}": Key("inertia", None, "Inertia about its centre of mass.")
                for end in INERTIA
            },
            "hinge": vector("length", "Position of the hinge, body axes."),
            "centre": vector("length", "Centre of mass of the panel, body axes."),
            "axis": vector("1", "Direction of the hinge line, of any length."),
        },
        appendage_modes,
    ),
    "slosh": Component(
        "Propellant as a mass on a spring along a line (`gyrostat.spacecraft.spring_mass`).",
        {
            **_COMMON,
            "mass": positive("mass", None, "Mass that moves."),
            "position": vector("length", "Position of the mass at rest, body axes."),
            "direction": vector("1", "Direction of its motion, of any length."),
        },
        appendage_modes,
    ),
}
"""Kind of appendage, the name of its tables in a spacecraft file -> its keys in a scenario; `make`
takes the kind, the values of its keys and the spacecraft, and returns its modes."""
