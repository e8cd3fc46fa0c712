"""Public names of gyrostat.scenario_files; `__init__.py` reads this file."""

from gyrostat.scenario_files.scenario_file import read_scenario as read_scenario
