"""Public names of gyrostat.monitoring; `__init__.py` reads this file."""

from gyrostat.monitoring.windows import PARAMETERS as PARAMETERS
from gyrostat.monitoring.windows import Windows as Windows
from gyrostat.monitoring.windows import read_windows as read_windows
from gyrostat.monitoring.windows import write_windows as write_windows
