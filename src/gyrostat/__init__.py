"""Reaction wheels in spacecraft attitude control: identification, estimation, control, simulation.

`import gyrostat as gs` is all that a user needs: the verbs of the command line as functions, and
the parts that a simulation is made of. A name is loaded when it is first used. The rooms, such as
`gyrostat.control`, have further parts.

Inside the package every quantity is in SI units and radians, in float64.
"""

import os
from typing import Any

from gyrostat.core.argument_names import naming_arguments
from gyrostat.core.handed_down import hand_down
from gyrostat.core.lazy import lazy_names

if os.name == "nt":
    raise ImportError(
        "gyrostat: found Windows, expected Linux, or macOS (untested): use the Windows Subsystem "
        "for Linux"
    )

__version__ = "0.1.0"
hand_down(
    replaced="gyrostat.scenario_files.python.changes",
    picture="gyrostat.reports.pictures",
    notebook_html="gyrostat.reports.pictures",
    text_of="gyrostat.reports.texts",
)


def _shown(module: str, value: Any) -> Any:
    return naming_arguments(value) if module == "gyrostat.verbs" else value


__getattr__, __dir__, _NAMES = lazy_names(__name__, _shown)
__all__ = ["__version__", *_NAMES]  # pyright: ignore[reportUnsupportedDunderAll]
