"""Public names of the package; `__init__.py` reads this file."""

from gyrostat.reports.drawing import svg as svg
from gyrostat.reports.evidence import evidence_page as evidence_page
from gyrostat.reports.feasibility import Drawn as Drawn
from gyrostat.reports.feasibility import Question as Question
from gyrostat.reports.feasibility import write_holdable as write_holdable
from gyrostat.reports.fit_charts import friction_charts as friction_charts
from gyrostat.reports.fit_charts import record_charts as record_charts
from gyrostat.reports.fit_charts import residual_charts as residual_charts
from gyrostat.reports.page import fit_page as fit_page
from gyrostat.reports.page import validation_page as validation_page
from gyrostat.reports.recovery import recovery_charts as recovery_charts
from gyrostat.reports.recovery import write_recovery as write_recovery
from gyrostat.reports.sky_map import sky_chart as sky_chart
from gyrostat.reports.template import render as render
from gyrostat.reports.write import write_fit as write_fit
