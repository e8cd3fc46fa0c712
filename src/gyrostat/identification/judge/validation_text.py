"""Text of a validation."""

from gyrostat.core.units import RPM
from gyrostat.core.views import lines as text_view
from gyrostat.identification.judge.acceptance_text import acceptance_table
from gyrostat.identification.judge.validation import Validation


@text_view.register(Validation)
def lines(result: Validation) -> list[str]:
    """Lines of a validation, as the command line prints them."""
    found = [
        f"residual {result.rms_speed:.4g} rad/s rms ({result.rms_speed / RPM:.4g} rpm), tachometer "
        f"noise {result.noise:.4g} rad/s, over {result.samples} samples and {result.crossings} "
        "zero crossings",
        result.verdict,
    ]
    if not result.converged:
        found.append("no valid result: found no initial speed that fits the record best")
    return found + ([] if result.acceptance is None else acceptance_table(result.acceptance))
