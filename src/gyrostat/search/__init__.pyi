"""Public names of gyrostat.search; `__init__.py` reads this file."""

from gyrostat.search.condition import Condition as Condition
from gyrostat.search.execute import Options as Options
from gyrostat.search.execute import run_search as run_search
from gyrostat.search.rare import RareFailure as RareFailure
from gyrostat.search.rare import found_failures as found_failures
from gyrostat.search.tuning import Tuning as Tuning
from gyrostat.search.tuning import found_tuning as found_tuning
from gyrostat.search.worst_case import WorstCase as WorstCase
from gyrostat.search.worst_case import found_worst as found_worst
