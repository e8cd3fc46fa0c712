"""Designed record as text and as JSON."""

from dataclasses import asdict

from gyrostat.core.text import aligned, or_none, plain
from gyrostat.core.units import si_unit
from gyrostat.core.views import lines as text_view
from gyrostat.identification.experiment.design import Combination, Design

CLEAR = 3.0
"""Significance that the probability of a design refers to."""
HEADER = ("parameter", "estimate", "sigma now", "sigma after", "in 9 of 10 wheels", "unit")


def rows(design: Design) -> list[tuple[str, ...]]:
    """Rows of the table of predicted uncertainty: name, estimate, sigma before and after, unit."""
    every = [*design.wanted, *(p for p in design.parameters if p.name not in design.names)]
    return [
        (
            each.name,
            plain(each.value),
            plain(each.before, 3),
            plain(each.after, 3),
            plain(each.reliable, 3),
            si_unit(each.dimension),
        )
        for each in every
    ]


def _verdict(each: Combination, design: Design) -> str:
    """Whether one combination reaches its target."""
    unit = si_unit(each.dimension)
    if each.target is None:
        return (
            f"{each.name}: sigma {plain(each.reliable, 3)} {unit} or less in 9 of 10 wheels that "
            "agree with the fit"
        )
    if design.reached is not None:
        return f"{each.name}: sigma {plain(each.target, 3)} {unit} after {design.reached:.3g} s"
    return (
        f"{each.name}: sigma {plain(each.target, 3)} {unit} is not reached within "
        f"{design.limits.duration:.3g} s; record longer"
    )


def summary(design: Design) -> list[str]:
    """What the design is and what it reaches, one sentence per line."""
    numbers = ", ".join(f"{name} {plain(value, 3)}" for name, value in design.numbers.items())
    lines = [f"profile of {design.shape.family}, {design.time[-1]:.4g} s ({numbers})"]
    lines += [_verdict(each, design) for each in design.wanted]
    lines += [
        f"{each.name}: {100.0 * each.clear:.0f} % of these wheels end at {CLEAR:g} sigma or more"
        for each in design.wanted
        if each.clear is not None
    ]
    if not design.at_rest:
        return lines
    if design.ripple == 0.0:
        lines.append(
            "no torque ripple is assumed: with one (--ripple), sigma is larger, and breakaways at "
            "different angles reduce it; identify allows for one unless --ripple states it"
        )
        return lines
    size = plain(design.ripple, 2)
    lines.append(
        f"torque ripple of {size} N·m rms, stated or expected from the fit: each breakaway shows "
        f"the static torque at one angle of the rotor; the {design.events:.0f} breakaways of this "
        f"record are worth {design.angles:.2g} at independent angles"
    )
    number = f": the target takes at least {design.needed}" if design.needed else ""
    lines.append(
        f"n breakaways at different angles leave {size} N·m/sqrt(n){number}; turn the wheel "
        "between them; identify allows for a ripple unless --ripple states it"
    )
    return lines


@text_view.register
def table(design: Design) -> list[str]:
    """Lines that the command line prints."""
    return [*summary(design), *(f"  {line}" for line in aligned(rows(design), HEADER))]


def content(design: Design) -> dict[str, object]:
    """Content of the JSON file, SI."""
    limits = {name: or_none(value) for name, value in asdict(design.limits).items()}
    return {
        "family": design.shape.family,
        "numbers": dict(design.numbers),
        "duration": float(design.time[-1]),
        "reached": design.reached,
        "wanted": [asdict(each) for each in design.wanted],
        "parameters": {each.name: asdict(each) for each in design.parameters},
        "history": {"time": design.history[0].tolist(), "sigma": design.history[1].tolist()},
        "breakaways": design.events,
        "independent_breakaways": design.angles,
        "breakaways_needed": design.needed,
        "ripple": design.ripple,
        "speed_sigma": design.speed_sigma,
        "limits": limits,
        "candidates": design.candidates,
    }
