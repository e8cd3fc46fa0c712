"""Draw what each effect leaves in the residuals: python docs/make_effects.py."""

import sys
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from gyrostat.core.units import RPM
from gyrostat.identification import identify
from gyrostat.reports.colours import MARK, MEASURED
from gyrostat.reports.drawing import STYLE

ROOT = Path(__file__).parents[1]
SMOOTHED = 25


def panels() -> dict[str, object]:
    """Title -> residuals of the least-squares fit, rpm, over time, s."""
    sys.path.insert(0, str(ROOT / "benchmarks"))
    from bench_wheels import INERTIA, NOISE_ONLY, STRIBECK_SPEED, records

    base = replace(NOISE_ONLY, speed_sigma=1.0 * RPM)

    def wheel(**effects):
        return records(3, 1, replace(base, **effects), least_rise=1.1)[0][0]

    clean = wheel()
    speed = clean.speed.copy()
    speed[np.random.default_rng(1).integers(0, len(speed), 25)] += 30.0 * RPM
    step = 2.0 * np.pi / 60.0 / 0.1
    limit = np.quantile(np.abs(clean.current), 0.8)
    cases = {
        "none": clean,
        "lag of 80 ms": wheel(lag=0.08),
        "current offset of 1 mA": wheel(offset=1e-3),
        "viscous friction drifts by ±10 %": wheel(drift=0.1),
        "dry friction drifts by ±3 %": wheel(dry_drift=0.03),
        "torque ripple of 10 %": wheel(ripple=0.1),
        "current clipped": replace(clean, current=np.clip(clean.current, -limit, limit)),
        "outliers": replace(clean, speed=speed),
        "60 pulses a turn, counted over 0.1 s": replace(
            clean, speed=step * np.round(clean.speed / step)
        ),
    }
    drawn = {}
    for title, record in cases.items():
        fit = identify(record, inertia=INERTIA, hold={"stribeck_speed": STRIBECK_SPEED})
        plain = identify(
            record, inertia=INERTIA, hold={"stribeck_speed": STRIBECK_SPEED}, white_noise=True
        )
        print(title, "->", [finding.names for finding in fit.findings])
        drawn[title] = (record.time, plain.residuals[0] / RPM)
    return drawn


def main() -> None:
    """Save the figure."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 6.0))
        figure.subplots_adjust(
            left=0.06, right=0.99, bottom=0.075, top=0.955, hspace=0.42, wspace=0.2
        )
        grid = figure.subplots(3, 3, sharex=True)
        for axes, (title, (time, residual)) in zip(grid.flat, panels().items(), strict=True):
            axes.plot(time, residual, ".", ms=1, color=MEASURED, rasterized=True)
            mean = np.convolve(residual, np.full(SMOOTHED, 1.0 / SMOOTHED), mode="same")
            axes.plot(time, mean, color=MARK, lw=0.9)
            reach = 1.1 * float(np.quantile(np.abs(residual), 0.998))
            axes.set_ylim(-max(reach, 4.0), max(reach, 4.0))
            axes.set_title(title, fontsize=9)
        for axes in grid[-1]:
            axes.set_xlabel("time (s)")
        for axes in grid[:, 0]:
            axes.set_ylabel("residual (rpm)")
        path = ROOT / "docs" / "images" / "effects_in_residuals.png"
        figure.savefig(path, dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
