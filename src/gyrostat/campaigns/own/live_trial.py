"""Trial of user-defined objects: in memory, they must do what their texts do."""

from collections.abc import Mapping
from typing import Any

from gyrostat.campaigns.own.live_calls import comparing
from gyrostat.campaigns.own.repeated import traced_period
from gyrostat.campaigns.plans import designs_of
from gyrostat.campaigns.scenario import Scenario
from gyrostat.campaigns.structure import structure_of


def require_same_traces(scenario: Scenario, live: Mapping[str, Any]) -> None:
    """Trace the first control period, and each call of an object in memory as that of its text.

    Args:
        scenario: Scenario, which was validated.
        live: Kind of a part -> its object in memory.

    Raises:
        OwnError: A call differs.
    """
    if live:
        with comparing(live):
            traced_period(structure_of(scenario), designs_of(scenario))
