"""Trial of user-defined objects: in memory, they must do what their texts do."""

from collections.abc import Mapping
from typing import Any

from gyrostat.runs.plans import designs_of
from gyrostat.runs.user.period import traced_period
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario.user.live_calls import comparing


def require_same_traces(scenario: Scenario, live: Mapping[str, Any]) -> None:
    """Trace the first control period, and each call of an object in memory as that of its text.

    Args:
        scenario: Scenario, which was validated.
        live: Kind of a part -> its object in memory.

    Raises:
        UserPartError: A call differs.
    """
    if live:
        with comparing(live):
            traced_period(structure_of(scenario), designs_of(scenario))
