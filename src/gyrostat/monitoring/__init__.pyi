"""Public names of gyrostat.monitoring; `__init__.py` reads this file."""

from gyrostat.monitoring.blocks import Samples as Samples
from gyrostat.monitoring.health import Health as Health
from gyrostat.monitoring.stream import WheelMonitor as WheelMonitor
from gyrostat.monitoring.wheel_data import KnownWheel as KnownWheel
from gyrostat.monitoring.wheel_data import KnownWheels as KnownWheels
from gyrostat.monitoring.wheels_file import read_wheels as read_wheels
from gyrostat.monitoring.windows import PARAMETERS as PARAMETERS
from gyrostat.monitoring.windows import Windows as Windows
from gyrostat.monitoring.windows import read_windows as read_windows
from gyrostat.monitoring.windows import write_windows as write_windows
